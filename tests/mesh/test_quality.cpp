// SPDX-License-Identifier: MPL-2.0
// Element quality of elements with known values.
#include "batten/mesh/element_quality.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten_test;

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

/// One face with its nodes in order.
ShellMesh single(const std::vector<Vec3>& p, bool second_order = false) {
  ShellMesh shells;
  shells.points.resize(static_cast<int>(p.size()), 3);
  std::vector<int> nodes;
  for (size_t i = 0; i < p.size(); ++i) {
    shells.points.row(static_cast<int>(i)) = p[i].transpose();
    nodes.push_back(static_cast<int>(i));
  }
  shells.add_face(nodes, second_order);
  return shells;
}

ElementQuality quality(const std::vector<Vec3>& p, bool second_order = false) {
  const ShellMesh shells = single(p, second_order);
  return quality_of(shells, shells.points, 0);
}

/// Another position and size: measures are invariant.
std::vector<Vec3> moved(std::vector<Vec3> p) {
  const Eigen::AngleAxisd rotation(1.1, Vec3(1, -2, 0.5).normalized());
  for (Vec3& x : p) x = 37 * (rotation * x) + Vec3(100, -20, 5);
  return p;
}

ShellMesh shells_of(const TriangleMesh& mesh) {
  ShellMesh shells;
  shells.points = mesh.points();
  for (const auto& t : mesh.triangles()) shells.add_face(t);
  return shells;
}

}  // namespace

