// SPDX-License-Identifier: MPL-2.0
// Measurement of holes; proposed features and their extent.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/selection.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mesh_models.h"
#include "batten/tests/support/sample_meshes.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;

namespace {

std::vector<int> counted(int n) {
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Points of a circle at uneven angles, clockwise as seen from `axis`.
Points circle(const Vec3& centre, const Vec3& axis, double radius, int n) {
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  Points p(n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = -2 * std::numbers::pi * (i + 0.4 * std::sin(2.5 * i)) / n;
    p.row(i) = (centre + radius * (std::cos(angle) * x + std::sin(angle) * y)).transpose();
  }
  return p;
}

std::vector<int> sorted(std::vector<int> v) {
  std::sort(v.begin(), v.end());
  return v;
}

Selection vertices_with(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& wanted) {
  Selection result;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (wanted(mesh.point(v))) result.push_back(v);
  return result;
}

std::vector<int> triangles_between(const TriangleMesh& mesh, double low, double high,
                                   const std::function<double(const Vec3&)>& at) {
  std::vector<int> result;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const int v : mesh.triangles()[t]) centre += mesh.point(v) / 3;
    if (at(centre) > low && at(centre) < high) result.push_back(t);
  }
  return result;
}

TriangleMesh flipped_orientation(const TriangleMesh& mesh) {
  auto triangles = mesh.triangles();
  for (auto& t : triangles) std::swap(t[1], t[2]);
  return {mesh.points(), triangles};
}

double radius_of(const Vec3& p) { return p.head<2>().norm(); }

}  // namespace

TEST_CASE("circles in space are measured to rounding", "[mesh][features]") {
  const Vec3 centre(1000, -200, 30), axis = Vec3(1, 2, -2) / 3;
  for (const int n : {5, 8, 41}) {
    const Points p = circle(centre, axis, 12.5, n);
    const HoleMeasure hole = measure_hole(p, counted(n));
    CHECK((hole.centre - centre).norm() < 1e-14 * 1000);
    CHECK(std::abs(hole.radius - 12.5) < 1e-14 * 1000);
    CHECK((hole.axis - axis).norm() < 1e-13);
    CHECK(hole.roundness < 1e-12);
    CHECK(hole.flatness < 1e-12);
    CHECK(hole.circular);
    // Reversed, the axis changes its sign.
    std::vector<int> reversed = counted(n);
    std::reverse(reversed.begin(), reversed.end());
    CHECK((measure_hole(p, reversed).axis + axis).norm() < 1e-13);
  }
  const HoleMeasure unit = measure_hole(circle(Vec3::Zero(), axis, 1, 40), counted(40));
  CHECK(std::abs(unit.radius - 1) < 1e-14);
  CHECK(unit.centre.norm() < 1e-14);
}

TEST_CASE("the circle of a rough loop is the one of least squares", "[mesh][features]") {
  Random random(3);
  Points p = circle(Vec3(1, 2, 3), Vec3(0, 0, 1), 4, 60);
  for (int i = 0; i < 60; ++i) p.row(i) += 0.3 * Vec3(random(), random(), 0).transpose();
  const HoleMeasure hole = measure_hole(p, counted(60));
  double sum = 0, worst = 0, length = 0;
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < 60; ++i) {
    const Vec3 x = p.row(i).transpose() - hole.centre, next = p.row((i + 1) % 60).transpose();
    const double off = x.norm() - hole.radius;
    sum += off;
    moment += off * x.normalized();
    worst = std::max(worst, std::abs(off));
    length += (next - p.row(i).transpose()).norm();
  }
  CHECK(std::abs(sum) < 1e-6);
  CHECK(moment.norm() < 1e-6);
  CHECK(hole.roundness == Approx(worst).epsilon(1e-9));
  CHECK(hole.perimeter == Approx(length).epsilon(1e-12));
  CHECK(hole.flatness < 1e-12);
  CHECK_FALSE(hole.circular);
  CHECK(measure_hole(p, counted(60), 0.5).circular);
  p.col(2) += 0.1 * p.col(0).cwiseProduct(p.col(1));  // saddle
  CHECK(measure_hole(p, counted(60)).flatness > 0.1);
}

