// How much work a deformed mesh is: two factors at the start, one solve for every edit.
#include "batten/core/work.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepare.h"
#include "batten/tests/allocations.h"
#include "batten/tests/catch.h"
#include "batten/tests/mesh_models.h"

using namespace batten;
using namespace batten_test;

TEST_CASE("a deformer factors when it is made, an edit is one solve and no allocation") {
  const MeshModel model = plate_with_holes();
  const TriangleMesh mesh = prepare(model.shells).mesh;
  DeformProblem problem;
  problem.fixed = model.fixed;
  problem.handles = {{"handle", model.handle}};
  for (const auto& f : model.features)
    problem.features.push_back({f.name, f.items, FormFeature::Kind::Free});
  DeformEdit edit;
  edit.handles = {{}};
  edit.handles[0].about = VertexCombination::mean_of(model.handle).at(mesh.points());

  const WorkCount making;
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  INFO(making.text());
  CHECK(making.of(Work::Analysis) == making.of(Work::Factorization));
  CHECK(making.of(Work::Factorization) == 2);
  deformer.deform(edit);

  const WorkCount work;
  constexpr int edits = 5;
  for (int event = 0; event < edits; ++event) {
    edit.handles[0].shift.z() += 0.01;
    deformer.deform(edit);
  }
  const std::int64_t allocations = work.of(Work::Allocation);
  INFO(work.text());
  CHECK(work.of(Work::Solve) == edits);
  CHECK(work.of(Work::Factorization) == 0);
  CHECK(work.of(Work::Analysis) == 0);
  if (counts_allocations()) CHECK(allocations == 0);
}
