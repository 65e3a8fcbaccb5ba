// SPDX-License-Identifier: MPL-2.0
// Fairing a model adds no defects: faces that it would damage keep their shape.
#include "batten/skinning/surfaces/skin_network.h"

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_model_builder.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

void straight(batten_test::TestModelBuilder& p, const std::string& name, const Vec3& a,
              const Vec3& b) {
  p.add(batten_test::prescribed_line(name, curve_through_points(name, {a, b}), 3,
                                     p.options.edge_length));
}

// An octant, and an adjacent quadrilateral with two sides that pass closely over each other.
batten_test::TestModelBuilder octant_and_bow_tie() {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  batten_test::TestModelBuilder p;
  p.options.edge_length = 0.2;
  for (const auto& [name, a, b] :
       {std::tuple<const char*, Vec3, Vec3>{"xy", x, y}, {"yz", y, z}, {"zx", z, x}})
    p.add(batten_test::prescribed_line(name, batten_test::quarter(a, b), 3, p.options.edge_length));
  p.region({"xy", "yz", "zx"});
  const Vec3 corner[4] = {{2, 0, 0}, {3, 0, 0}, {2, 1, 0}, {3, 1, 0.02}};
  for (int k = 0; k < 4; ++k)
    straight(p, "side" + std::to_string(k), corner[k], corner[(k + 1) % 4]);
  p.region({"side0", "side1", "side2", "side3"});
  return p;
}

SurfaceModel model_of(const batten_test::TestModelBuilder& patches, const ModelLayout& layout) {
  SurfaceModel model;
  for (size_t r = 0; r < patches.layouts.size(); ++r) {
    ModelRegion& region = model.regions.emplace_back();
    region.plan.name = layout.region(static_cast<int>(r)).name();
    region.layout_index = static_cast<int>(r);
  }
  return model;
}

}  // namespace

TEST_CASE("a face that would invert keeps its shape, the others are faired",
          "[skinning][surfaces]") {
  const batten_test::TestModelBuilder patches = octant_and_bow_tie();
  const auto layout = std::make_shared<const ModelLayout>(patches.model({}));
  const Points start = layout->minimize_energy({});
  const FairingResult faired = fair_model(model_of(patches, *layout), layout, start, 0.1);
  REQUIRE(faired.unchanged_regions.size() == 1);
  CHECK(faired.unchanged_regions[0].region == 1);
  CHECK_THAT(faired.unchanged_regions[0].why, Contains("is inverted"));
  CHECK(faired.surface.converged);
  CHECK((layout->region_dofs(1, faired.surface.dofs) - layout->region_dofs(1, start)).norm() <
        1e-12);
  const Surface octant = layout->skinned(0, faired.surface.dofs).surface;
  double worst = 0;
  for (int t = 0; t < octant.mesh().triangle_count(); ++t)
    worst = std::max(worst, std::abs(octant.position({t, Vec3::Constant(1.0 / 3)}).norm() - 1));
  CHECK(worst < 1e-3);
}

TEST_CASE("a model of which every face would invert cannot be faired", "[skinning][surfaces]") {
  batten_test::TestModelBuilder patches = octant_and_bow_tie();
  patches.layouts.erase(patches.layouts.begin());
  patches.first.erase(patches.first.begin());
  const auto layout = std::make_shared<const ModelLayout>(patches.model({}));
  const Points start = layout->minimize_energy({});
  CHECK_THROWS_AS(fair_model(model_of(patches, *layout), layout, start, 0.1), NoSolutionError);
}