TEST_CASE("loops that are no circles are reported", "[mesh][features]") {
  Points square(4, 3), slender(40, 3);
  square << 0, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0;
  CHECK_FALSE(measure_hole(square, counted(4)).circular);
  CHECK(measure_hole(square, counted(4)).radius == Approx(std::sqrt(0.5)));
  CHECK(measure_hole(square, counted(4)).equivalent_radius ==
        Approx(std::sqrt(1 / std::numbers::pi)));
  // Along a short arc of a large circle and back.
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.01 * (i < 20 ? i : 39 - i), r = i < 20 ? 100 : 100.5;
    slender.row(i) << r * std::cos(angle), r * std::sin(angle), 0;
  }
  CHECK_FALSE(measure_hole(slender, counted(40)).circular);
  CHECK(measure_hole(Points::Zero(5, 3), counted(5)).radius == 0);
  CHECK_FALSE(measure_hole(Points::Zero(5, 3), counted(5)).circular);
  CHECK(error_message([&] {
          measure_hole(square, {0, 1});
        }) == "a hole has 2 vertices, expected three or more");
  CHECK(error_message([&] {
          measure_hole(square, {0, 1, 4});
        }).find("vertex 4") != std::string::npos);
  square(2, 0) = std::nan("");
  CHECK(error_message([&] { measure_hole(square, counted(4)); }).find("finite") !=
        std::string::npos);
}

TEST_CASE("the axis of a hole is on the side of the mesh's normals, before and after",
          "[mesh][features]") {
  const TriangleMesh mesh = revolved_profile({{3, 0}, {2, 0}, {1, 0}}, 12);
  const auto holes = detect_features(mesh);
  REQUIRE(holes.size() == 1);
  CHECK((holes[0].measure.axis - Vec3(0, 0, 1)).norm() < 1e-14);
  CHECK((detect_features(flipped_orientation(mesh))[0].measure.axis + Vec3(0, 0, 1)).norm() <
        1e-14);
  const Mat3 rotation = Eigen::AngleAxisd(2.5, Vec3(1, 0.2, 0).normalized()).toRotationMatrix();
  const HoleMeasure after = measure_hole(mesh.points() * rotation.transpose(), holes[0].loop);
  CHECK((after.axis - rotation.col(2)).norm() < 1e-14);
}

TEST_CASE("the forms of the models are proposed, whole and nothing else", "[mesh][features]") {
  struct Case {
    std::string name;
    MeshModel model;
  };
  for (const Case& c : {Case{"door panel", door_panel()}, Case{"grill", grill()},
                        Case{"sheet with cavities", sheet_with_cavities()},
                        Case{"holed panel", holed_panel(3300)}, Case{"panel", panel()}}) {
    INFO(c.name);
    const TriangleMesh mesh = prepare(c.model.shells).mesh;
    Random random(5);
    Points rough = mesh.points();
    for (int v = 0; v < mesh.vertex_count(); ++v) rough.row(v) += 0.02 * random.point().transpose();
    for (const TriangleMesh& shape : {mesh, flipped_orientation(mesh), mesh.with_points(rough)}) {
      const auto proposals = detect_features(shape);
      REQUIRE(proposals.size() == c.model.features.size());
      for (const NamedSet& feature : c.model.features) {
        const auto found = std::find_if(
            proposals.begin(), proposals.end(),
            [&](const DetectedFeature& p) { return p.vertices == sorted(feature.items); });
        INFO(feature.name);
        CHECK(found != proposals.end());
      }
    }
  }
}

TEST_CASE("names follow the lowest vertex of the loop, holes first", "[mesh][features]") {
  const auto proposals = detect_features(prepare(panel().shells).mesh);
  int holes = 0, creases = 0, last = -1;
  for (const DetectedFeature& p : proposals) {
    const bool hole = p.kind == DetectedFeature::Kind::Hole;
    CHECK_FALSE((hole && creases > 0));
    CHECK(p.name ==
          (hole ? "hole-" + std::to_string(++holes) : "crease-" + std::to_string(++creases)));
    if (!hole && creases == 1) last = -1;
    CHECK(p.loop.front() > last);
    CHECK(p.loop.front() == *std::min_element(p.loop.begin(), p.loop.end()));
    last = p.loop.front();
  }
  CHECK(holes == 6);
  CHECK(creases == 1);
}

