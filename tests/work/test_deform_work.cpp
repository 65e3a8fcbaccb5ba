// SPDX-License-Identifier: MPL-2.0
// Operation counts of a mesh deformation: two factors at the start, one solve per edit.
#include "batten/core/op_counter.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten_test;

TEST_CASE("a deformer factors when it is made, an edit is one solve and no allocation",
          "[work][deform]") {
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

  const ScopedOpCount making;
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  INFO(making.text());
  CHECK(making.of(OpCounter::Analysis) == making.of(OpCounter::Factorization));
  CHECK(making.of(OpCounter::Factorization) == 2);
  deformer.deform(edit);

  const ScopedOpCount work;
  constexpr int edits = 5;
  for (int event = 0; event < edits; ++event) {
    edit.handles[0].translation.z() += 0.01;
    deformer.deform(edit);
  }
  const std::int64_t allocations = work.of(OpCounter::Allocation);
  INFO(work.text());
  CHECK(work.of(OpCounter::Solve) == edits);
  CHECK(work.of(OpCounter::Factorization) == 0);
  CHECK(work.of(OpCounter::Analysis) == 0);
  if (counts_allocations()) CHECK(allocations == 0);
}
