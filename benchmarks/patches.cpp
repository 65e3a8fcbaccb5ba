// SPDX-License-Identifier: MPL-2.0
// Holes in given surfaces, filled with tangent planes (G1) and with curvature (G2): Batten and
// OpenCASCADE's filling. The distance is that of the filling from the surface that was cut out,
// over the diameter of the hole. Times: from the boundary to the surface, including meshing.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "batten/skinning/shapes/fair_shape.h"
#include "batten/skinning/surfaces/build_model.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/given_surfaces.h"
#include "bench.h"
#include "occ_tangent_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;
using batten_test::GivenSurface;
using batten_test::Hole;

constexpr double kRadius = 0.5;

struct Case {
  std::string name;
  GivenSurface surface;
  bool cyclide = false;  // the filling has to reproduce it
};

std::vector<Case> cases() {
  const auto ellipsoid = [](double u, double v) {
    const double r = std::hypot(u, v), c = r > 1e-12 ? std::sin(r) / r : 1;
    return Vec3(1.5 * c * u, c * v, 0.7 * std::cos(r));
  };
  const auto saddle = [](double u, double v) { return Vec3(u, v, 0.3 * (u * u - v * v)); };
  return {{"sphere", batten_test::given_sphere(), true},
          {"cylinder", batten_test::given_cylinder(), true},
          {"torus", batten_test::given_torus(), true},
          {"ellipsoid", {ellipsoid, {}}},
          {"saddle", {saddle, {}}},
          {"waves", batten_test::given_waves()}};
}

// Distance from a surface by its formula, from the closest of many points by Newton's method.
double distance(const GivenSurface& surface, const Vec3& p) {
  constexpr int n = 20;
  double u = 0, v = 0, least = 1e100;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      if (const double d = (surface.x(1.0 * i / n, 1.0 * j / n) - p).norm(); d < least) {
        least = d;
        u = 1.0 * i / n;
        v = 1.0 * j / n;
      }
  for (int round = 0; round < 20; ++round) {
    Eigen::Matrix<double, 3, 2> X;
    X << surface.derivative(u, v, 1, 0), surface.derivative(u, v, 0, 1);
    const Vec2 step = (X.transpose() * X).inverse() * (X.transpose() * Vec3(surface.x(u, v) - p));
    u -= step[0];
    v -= step[1];
  }
  return std::min(least, (surface.x(u, v) - p).norm());
}

struct Result {
  double distance = 0, max_deg = 0, mean_deg = 0, jump = 0, seconds = 0;
  bool done = false;
};

Result fill(const GivenSurface& surface, const Hole& hole, JoinSpec::Kind kind) {
  ModelBuildOptions options;
  options.model.neighbours = hole.neighbours;
  options.model.neighbour_tolerance = 1e-3;
  for (const CharacterLine& line : hole.lines) options.model.joins.push_back({line.name, kind, ""});
  Result result;
  SurfaceModel model;
  result.seconds = wall_seconds_of([&] {
    model = build_model(hole.lines, options).model;
    const FairShape shape = compute_fair_shape(model, model.layout, model.dofs, {}, {});
    if (shape.dofs.rows() == 0) return;
    std::vector<SkinnedRegion> made;
    for (int r = 0; r < shape.layout->region_count(); ++r)
      made.push_back(shape.layout->skinned(r, shape.dofs));
    reshape(model, shape.layout, shape.dofs, std::move(made));
  });
  result.done = model.defects.empty();
  for (const ModelJoin& join : model.joins) {
    result.done = result.done && join.kind == ModelJoin::Kind::Smooth;
    result.max_deg = std::max(result.max_deg, join.max_inside_deg);
    result.mean_deg = std::max(result.mean_deg, join.mean_deg);
    result.jump = std::max(result.jump, join.median_curvature_jump);
  }
  for (const SkinnedRegion* region : model.skinned())
    for (int t = 0; t < region->surface.mesh().triangle_count(); ++t)
      if (!region->surface.trim() || region->surface.trim()->side(t) == Trim::Side::Inside)
        result.distance =
            std::max(result.distance,
                     distance(surface, region->surface.position({t, Vec3::Constant(1.0 / 3)})));
  result.distance /= 2 * kRadius;
  return result;
}