TEST_CASE("regular polygons are perfect", "[mesh][quality]") {
  for (int k = 3; k <= 8; ++k) {
    std::vector<Vec3> p;
    for (int i = 0; i < k; ++i) {
      const double angle = 2 * std::numbers::pi * i / k;
      p.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    const ElementQuality q = quality(moved(p));
    CHECK(q.aspect == Approx(1).epsilon(1e-12));
    CHECK(q.jacobian == Approx(1).epsilon(1e-12));
    CHECK(q.warpage_degrees < 1e-5);
    CHECK(q.smallest_angle_degrees == Approx(180.0 * (k - 2) / k).epsilon(1e-12));
    CHECK(q.largest_angle_degrees == Approx(180.0 * (k - 2) / k).epsilon(1e-12));
  }
}

TEST_CASE("aspect and angles of triangles and parallelograms", "[mesh][quality]") {
  const ElementQuality right = quality(moved({{0, 0, 0}, {4, 0, 0}, {0, 3, 0}}));
  CHECK(right.aspect == Approx(std::sqrt(0.75) * 5 / 2.4));
  CHECK(right.smallest_angle_degrees ==
        Approx(std::atan2(3, 4) * 180 / std::numbers::pi).epsilon(1e-12));
  CHECK(right.largest_angle_degrees == Approx(90));
  CHECK(right.jacobian == 1);
  CHECK(right.warpage_degrees == 0);

  CHECK(quality(moved({{0, 0, 0}, {6, 0, 0}, {6, 2, 0}, {0, 2, 0}})).aspect == Approx(3));
  // Sheared by 45 degrees: edges 6 and 2 √2, widths 2 and 6/√2.
  const ElementQuality sheared = quality(moved({{0, 0, 0}, {6, 0, 0}, {8, 2, 0}, {2, 2, 0}}));
  CHECK(sheared.jacobian == Approx(1).epsilon(1e-12));
  CHECK(sheared.smallest_angle_degrees == Approx(45));
  CHECK(sheared.largest_angle_degrees == Approx(135));
  CHECK(sheared.aspect == Approx(3));
}

TEST_CASE("warpage is the angle between the halves", "[mesh][quality]") {
  for (const double h : {0.0, 0.05, 0.3, 1.0}) {
    const ElementQuality q = quality(moved({{0, 0, 0}, {1, 0, h}, {1, 1, 0}, {0, 1, h}}));
    const double exact = std::acos((1 - 2 * h * h) / (1 + 2 * h * h)) * 180 / std::numbers::pi;
    CHECK(std::abs(q.warpage_degrees - exact) < 1e-6);
  }
  // One corner up: the halves at one diagonal differ by 60 degrees, at the other by 54.7.
  CHECK(quality({{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}}).warpage_degrees == Approx(60));
  CHECK(quality({{1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {0, 0, 0}}).warpage_degrees == Approx(60));
}

TEST_CASE("the Jacobian of a quad with a corner pushed in", "[mesh][quality]") {
  for (const double t : {0.0, 0.2, 0.4, 0.5, 0.6}) {
    const ElementQuality q = quality(moved({{t, t, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    CHECK(std::abs(q.jacobian - (1 - 2 * t)) < 1e-12);
    CHECK((q.largest_angle_degrees > 180 + 1e-6) == (t > 0.5));
    if (t > 0.5) CHECK(q.warpage_degrees == Approx(180));
  }
  const double bow_tie = quality({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).jacobian;
  CHECK(bow_tie <= 0);
}

TEST_CASE("faces of second order are measured at all their nodes", "[mesh][quality]") {
  // x = ξ + c ξ², y = η: both elements reproduce quadratics, J = 1 + 2 c ξ.
  const auto at = [](double xi, double eta, double c) { return Vec3(xi + c * xi * xi, eta, 0); };
  for (const double c : {0.0, 0.2, -0.3}) {
    const double triangle[6][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}};
    const double quad[8][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1},
                               {0, -1},  {1, 0},  {0, 1}, {-1, 0}};
    std::vector<Vec3> s6, s8;
    for (const auto& [xi, eta] : triangle) s6.push_back(at(xi, eta, c));
    for (const auto& [xi, eta] : quad) s8.push_back(at(xi, eta, c));
    const double J[] = {1 + 2 * c, 1 - 2 * c};
    CHECK(quality(moved(s6), true).jacobian ==
          Approx(std::min(1.0, J[0]) / std::max(1.0, J[0])).epsilon(1e-12));
    CHECK(quality(moved(s8), true).jacobian ==
          Approx(std::min(J[0], J[1]) / std::max(J[0], J[1])).epsilon(1e-12));
  }
  // A mid-side node at a quarter of its edge: the Jacobian is zero at the corner.
  CHECK(std::abs(
            quality({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.25, 0, 0}, {.5, .5, 0}, {0, .5, 0}}, true)
                .jacobian) < 1e-15);
  // Aspect ratio and angles are those of the corners.
  CHECK(quality({{0, 0, 0},
                 {2, 0, 0},
                 {2, 1, 0},
                 {0, 1, 0},
                 {1, .1, 0},
                 {2, .5, 0},
                 {1, 1, 0},
                 {0, .5, 0}},
                true)
            .aspect == Approx(2));
}

TEST_CASE("collapsed and flattened faces", "[mesh][quality]") {
  ShellMesh shells = single({{0, 0, 0}, {4, 0, 0}, {0, 3, 0}});
  shells.add_face(std::vector<int>{0, 1, 2, 2});
  shells.add_face(std::vector<int>{0, 0, 1, 2});
  shells.add_face(std::vector<int>{0, 1, 1, 0});
  const ElementQuality triangle = quality_of(shells, shells.points, 0);
  for (const int f : {1, 2}) {
    const ElementQuality q = quality_of(shells, shells.points, f);
    CHECK(q.aspect == triangle.aspect);
    CHECK(q.largest_angle_degrees == triangle.largest_angle_degrees);
    CHECK(q.jacobian == 1);
  }
  CHECK(std::isinf(quality_of(shells, shells.points, 3).aspect));
  CHECK(quality_of(shells, shells.points, 3).jacobian == 0);
  const ElementQuality flat = quality({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}});
  CHECK(flat.jacobian == 0);
  CHECK(flat.aspect > 1e12);
}

TEST_CASE("summaries: worst, mean, count, and what is not a number is worst", "[mesh][quality]") {
  ShellMesh shells;
  shells.points.resize(8, 3);
  shells.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 7, 0, 0, 7, 1, 0, 7, 2, 0, 1, 2, 0;
  shells.add_face(std::vector<int>{0, 1, 2, 3});  // aspect 1
  shells.add_face(std::vector<int>{1, 4, 5, 2});  // aspect 6
  shells.add_face(std::vector<int>{2, 5, 6, 7});  // aspect 6
  const QualitySummary s = summarize(shells, shells.points);
  CHECK(s.faces == 3);
  CHECK(s.aspect.worst == Approx(6));
  CHECK(s.aspect.worst_face == 1);
  CHECK(s.aspect.mean == Approx(13.0 / 3));
  CHECK(s.aspect.violations == 2);
  CHECK(s.jacobian.worst == Approx(1));
  CHECK(s.jacobian.violations == 0);
  CHECK(s.smallest_angle_degrees.worst == Approx(90));
  QualityLimits strict;
  strict.aspect = 0.5;
  strict.largest_angle_degrees = 80;
  CHECK(summarize(shells, shells.points, strict).aspect.violations == 3);
  CHECK(summarize(shells, shells.points, strict).largest_angle_degrees.violations == 3);

  Points broken = shells.points;
  broken(6, 1) = kNotANumber;
  const QualitySummary b = summarize(shells, broken);
  for (const MeasureSummary& m : {b.aspect, b.warpage_degrees, b.jacobian, b.smallest_angle_degrees,
                                  b.largest_angle_degrees}) {
    CHECK(std::isnan(m.worst));
    CHECK(m.worst_face == 2);
    CHECK(m.violations >= 1);
    CHECK(std::isfinite(m.mean));
  }
  CHECK(b.aspect.mean == Approx(3.5));
  CHECK(summarize(ShellMesh(), Points(0, 3)).aspect.worst_face == -1);
  CHECK(error_message([&] { summarize(shells, Points::Zero(7, 3)); }) ==
        "element quality: found 7 points for 8 nodes, expected one for each");
}

TEST_CASE("folds are found where the flat area changes its sign", "[mesh][quality]") {
  const TriangleMesh mesh = flat_square(12, 0.2, 7);
  const ShellMesh shells = shells_of(mesh);
  int found = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.topology().on_boundary(v)) continue;
    // Beyond the opposite edge in its first triangle, by a small distance.
    const int t = mesh.topology().triangles_of(v)[0];
    Vec3 centre = Vec3::Zero();
    for (const int i : mesh.triangles()[t])
      if (i != v) centre += 0.5 * mesh.point(i);
    Points after = mesh.points();
    after.row(v) += 1.1 * (centre - mesh.point(v)).transpose();
    const TriangleMesh bent = mesh.with_points(after);
    std::vector<int> turned;
    for (int i = 0; i < mesh.triangle_count(); ++i)
      if (bent.area_vector(i).z() < 0) turned.push_back(i);
    if (turned.size() != 1) continue;  // several neighbours: their common edges are not folds
    ++found;
    CHECK(inverted_faces(shells, mesh.points(), after) == turned);
  }
  CHECK(found > 50);
}

TEST_CASE("rigid motions, bending and other windings invert nothing", "[mesh][quality]") {
  const TriangleMesh mesh = flat_square(12, 0.2, 7);
  ShellMesh shells = shells_of(mesh);
  const Mat3 rotation = Eigen::AngleAxisd(3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  CHECK(inverted_faces(shells, mesh.points(), mesh.points() * rotation).empty());
  Points rolled = mesh.points();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double x = 5 * mesh.point(v).x();
    rolled.row(v) << 0.2 * std::sin(x), mesh.point(v).y(), 0.2 * std::cos(x);
  }
  CHECK(inverted_faces(shells, mesh.points(), rolled).empty());
  // At a fold along a line of edges, both faces of an edge are reported.
  Points folded = mesh.points();
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.point(v).y() > 1 - 0.5 / 12) folded(v, 1) -= 1.2 / 12;
  const std::vector<int> turned = inverted_faces(shells, mesh.points(), folded);
  CHECK(turned.size() >= 12);

  ShellMesh mixed;
  mixed.points = mesh.points();
  for (size_t t = 0; t < mesh.triangles().size(); ++t) {
    auto corners = mesh.triangles()[t];
    if (t % 3 == 0) std::swap(corners[0], corners[1]);
    mixed.add_face(corners);
  }
  CHECK(inverted_faces(mixed, mesh.points(), rolled).empty());
  CHECK(inverted_faces(mixed, mesh.points(), folded) == turned);
}