TEST_CASE("holes without a flange have one ring, or the width asked for", "[mesh][features]") {
  const TriangleMesh mesh = revolved_profile(subdivided({{5, 0}, {1, 0}}, 0.5), 16);
  auto holes = detect_features(mesh);
  REQUIRE(holes.size() == 1);
  CHECK_FALSE(holes[0].flange_ends_at_crease);
  CHECK(holes[0].vertices == vertices_with(mesh, [](const Vec3& p) { return radius_of(p) < 1.6; }));
  CHECK(holes[0].measure.radius == Approx(1));
  FeatureDetectionOptions wide;
  wide.flange_width = 1.3;
  CHECK(detect_features(mesh, wide)[0].vertices ==
        vertices_with(mesh, [](const Vec3& p) { return radius_of(p) < 2.1; }));
  FeatureDetectionOptions all;
  all.outer_loops = true;
  CHECK(detect_features(mesh, all).size() == 2);
  // Each part of the mesh has its own outer loop; closed parts have none.
  CHECK(detect_features(disjoint_union(disjoint_union(mesh, mesh), sphere(3))).size() == 2);
}

TEST_CASE("a flange ends at its outermost crease, a hole in a cavity at its own",
          "[mesh][features]") {
  // A dimple with steps around the hole, then a wide cavity.
  const std::vector<Vec2> corners = {{20, 0}, {12, 0}, {11, -2}, {5, -2}, {4, -3}, {3, -3}};
  const TriangleMesh mesh = revolved_profile(subdivided(corners, 0.5), 48);
  FeatureDetectionOptions options;
  options.flange_rings = 6;
  const auto proposals = detect_features(mesh, options);
  REQUIRE(proposals.size() == 2);
  CHECK(proposals[0].vertices ==
        vertices_with(mesh, [](const Vec3& p) { return radius_of(p) < 4 + 1e-9; }));
  CHECK(proposals[0].flange_ends_at_crease);
  CHECK(proposals[1].vertices ==
        vertices_with(mesh, [](const Vec3& p) { return radius_of(p) < 12 + 1e-9; }));
  CHECK(proposals[1].measure.radius == Approx(12));
  CHECK((proposals[1].measure.axis - Vec3(0, 0, 1)).norm() < 1e-12);
  // With a large limit, the flange is the whole cavity as one feature.
  options.flange_rings = 40;
  CHECK(detect_features(mesh, options).size() == 1);
  CHECK(detect_features(mesh, options)[0].vertices == proposals[1].vertices);
}

TEST_CASE("nested creases are one feature, or one each when asked for", "[mesh][features]") {
  const TriangleMesh mesh =
      revolved_profile(subdivided({{20, 0}, {12, 0}, {12, 2}, {6, 2}, {6, 4}, {0, 4}}, 1), 32);
  const auto outermost = detect_features(mesh);
  REQUIRE(outermost.size() == 1);
  const auto inside = [&](double radius, double height) {
    return vertices_with(
        mesh, [&](const Vec3& p) { return radius_of(p) < radius + 1e-9 && p.z() > height - 1e-9; });
  };
  CHECK(outermost[0].vertices == inside(12, 0));
  CHECK(outermost[0].loop.size() == 32);
  FeatureDetectionOptions options;
  options.nested = true;
  std::vector<std::vector<int>> found;
  for (const auto& p : detect_features(mesh, options)) found.push_back(p.vertices);
  REQUIRE(found.size() == 4);
  CHECK(found ==
        std::vector<std::vector<int>>{inside(12, 0), inside(12, 2), inside(6, 2), inside(6, 4)});
}

TEST_CASE("panels within a flange are no feature, rings and bosses on them are",
          "[mesh][features]") {
  // A flange with a step; a groove around it; a boss in the middle.
  const TriangleMesh mesh = revolved_profile(
      subdivided({{30, -4}, {27, -4}, {27, 0}, {20, 0}, {19, -1}, {18, 0}, {5, 0}, {5, 1}, {0, 1}},
                 0.7),
      64);
  auto proposals = detect_features(mesh);
  // The groove includes everything inside of it: one feature up to its outer crease.
  REQUIRE(proposals.size() == 1);
  CHECK(proposals[0].measure.radius == Approx(20));
  const TriangleMesh plain =
      revolved_profile(subdivided({{30, -4}, {27, -4}, {27, 0}, {5, 0}, {5, 1}, {0, 1}}, 0.7), 64);
  proposals = detect_features(plain);
  REQUIRE(proposals.size() == 1);
  CHECK(proposals[0].measure.radius == Approx(5));
}