Result occ_fill(const GivenSurface& surface, const Hole& hole, int order) {
  constexpr int n = 60;
  std::vector<Vec3> grid;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) grid.push_back(surface.x(2.0 * i / n - 1, 2.0 * j / n - 1));
  std::vector<std::vector<Vec3>> sides;
  for (const NeighbourCurve& neighbour : hole.neighbours) {
    std::vector<Vec3>& side = sides.emplace_back();
    for (size_t i = 0; i < neighbour.samples.size(); i += 10)
      side.push_back(neighbour.samples[i].point);
  }
  Result result;
  std::unique_ptr<OccTangentFilling> filling;
  result.seconds = wall_seconds_of(
      [&] { filling = std::make_unique<OccTangentFilling>(grid, n + 1, sides, order); });
  if (!filling->error_message().empty()) return result;
  result.done = true;
  result.max_deg = filling->max_deg();
  result.mean_deg = filling->mean_deg();
  for (const Vec3& p : filling->points(24))
    result.distance = std::max(result.distance, distance(surface, p));
  result.distance /= 2 * kRadius;
  return result;
}

std::string shown(const Result& result) {
  return result.done ? text("%.1e", result.distance) : "failed";
}
std::string angles(const Result& result) {
  return result.done ? text("%.3f (%.3f)", result.max_deg, result.mean_deg) : "";
}

}  // namespace

int main() {
  Table table;
  table.add({"surface", "sides", "G1: distance", "G2", "filling G1", "G2", "degrees G1 (mean)",
             "filling", "jump G1", "G2", "s", "filling, s"});
  Checks checks;
  double worst_cyclide = 0, worst_deg = 0, worst_mean = 0, worst_ratio = 0, worst_jump = 0;
  int failed = 0, closer = 0, closer_with_curvature = 0, compared = 0;
  for (const Case& c : cases())
    for (const int sides : {1, 2, 3, 4, 5, 6, 8}) {
      const Hole hole = batten_test::hole_in(c.surface, sides, kRadius);
      const Result tangent = fill(c.surface, hole, JoinSpec::Kind::Tangent),
                   curvature = fill(c.surface, hole, JoinSpec::Kind::Curvature),
                   occ = occ_fill(c.surface, hole, 1), occ2 = occ_fill(c.surface, hole, 2);
      table.add({c.name, std::to_string(sides), shown(tangent), shown(curvature), shown(occ),
                 shown(occ2), angles(tangent), angles(occ), text("%.1e", tangent.jump),
                 text("%.1e", curvature.jump), text("%.2f", tangent.seconds),
                 text("%.2f", occ.seconds)});
      failed += !tangent.done + !curvature.done;
      if (c.cyclide) worst_cyclide = std::max(worst_cyclide, tangent.distance);
      worst_deg = std::max({worst_deg, tangent.max_deg, curvature.max_deg});
      worst_mean = std::max({worst_mean, tangent.mean_deg, curvature.mean_deg});
      if (!c.cyclide) worst_ratio = std::max(worst_ratio, curvature.jump / tangent.jump);
      worst_jump = std::max(worst_jump, curvature.jump);
      ++compared;
      closer += !occ.done || tangent.distance < occ.distance;
      closer_with_curvature += !occ2.done || curvature.distance < occ2.distance;
    }
  table.print();
  std::printf("with tangent planes (G1), closer than OpenCASCADE's filling in %d of %d cases\n\n",
              closer, compared);
  checks.at_most("failed fillings", failed, 0);
  checks.at_most("sphere, cylinder, torus: distance over the diameter", worst_cyclide, 1e-3);
  checks.at_most("largest angle, degrees", worst_deg, 0.1);
  checks.at_most("largest mean angle, degrees", worst_mean, 0.05);
  checks.at_most("jump of curvature, G2 over G1 (not cyclides)", worst_ratio, 0.1);
  checks.at_most("jump of curvature with G2, over that of the unit sphere", worst_jump, 0.02);
  checks.at_least("closer than OpenCASCADE's filling with curvature (G2)", closer_with_curvature,
                  compared);
  checks.print("patches");
}
