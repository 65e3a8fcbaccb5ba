// SPDX-License-Identifier: MPL-2.0
// The polygonal domain with the least distortion of a surface.
#include "batten/skinning/region/polygon_fit.h"

#include <Eigen/Dense>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

// x = A (u, v, 1), over a mesh of the polygon.
Surface plane_over(const std::vector<Vec2>& polygon, const Mat3& A, double edge = 0.15) {
  PlanarMeshInput task;
  task.points = polygon;
  task.edge_length = edge;
  const int n = static_cast<int>(polygon.size());
  for (int i = 0; i < n; ++i) task.outline.push_back({i, (i + 1) % n});
  const auto mesh = std::make_shared<const ParametricMesh>(
      have_delaunay_mesher() ? delaunay_mesh(task) : fan_mesh(task, 3));
  return interpolated(mesh, TriangleElement::HCT, [&](const Vec2& p) {
    return SurfaceJet{A * Vec3(p.x(), p.y(), 1), A.col(0), A.col(1), {}, {}, {}};
  });
}

double angle(const std::vector<Vec2>& p, size_t i) {
  const size_t n = p.size();
  const Vec2 in = p[i] - p[(i + n - 1) % n], out = p[(i + 1) % n] - p[i];
  return 180 - std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)) * 180 / pi;
}

double side(const std::vector<Vec2>& p, size_t i) { return (p[(i + 1) % p.size()] - p[i]).norm(); }

double around(const std::vector<Vec2>& p) {
  double sum = 0;
  for (size_t i = 0; i < p.size(); ++i) sum += side(p, i);
  return sum;
}

// Curves along the sides of (a, b) → P, [0, 1]².
template <class Function>
std::vector<CharacterLine> patch_lines(const Function& P) {
  const auto line = [&](const char* name, const Vec2& from, const Vec2& to) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 100; ++i) {
      const Vec2 p = from + i / 100.0 * (to - from);
      points.push_back(P(p.x(), p.y()));
    }
    return CharacterLine{name, curve_through_points(name, points, 60)};
  };
  return {line("bottom", {0, 0}, {1, 0}), line("right", {1, 0}, {1, 1}),
          line("top", {1, 1}, {0, 1}), line("left", {0, 1}, {0, 0})};
}

struct Settled {
  SkinnedRegion region;
  std::vector<Vec2> polygon;
};
Settled first_shape(const std::vector<CharacterLine>& lines) {
  SkinOptions options;
  if (!have_delaunay_mesher()) options.mesher = SkinOptions::Mesher::Fan;
  const RegionLayout layout("region", lines, options);
  std::vector<Vec2> polygon;
  for (const auto& corner : layout.corners()) polygon.push_back(corner.uv);
  return {layout.region(sculpt(layout, layout.line_constraints(), {}, {}).dofs), polygon};
}

}  // namespace

TEST_CASE("an affine surface flattens to its own outline, whatever its domain, size and position",
          "[skinning][domains]") {
  Mat3 turned = Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const double scale : {1.0, 1e-3, 1e4}) {
    Mat3 A;
    A << 1.7, 0.4, 3, 0.2, 0.8, -1, 0, 0, 0;
    const std::vector<Vec2> domain = {{0, 0}, {1, 0}, {1.2, 0.9}, {0.4, 1.3}, {-0.2, 0.6}};
    const LeastDistortedPolygon f =
        find_least_distorted_polygon(plane_over(domain, scale * turned * A), domain);
    CHECK(f.before.rms > 0.2);
    CHECK(f.before.max_shear == Approx(f.expected.max_shear * f.before.max_shear).epsilon(1e-6));
    CHECK(f.expected.rms < 1e-6);
    CHECK(f.expected.min_area == Approx(1).epsilon(1e-6));
    CHECK(around(f.polygon) == Approx(around(domain)));
    std::vector<Vec2> outline;
    for (const Vec2& p : domain) outline.emplace_back((A * Vec3(p.x(), p.y(), 1)).head<2>());
    for (size_t i = 0; i < domain.size(); ++i) {
      CHECK(angle(f.polygon, i) == Approx(angle(outline, i)).epsilon(1e-6));
      CHECK(side(f.polygon, i) / around(f.polygon) ==
            Approx(side(outline, i) / around(outline)).epsilon(1e-6));
    }
  }
}