TEST_CASE("creases that do not close and single vertices propose nothing", "[mesh][features]") {
  const TriangleMesh flat = revolved_profile(subdivided({{20, 0}, {8, 0}, {6, 0}, {0, 0}}, 1), 48);
  const auto raised = [&](double lowest) {
    Points p = flat.points();
    for (int v = 0; v < flat.vertex_count(); ++v) {
      const Vec3 at = flat.point(v);
      const double around =
          lowest + (1 - lowest) * 0.5 * (1 - std::cos(std::atan2(at.y(), at.x())));
      p(v, 2) = 2 * around * std::clamp((8 - radius_of(at)) / 2, 0.0, 1.0);
    }
    return flat.with_points(p);
  };
  CHECK(detect_features(raised(0.5)).size() == 1);
  CHECK(detect_features(raised(0.0)).empty());

  TriangleMesh spike = flat_square(20, 0.1, 3);
  Points p = spike.points();
  p(10 * 21 + 10, 2) = 0.05;
  spike = spike.with_points(p);
  CHECK(detect_features(spike).empty());
  FeatureDetectionOptions options;
  options.min_triangles = 1;
  CHECK(detect_features(spike, options).size() == 1);
  options.crease_degrees = 0;
  CHECK(error_message([&] { detect_features(spike, options); }).find("crease angle of 0") !=
        std::string::npos);
}

TEST_CASE("real panels: thirteen rimmed holes, and a body side's openings", "[mesh][features]") {
  const auto support = optional_data("panel-bottle-support/W1000BO_pid_1_a_tri.obj");
  const auto side = optional_data("panel-neon-side/neon_side.off");
  if (support.empty() || side.empty()) {
    WARN("skipped: the real panels are not there (set BATTEN_TEST_DATA)");
    return;
  }
  const auto holes = detect_features(prepare(read_shells(support)).mesh);
  REQUIRE(holes.size() == 13);
  int small = 0, large = 0;
  for (const DetectedFeature& p : holes) {
    CHECK(p.kind == DetectedFeature::Kind::Hole);
    CHECK(p.measure.circular);
    CHECK(p.measure.roundness < 0.01);
    CHECK(p.flange_ends_at_crease);
    CHECK(p.vertices.size() == 16);  // one row of elements
    small += std::abs(p.measure.radius - 20.72) < 0.01;
    large += std::abs(p.measure.radius - 25.03) < 0.01;
  }
  CHECK(small == 6);
  CHECK(large == 7);

  const auto openings = detect_features(prepare(read_shells(side)).mesh);
  REQUIRE(openings.size() == 3);
  std::vector<int> lengths;
  for (const DetectedFeature& p : openings) {
    lengths.push_back(static_cast<int>(p.loop.size()));
    CHECK_FALSE(p.measure.circular);
  }
  CHECK(sorted(lengths) == std::vector<int>{40, 310, 326});
}

TEST_CASE("the cut around a boss is the circle where it meets the plate, on every mesh",
          "[mesh][features]") {
  const double radius = 5;
  double last = 0;
  for (const double h : {1.0, 0.5, 0.25}) {
    const int n = static_cast<int>(2 * std::numbers::pi * radius / h);
    const TriangleMesh mesh =
        revolved_profile(subdivided({{15, 0}, {radius, 0}, {radius, 4}, {0, 4}}, h), n);
    const std::vector<int> band = triangles_between(mesh, 2, 11, [](const Vec3& p) {
      return std::max(0.0, radius_of(p) - 5) + 4 - p.z();  // along the profile, from the top
    });
    const FeatureCut cut = cut_feature(mesh, band);
    REQUIRE(cut.chains.size() == 1);
    CHECK(cut.chains[0].closed);
    CHECK(sorted(cut.chains[0].vertices) == vertices_with(mesh, [](const Vec3& p) {
            return p.z() < 1e-9 && radius_of(p) < 5 + 1e-9;
          }));
    CHECK(cut.vertices ==
          vertices_with(mesh, [](const Vec3& p) { return radius_of(p) < 5 + 1e-9; }));
    CHECK(vertices_of_triangles(mesh.topology(), cut.triangles) == cut.vertices);
    // The cost belongs to the crease, not to its number of edges; the mean dihedral angle of the
    // band is proportional to h, and so is the cost.
    const double fraction = cut.cost / mesh.length(cut.chains[0].vertices);
    CHECK(fraction < (last > 0 ? 0.7 * last : 0.2));
    last = fraction;
    // The chain runs with the plate on its left: clockwise around the boss.
    const auto& loop = cut.chains[0].vertices;
    CHECK(mesh.point(loop[0]).cross(mesh.point(loop[1])).z() < 0);
  }
}

