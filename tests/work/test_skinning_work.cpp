// SPDX-License-Identifier: MPL-2.0
// Operation counts of skinning: independent of the machine, so that duplicate work fails a test.
#include "batten/benchmarks/cases.h"
#include "batten/core/op_counter.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

SkinOptions edges(double length) {
  SkinOptions options;
  options.edge_length = length;
  return options;
}

std::vector<CharacterLine> pentagon() { return bench::lines_of(bench::pentagon()); }

}  // namespace

TEST_CASE("skinning a pentagon: one mesh, one assembly, one factorization, no filling",
          "[work][skinning]") {
  const ScopedOpCount work;
  const ModelLayout layout(RegionLayout("pentagon", pentagon(), edges(0.2)));
  const Points dofs = layout.minimize_energy({});
  INFO(work.text());
  CHECK(work.of(OpCounter::Triangulation) == 1);
  CHECK(work.of(OpCounter::HoleTriangulation) == 0);
  CHECK(work.of(OpCounter::AssembledElement) == layout.mesh()->triangle_count());
  CHECK(work.of(OpCounter::Analysis) == 1);
  CHECK(work.of(OpCounter::Factorization) == 1);
  CHECK(work.of(OpCounter::Solve) == 1);
}

TEST_CASE("an embedded curve needs one trial shape per iteration, and no second mesh",
          "[work][skinning]") {
  if (!have_delaunay_mesher()) return;
  std::vector<CharacterLine> lines = pentagon();
  lines.push_back({"bow",
                   bezier_curve({-0.4, -0.3, 0.05}, {0, -0.5, 0.1}, {0.3, 0, 0.1}, {0.2, 0.4, 0.1}),
                   CharacterLine::Role::Inner});
  const ScopedOpCount work;
  const RegionLayout layout("pentagon", lines, edges(0.2));
  INFO(work.text());
  CHECK(work.of(OpCounter::Triangulation) == 1);
  CHECK(work.of(OpCounter::HoleTriangulation) == 0);
  CHECK(work.of(OpCounter::Analysis) == work.of(OpCounter::Factorization));
  // The shape of the outline alone, to project the curve, and four evaluations of the gaps.
  CHECK(work.of(OpCounter::Factorization) <= 5);
}

TEST_CASE("measuring a face factors nothing and meshes nothing", "[work][skinning]") {
  const ModelLayout layout(RegionLayout("pentagon", pentagon(), edges(0.2)));
  const Points dofs = layout.minimize_energy({});
  const ScopedOpCount work;
  measure(layout.skinned(0, dofs));
  INFO(work.text());
  CHECK(work.of(OpCounter::Factorization) == 0);
  CHECK(work.of(OpCounter::Triangulation) == 0);
  CHECK(work.of(OpCounter::HoleTriangulation) == 0);
  CHECK(work.of(OpCounter::AssembledElement) == 0);
}

TEST_CASE("a model: one mesh and one shape per face, one factor per group of smooth joins",
          "[work][skinning]") {
  if (!have_delaunay_mesher()) return;
  const std::vector<CharacterLine> lines = bench::wavy_grid(2, 2);
  const CurveNetwork network(lines);
  const FoundRegions found = find_regions(network);
  for (const bool smooth : {false, true}) {
    ModelOptions options;
    options.skin.edge_length = 0.2;
    options.crease_angle_deg = smooth ? 180 : -1;
    const ScopedOpCount work;
    const SurfaceModel model = skin_network(network, found, options);
    INFO(work.text());
    REQUIRE(model.skinned().size() == 4);
    CHECK(work.of(OpCounter::Triangulation) == 4);
    CHECK(work.of(OpCounter::Factorization) == (smooth ? 5 : 4));
    CHECK(work.of(OpCounter::Analysis) == work.of(OpCounter::Factorization));
  }
}