TEST_CASE("planar domains stay, reflex corners too", "[skinning][domains]") {
  if (!have_delaunay_mesher()) return;
  const std::vector<Vec2> domain = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
  const LeastDistortedPolygon f =
      find_least_distorted_polygon(plane_over(domain, Mat3::Identity(), 0.2), domain);
  CHECK(f.before.rms < 1e-12);
  CHECK(f.before.max_shear == Approx(1));
  for (size_t i = 0; i < domain.size(); ++i) CHECK((f.polygon[i] - domain[i]).norm() < 1e-9);
}

TEST_CASE("sectors of a cylinder become the rectangle, however far around", "[skinning][domains]") {
  for (const double degrees : {90, 170, 200, 270, 350}) {
    INFO(degrees << " degrees");
    const double T = degrees * pi / 180;
    const Settled s = first_shape(
        patch_lines([&](double a, double b) { return Vec3(std::cos(a * T), std::sin(a * T), b); }));
    REQUIRE(s.polygon.size() == 4);
    CHECK(measure(s.region).min_jacobian_ratio > 0.95);
    const LeastDistortedPolygon f = find_least_distorted_polygon(s.region.surface, s.polygon);
    // The shape of minimum bending energy is not the cylinder: it dents by 1 %, and is shorter by
    // as much.
    CHECK(f.expected.rms < 0.014);
    CHECK(f.expected.rms <= f.before.rms);
    CHECK(f.expected.max_shear < 1.04);
    for (size_t i = 0; i < 4; ++i) CHECK(angle(f.polygon, i) == Approx(90).margin(0.1));
    CHECK(std::max(side(f.polygon, 0), side(f.polygon, 1)) /
              std::min(side(f.polygon, 0), side(f.polygon, 1)) ==
          Approx(T).epsilon(0.02));
  }
}

TEST_CASE("flattening never distorts more, and knows when there is nothing to gain",
          "[skinning][domains]") {
  const auto gain = [](const Settled& s) {
    const LeastDistortedPolygon f = find_least_distorted_polygon(s.region.surface, s.polygon);
    CHECK(f.before.rms == Approx(distortion(s.region.surface).rms));
    CHECK(f.expected.rms <= f.before.rms * (1 + 1e-12));
    return f.before.rms - f.expected.rms;
  };
  // The quarter of a torus has other optimal angles than those between its curves.
  CHECK(gain(first_shape(patch_lines([](double a, double b) {
          const double u = a * pi / 2, v = b * pi / 2, r = 2 + 0.7 * std::cos(v);
          return Vec3(r * std::cos(u), r * std::sin(u), 0.7 * std::sin(v));
        }))) > 0.02);
  const Settled saddle = first_shape(patch_lines([](double a, double b) {
    const double x = 2 * a - 1, y = 2 * b - 1;
    return Vec3(x, y, 0.5 * (x * x - y * y));
  }));
  CHECK(gain(saddle) < 1e-4);
  CHECK(saddle.polygon.size() == 4);
  CHECK(gain(first_shape(curved_polygon(5, 0.35, 0))) < 0.02);
}

TEST_CASE("a degenerate surface keeps its domain, and wrong polygons are reported",
          "[skinning][domains]") {
  const std::vector<Vec2> domain = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  Mat3 A = Mat3::Zero();
  A(0, 0) = 1;
  const LeastDistortedPolygon f = find_least_distorted_polygon(plane_over(domain, A), domain);
  CHECK(f.polygon == domain);
  const Surface sheet = plane_over(domain, Mat3::Identity());
  CHECK_THROWS_WITH(find_least_distorted_polygon(sheet, {{0, 0}, {1, 0}}), Contains("2 corners"));
  CHECK_THROWS_WITH(find_least_distorted_polygon(sheet, {{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}),
                    Contains("not inside"));
}