TEST_CASE("which creases attract the cut is settable, and turns round with the mesh",
          "[mesh][features]") {
  const TriangleMesh mesh =
      revolved_profile(subdivided({{15, 0}, {5, 0}, {5, 4}, {0, 4}}, 0.5), 64);
  const std::vector<int> band = triangles_between(
      mesh, 1.5, 12, [](const Vec3& p) { return radius_of(p) + (p.z() < 3.99 ? 4 - p.z() : 0); });
  const auto height = [](const TriangleMesh& m, const FeatureCut& cut) {
    REQUIRE(cut.chains.size() == 1);
    return m.point(cut.chains[0].vertices[0]).z();
  };
  CHECK(height(mesh, cut_feature(mesh, band)) == Approx(0).margin(1e-12));
  CHECK(height(mesh, cut_feature(mesh, band, {0.2, 1, -1})) == Approx(4));
  const TriangleMesh below = flipped_orientation(mesh);
  CHECK(height(below, cut_feature(below, band)) == Approx(4));
  CHECK(height(below, cut_feature(below, band, {0.2, 1, -1})) == Approx(0).margin(1e-12));
}

TEST_CASE("the feature is the smaller side, or the one named", "[mesh][features]") {
  const TriangleMesh mesh =
      revolved_profile(subdivided({{15, 0}, {5, 0}, {5, 4}, {0, 4}}, 0.5), 64);
  const std::vector<int> band =
      triangles_between(mesh, 4.9, 12, [](const Vec3& p) { return radius_of(p); });
  const FeatureCut boss = cut_feature(mesh, band);
  const FeatureCut plate = cut_feature(mesh, band, {1, 0.2, 0});
  CHECK(boss.cost == Approx(plate.cost).epsilon(1e-12));
  CHECK(boss.triangles.size() + plate.triangles.size() == mesh.triangles().size());
  CHECK(intersection_of(boss.vertices, plate.vertices) == sorted(boss.chains[0].vertices));
  CHECK(cut_feature(mesh, band, {1, 0.2, mesh.vertex_count() - 1}).triangles == boss.triangles);
}

TEST_CASE("the cut is the cheapest of all cuts", "[mesh][features]") {
  // Exhaustive search over all subsets of the band, with a reference implementation of the cost.
  int checked = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const int n = 6;
    TriangleMesh mesh = revolved_profile({{5, 0}, {4, 0}, {3, 0}, {2, 0}, {0, 0}}, n);
    Points p = mesh.points();
    for (int v = 0; v < mesh.vertex_count(); ++v) p.row(v) += 0.6 * random.point().transpose();
    mesh = mesh.with_points(p);
    const MeshTopology& topology = mesh.topology();
    std::vector<int> band, number(mesh.triangle_count(), -1);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const auto& v = mesh.triangles()[t];
      if (std::all_of(v.begin(), v.end(), [&](int i) { return i >= n && i < 3 * n; })) {
        number[t] = static_cast<int>(band.size());
        band.push_back(t);
      }
    }
    REQUIRE(band.size() == 12);
    const CutOptions options{1, 0.3, mesh.vertex_count() - 1};
    struct Pair {
      int a, b;
      double length, d;
    };
    std::vector<Pair> pairs;
    double mean = 0;
    for (const auto& e : topology.edges()) {
      if (e.left < 0 || e.right < 0 || (number[e.left] < 0 && number[e.right] < 0)) continue;
      const Vec3 along = mesh.point(e.high) - mesh.point(e.low);
      const Vec3 l = mesh.area_vector(e.left).normalized(),
                 r = mesh.area_vector(e.right).normalized();
      // The left triangle runs along the edge; in a concave surface the rotation from its normal to
      // that of the right triangle is against the direction of the edge.
      const double angle = std::atan2(r.cross(l).dot(along.normalized()), l.dot(r));
      const double d = (angle > 0 ? options.concave : options.convex) * (1 - std::cos(angle));
      pairs.push_back({e.left, e.right, along.norm(), d});
      mean += d;
    }
    mean /= static_cast<double>(pairs.size());
    double best = 1e300;
    unsigned best_set = 0;
    const auto inside = [&](int t, unsigned set) {
      if (number[t] >= 0) return (set >> number[t] & 1) != 0;
      const auto& v = mesh.triangles()[t];
      return std::all_of(v.begin(), v.end(), [&](int i) { return i >= 2 * n; });
    };
    for (unsigned set = 0; set < 1u << band.size(); ++set) {
      double cost = 0;
      for (const Pair& pair : pairs)
        if (inside(pair.a, set) != inside(pair.b, set)) cost += pair.length / (1 + pair.d / mean);
      if (cost < best) {
        best = cost;
        best_set = set;
      }
    }
    const FeatureCut cut = cut_feature(mesh, band, options);
    CHECK(cut.cost == Approx(best).epsilon(1e-12));
    std::vector<int> expected;
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (inside(t, best_set)) expected.push_back(t);
    CHECK(cut.triangles == expected);
    ++checked;
  }
  CHECK(checked == 12);
}

