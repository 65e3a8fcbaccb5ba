// SPDX-License-Identifier: MPL-2.0
// Faces that continue given surfaces: holes in surfaces with a formula, filled with tangent planes
// and curvature.
#include <algorithm>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/shapes/fair_shape.h"
#include "batten/skinning/surfaces/build_model.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/given_surfaces.h"

using namespace batten;
using namespace batten_test;

namespace neighbour_tests {

struct Filled {
  SurfaceModel model;
  double angle_deg = 0, mean_deg = 0, curvature_jump = 0;
  int smooth = 0;
};

Filled filled(const Hole& hole, JoinSpec::Kind kind, bool fair = true) {
  ModelBuildOptions options;
  options.model.neighbours = hole.neighbours;
  options.model.neighbour_tolerance = 1e-3;
  for (const CharacterLine& line : hole.lines) options.model.joins.push_back({line.name, kind, ""});
  Filled result;
  BuiltModel built = build_model(hole.lines, options);
  result.model = std::move(built.model);
  if (fair) {
    const FairShape shape =
        compute_fair_shape(result.model, result.model.layout, result.model.dofs, {}, {});
    REQUIRE(shape.dofs.rows() > 0);
    std::vector<SkinnedRegion> made;
    for (int r = 0; r < shape.layout->region_count(); ++r)
      made.push_back(shape.layout->skinned(r, shape.dofs));
    reshape(result.model, shape.layout, shape.dofs, std::move(made));
  }
  for (const ModelJoin& join : result.model.joins) {
    result.smooth += join.kind == ModelJoin::Kind::Smooth && !join.open[0] && !join.open[1];
    result.angle_deg = std::max(result.angle_deg, join.max_inside_deg);
    result.mean_deg = std::max(result.mean_deg, join.mean_deg);
    result.curvature_jump = std::max(result.curvature_jump, join.median_curvature_jump);
  }
  return result;
}

double farthest(const SurfaceModel& model, const GivenSurface& from) {
  double most = 0;
  for (const SkinnedRegion* region : model.skinned()) {
    const Surface& surface = region->surface;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t)
      if (!surface.trim() || surface.trim()->side(t) == Trim::Side::Inside)
        most = std::max(most, from.distance(surface.position({t, Vec3::Constant(1.0 / 3)})));
  }
  return most;
}

}  // namespace neighbour_tests

using namespace neighbour_tests;

TEST_CASE("a hole in a sphere, a cylinder and a torus is filled with the same surface",
          "[skinning][surfaces][neighbours]") {
  for (const GivenSurface& surface : {given_sphere(), given_cylinder(), given_torus()})
    for (const int sides : {1, 2, 3, 4, 5, 8}) {
      CAPTURE(sides);
      const Filled patch = filled(hole_in(surface, sides), JoinSpec::Kind::Tangent);
      // The end of an arc in an embedding face may be a crease.
      CHECK(patch.smooth >= sides - (sides == 2));
      CHECK(patch.angle_deg < 0.1);
      CHECK(patch.mean_deg < 0.05);
      CHECK(farthest(patch.model, surface) < 1e-3);  // the hole has the diameter 1
      CHECK(patch.model.defects.empty());
    }
}

TEST_CASE("continuous curvature reduces the jump of curvature to a tenth of that of tangency",
          "[skinning][surfaces][neighbours]") {
  for (const int sides : {1, 4, 6}) {
    CAPTURE(sides);
    const Hole hole = hole_in(given_waves(), sides);
    const Filled tangent = filled(hole, JoinSpec::Kind::Tangent),
                 curvature = filled(hole, JoinSpec::Kind::Curvature);
    CHECK(curvature.angle_deg < 0.1);
    CHECK(curvature.curvature_jump < 0.1 * tangent.curvature_jump);
    CHECK(curvature.curvature_jump < 0.02);  // the curvature beside the hole is up to 0.9
  }
}

TEST_CASE("tangent planes hold exactly at the vertices of the elements",
          "[skinning][surfaces][neighbours]") {
  const Filled patch = filled(hole_in(given_waves(), 4), JoinSpec::Kind::Tangent);
  const std::vector<const SkinnedRegion*> made = patch.model.skinned();
  for (const JoinPlan& plan : patch.model.layout->join_plans()) {
    const JoinQuality at_vertices = measure_join(made, plan.join_line, {}, 1),
                      along = measure_join(made, plan.join_line);
    CHECK(at_vertices.max_deg < 1e-3);  // the ends: the planes of curves that are fitted
    CHECK(at_vertices.mean_deg < 1e-5);
    CHECK(along.max_deg > at_vertices.max_deg);
  }
}

TEST_CASE("an edge that lies apart from the given surface is a free edge",
          "[skinning][surfaces][neighbours]") {
  Hole hole = hole_in(given_sphere(), 4);
  for (NeighbourSample& sample : hole.neighbours[2].samples) sample.point.z() += 0.01;
  const Filled patch = filled(hole, JoinSpec::Kind::Tangent, false);
  CHECK(patch.smooth == 3);
  REQUIRE(patch.model.joins.size() == 4);
  for (const ModelJoin& join : patch.model.joins) {
    const bool apart = join.line == "side3";
    CHECK(static_cast<bool>(join.neighbour) == !apart);
    CHECK(join.kind == (apart ? ModelJoin::Kind::FreeEdge : ModelJoin::Kind::Smooth));
  }
}

TEST_CASE("without a statement, an edge at a right angle to the given surface is a crease",
          "[skinning][surfaces][neighbours]") {
  // A flat square between vertical walls.
  Hole hole;
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (size_t k = 0; k < 4; ++k) {
    const Vec3 &a = corners[k], &b = corners[(k + 1) % 4];
    hole.lines.push_back({"side" + std::to_string(k + 1), curve_through_points("side", {a, b})});
    NeighbourCurve& wall = hole.neighbours.emplace_back();
    wall.name = "wall";
    for (int i = 0; i <= 10; ++i)
      wall.samples.push_back({a + i * (b - a) / 10, Vec3(0, 0, -1), Vec3::Zero()});
  }
  ModelBuildOptions options;
  options.model.neighbours = hole.neighbours;
  const BuiltModel built = build_model(hole.lines, options);
  for (const ModelJoin& join : built.model.joins) {
    REQUIRE(join.neighbour);
    CHECK(join.kind == ModelJoin::Kind::FreeEdge);
    CHECK(join.max_deg > 89.9);
  }
  for (const SkinnedRegion* region : built.model.skinned())
    CHECK(region->surface.area() == Approx(1).epsilon(1e-9));
}