TEST_CASE("quads that fold in themselves, lost areas and lost numbers are inverted",
          "[mesh][quality]") {
  const ShellMesh shells = single({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  Points after = shells.points;
  after.row(0) << 0.7, 0.7, 0;
  CHECK(inverted_faces(shells, shells.points, after) == std::vector<int>{0});
  CHECK(inverted_faces(shells, after, after).empty());  // unchanged
  after.row(0) << kNotANumber, 0, 0;
  CHECK(inverted_faces(shells, shells.points, after) == std::vector<int>{0});
  const ShellMesh triangle = single({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  Points line = triangle.points;
  line.row(2) << 0.5, 0, 0;
  CHECK(inverted_faces(triangle, triangle.points, line) == std::vector<int>{0});
}

TEST_CASE("elements that were bad before are not inverted by the edit", "[mesh][quality]") {
  // A straight corner, whose Jacobian is 0 up to rounding of either sign.
  for (const double before : {1e-16, 1e-12, -1e-12, 1e-9}) {
    const ShellMesh shells = single({{0, 0, 0}, {1, -before, 0}, {2, 0, 0}, {2, 2, 0}});
    Points after = shells.points;
    after(1, 1) = before;
    CHECK(inverted_faces(shells, shells.points, after).empty());
  }
  // A hexahedron with one corner pushed in, and moved back a little; then a second one pushed in.
  NonShellElement solid{NonShellElement::Kind::Solid, "CHEXA", 1, {0, 1, 2, 3, 4, 5, 6, 7}, {}};
  Points before(8, 3);
  before << 0.9, 0.9, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1;
  Points after = before;
  after.row(0) << 0, 0, 0;
  const std::vector<NonShellElement> solids{solid};
  CHECK(inverted_solids(solids, before, after).empty());
  CHECK(inverted_solids(solids, after, before) == std::vector<int>{0});
  after = before;
  after.row(6) << 0.1, 0.1, 0.9;
  CHECK(inverted_solids(solids, before, after) == std::vector<int>{0});
}