TEST_CASE("in a flat band the shortest cut wins, from border to border, too", "[mesh][features]") {
  // An hourglass: the minimum is in the middle.
  const int n = 24;
  TriangleMesh mesh = flat_square(n, 0, 3);
  Points p = mesh.points();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double x = p(v, 0) - 0.5;
    p(v, 1) *= 0.3 + 2 * x * x;
  }
  mesh = mesh.with_points(p);
  const std::vector<int> band =
      triangles_between(mesh, 0.2, 0.7, [](const Vec3& at) { return at.x(); });
  const FeatureCut cut = cut_feature(mesh, band);
  REQUIRE(cut.chains.size() == 1);
  CHECK_FALSE(cut.chains[0].closed);
  CHECK(cut.chains[0].vertices.size() == static_cast<size_t>(n + 1));
  for (const int v : cut.chains[0].vertices) CHECK(mesh.point(v).x() == Approx(0.5));
  CHECK(cut.cost == Approx(0.3));

  // Rounding in a file is not a bend.
  for (int v = 0; v < mesh.vertex_count(); ++v) p(v, 2) += 1e-7 * (v * 7919 % 11);
  CHECK(cut_feature(mesh.with_points(p), band).triangles == cut.triangles);
}

TEST_CASE("bands that do not separate exactly two sides are refused with what was found",
          "[mesh][features]") {
  const TriangleMesh mesh = flat_square(10, 0, 3);
  const auto refused = [&](const TriangleMesh& m, const std::vector<int>& band,
                           const CutOptions& options = {}) {
    return error_message([&] { cut_feature(m, band, options); });
  };
  const auto x = [](const Vec3& at) { return at.x(); };
  CHECK(refused(mesh, {}) == "the band has no triangles, expected one or more");
  CHECK(refused(mesh, {7, 200}) == "found triangle 200 of the band, expected 0 to 199");
  CHECK(refused(mesh, counted(200)) ==
        "the band covers the whole part of the mesh, expected it to separate 2 parts");
  CHECK(refused(mesh, {0, 1}) == "the band separates 1 part of 198 triangles, expected 2");
  std::vector<int> strips = triangles_between(mesh, 0.2, 0.3, x);
  CHECK(refused(mesh, strips).empty());
  for (const int t : triangles_between(mesh, 0.6, 0.8, x)) strips.push_back(t);
  CHECK(refused(mesh, strips) ==
        "the band separates 3 parts of 40, 60 and 40 triangles, expected 2");
  const TriangleMesh two = disjoint_union(mesh, mesh);
  CHECK(refused(two, triangles_between(mesh, 0.2, 0.3, x)).empty());  // other part: no side
  CHECK(refused(two, triangles_between(two, 0.2, 0.3, x)).find("lie in parts of the mesh") !=
        std::string::npos);

  const std::vector<int> band = triangles_between(mesh, 0.2, 0.5, x);
  CHECK(refused(mesh, band, {1, 0.2, 3}) ==
        "vertex 3 lies on neither side of the band, expected on the feature's side");
  CHECK(refused(mesh, band, {1, 0.2, 121}).find("121") != std::string::npos);
  CHECK(refused(mesh, band, {-1, 0.2, 0}).find("weight -1") != std::string::npos);
  CHECK(refused(mesh, band, {1, 0.2, 2}).empty());
}
