// SPDX-License-Identifier: MPL-2.0
// Hole-filling triangulations of loops, and the domains from unfolding them.
#include <numbers>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/domains/hole_triangulation.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_lines.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
using Domain = SkinOptions::Domain;

SkinnedRegion solved(const RegionLayout& layout) {
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  const ConstrainedSolver solver(layout.line_constraints(),
                                 assembler.stiffness(SurfaceStiffness{}));
  return layout.region(solver.solve(Points::Zero(assembler.dofs().count(), 3)));
}

// Derivatives by fourth-order central differences.
std::shared_ptr<const InputCurve> formula(double a, double b, std::function<Vec3(double)> f) {
  return curve_from_formula(a, b, [f](double t, int order) -> Vec3 {
    constexpr double h = 1e-3;
    if (order == 0) return f(t);
    if (order == 1) return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h);
    return (16 * (f(t + h) + f(t - h)) - (f(t + 2 * h) + f(t - 2 * h)) - 30 * f(t)) / (12 * h * h);
  });
}

std::vector<Vec3> sampled(const std::function<Vec3(double)>& f, int n) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back(f(2 * pi * i / n));
  return points;
}

// Two meridians of the unit sphere at this distance.
std::vector<CharacterLine> lune(double degrees) {
  const double a = degrees * pi / 180;
  return {{"a", formula(0, pi, [](double t) { return Vec3(std::sin(t), 0, -std::cos(t)); })},
          {"b", formula(0, pi, [a](double t) {
             return Vec3(std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), -std::cos(t));
           })}};
}

// The outline of a strip with round ends, `length` long between their centres, bent around a
// cylinder of radius 1 by `bend` radians per length.
std::vector<CharacterLine> stadium(double length, double radius, double bend) {
  const double L = length, r = radius;
  const auto onto = [bend](double x, double y) {
    return bend > 0 ? Vec3(std::sin(bend * x) / bend, (1 - std::cos(bend * x)) / bend, y)
                    : Vec3(x, 0, y);
  };
  const auto round = [=](double x0, double from) {
    return formula(from, from + pi,
                   [=](double t) { return onto(x0 + r * std::cos(t), r * std::sin(t)); });
  };
  return {{"lower", formula(0, L, [=](double x) { return onto(x, -r); })},
          {"end", round(L, -pi / 2)},
          {"upper", formula(0, L, [=](double x) { return onto(L - x, r); })},
          {"start", round(0, pi / 2)}};
}

// ½ ∮ c × c' over the pcurves of the outline.
double domain_area(const RegionLayout& layout) {
  double area = 0;
  for (const EmbeddedLine& line : layout.embedded())
    for (int s = 0; s < line.pcurve.segment_count(); ++s)
      for (int k = 0; k < 50; ++k) {
        const CurveMesh::SegmentPoint at{s, (k + 0.5) / 50};
        const Vec3 c = line.pcurve.evaluate(at), d = line.pcurve.evaluate(at, 1);
        area += 0.5 * (c.x() * d.y() - c.y() * d.x()) * line.pcurve.mesh().length(s) / 50;
      }
  return area;
}

}  // namespace

TEST_CASE("fillings of plane loops have the loop's area and side", "[skinning][domains]") {
  const auto star = [](double t) {
    const double r = 1 + 0.4 * std::cos(5 * t);
    return Vec3(r * std::cos(t), 2, r * std::sin(t));
  };
  const auto loop = sampled(star, 60);
  Vec3 area = Vec3::Zero();
  for (size_t i = 0; i < loop.size(); ++i) area += 0.5 * loop[i].cross(loop[(i + 1) % loop.size()]);
  for (const auto& fill : {triangulate_hole(loop), developable_triangulation(loop)}) {
    if (!fill) continue;  // a build without CGAL
    CHECK(fill->triangles.size() == loop.size() - 2);
    CHECK(fill->area == Approx(area.norm()).epsilon(1e-12));
    CHECK((fill->area_vector - area).norm() < 1e-12);
    CHECK(fill->max_dihedral_deg < 1e-6);
    // Every side of the loop once, in its direction.
    std::vector<int> sides(loop.size(), 0);
    for (const auto& t : fill->triangles)
      for (int i = 0; i < 3; ++i)
        if (t[(i + 1) % 3] == (t[i] + 1) % static_cast<int>(loop.size()))
          ++sides[static_cast<size_t>(t[i])];
    CHECK(std::all_of(sides.begin(), sides.end(), [](int n) { return n == 1; }));
  }
}

TEST_CASE("a developable filling of a strip around a cylinder is the cylinder",
          "[skinning][domains]") {
  for (const double degrees : {60.0, 180.0, 320.0}) {
    INFO(degrees);
    const double a = degrees * pi / 180;
    std::vector<Vec3> loop;
    constexpr int n = 40;
    for (int i = 0; i <= n; ++i) loop.emplace_back(std::cos(a * i / n), std::sin(a * i / n), -0.4);
    for (int i = n; i >= 0; --i) loop.emplace_back(std::cos(a * i / n), std::sin(a * i / n), 0.4);
    const auto fill = developable_triangulation(loop);
    REQUIRE(fill);
    CHECK(fill->area == Approx(0.8 * a).epsilon(0.002));
    CHECK(fill->max_dihedral_deg < 1.01 * degrees / n);
    for (size_t i = 0; i < loop.size(); ++i) {
      const Vec3 n_i = triangulation_corners(loop, *fill)[i].normal.normalized();
      CHECK(std::abs(n_i.dot(Vec3(loop[i].x(), loop[i].y(), 0))) > 0.99);
    }
  }
}

TEST_CASE("fillings refuse invalid loops", "[skinning][domains]") {
  using Loop = std::vector<Vec3>;
  for (const auto fill : {&triangulate_hole, &developable_triangulation}) {
    CHECK_THROWS_AS(fill(Loop{{0, 0, 0}, {1, 0, 0}}), InputError);
    CHECK_THROWS_AS(fill(Loop{{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}}), InputError);
    CHECK_THROWS_AS(fill(Loop(401, Vec3(0, 0, 0))), InputError);
    CHECK_FALSE(fill(Loop{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}));
  }
}

TEST_CASE("a planar loop is its own developable domain", "[skinning][domains]") {
  // Rotated away from the axes; the pcurve is congruent to the loop over its size.
  const Vec3 e1 = Vec3(1, 2, -1).normalized(), e2 = e1.unitOrthogonal();
  const auto heart = formula(0, 2 * pi, [&](double t) {
    const double r = 1 + 0.3 * std::cos(2 * t) + 0.2 * std::sin(3 * t);
    return Vec3(r * std::cos(t) * e1 + r * std::sin(t) * e2);
  });
  SkinOptions options;
  options.domain = Domain::Developable;
  const RegionLayout layout("r", {{"line", heart}}, options);
  const SkinnedRegion region = solved(layout);
  const SkinQuality quality = measure(region);
  CHECK(quality.max_shear < 1.06);
  CHECK(quality.min_jacobian_ratio > 0.94);
  CHECK(quality.max_line_gap < layout.tolerance());
  CHECK(domain_area(layout) * layout.size() * layout.size() == Approx(quality.area).epsilon(2e-3));
  const Vec3 n = e1.cross(e2), up = region.surface.jet(region.surface.locate({0, 0})).normal();
  CHECK(up.dot(n) == Approx(1));
}

TEST_CASE("developable strips unfold to their own outline, however far they are bent",
          "[skinning][domains]") {
  // A strip bent around a cylinder keeps its area and its length.
  for (const double degrees : {0.0, 120.0, 200.0, 270.0}) {
    INFO(degrees);
    const double length = 4, bend = degrees * pi / 180 / length;
    // Flat and slightly bent loops are simply projected.
    CHECK(RegionLayout("r", stadium(length, 0.4, bend), {}).domain() ==
          (degrees > 150 ? Domain::Developable : Domain::Projected));
    SkinOptions options;
    options.domain = Domain::Developable;
    const RegionLayout layout("r", stadium(length, 0.4, bend), options);
    const double expected = 0.8 * length + pi * 0.16;
    CHECK(domain_area(layout) * layout.size() * layout.size() == Approx(expected).epsilon(2e-3));
    const SkinQuality quality = measure(solved(layout));
    CHECK(quality.area == Approx(expected).epsilon(0.015));
    CHECK(quality.min_jacobian_ratio > 0.95);
    CHECK(quality.max_shear < 1.05);
    CHECK(quality.max_line_gap < layout.tolerance());
  }
}

TEST_CASE("lunes of a sphere keep their angle and their Jacobian", "[skinning][domains]") {
  for (const double degrees : {30.0, 90.0, 150.0}) {
    INFO(degrees);
    const RegionLayout layout("r", lune(degrees), {});
    CHECK(layout.domain() == Domain::Developable);
    REQUIRE(layout.corners().size() == 2);
    for (const DomainCorner& corner : layout.corners()) {
      CHECK(corner.line_angle_deg == Approx(degrees).margin(1e-6));
      CHECK(corner.domain_angle_deg == Approx(degrees).margin(1e-6));
    }
    const SkinQuality quality = measure(solved(layout));
    CHECK(quality.min_jacobian_ratio > 0.8);
    CHECK(quality.max_line_gap < layout.tolerance());
    CHECK(quality.max_normal_jump_deg < 1e-6);
  }
}

TEST_CASE(
    "loops without a planar projection get a developable domain: chips, a boundary with a bump",
    "[skinning][domains]") {
  const auto chip = [](double t) { return Vec3(std::cos(t), std::sin(t), 1.5 * std::cos(2 * t)); };
  const auto ball = [](double t) {
    return Vec3(0.7 * std::cos(t) + 0.3 * std::cos(3 * t),
                0.7 * std::sin(t) - 0.3 * std::sin(3 * t), 2 * std::sqrt(0.21) * std::sin(2 * t));
  };
  const auto bump = [](double t) {
    const double b = std::exp(-8 * (1 - std::cos(t)));
    return Vec3(std::cos(t) * (1 - 0.5 * b), std::sin(t) * (1 - 0.5 * b), 1.2 * b);
  };
  for (const auto& f : std::vector<std::function<Vec3(double)>>{chip, ball, bump}) {
    SkinOptions options;
    options.domain = Domain::Developable;
    const RegionLayout layout("r", {{"line", formula(0, 2 * pi, f)}}, options);
    const SkinQuality quality = measure(solved(layout));
    CHECK(quality.min_jacobian_ratio > 0.1);
    CHECK(quality.max_line_gap < layout.tolerance());
  }
  // The seam of the ball has no area in any projection.
  CHECK(RegionLayout("r", {{"seam", formula(0, 2 * pi, ball)}}, {}).domain() ==
        Domain::Developable);
}

TEST_CASE("a corner where two curves leave in one direction is a cusp of the domain",
          "[skinning][domains]") {
  const auto p = [](double x, double y, double z) { return Vec3(x, y, z); };
  const std::vector<CharacterLine> lines = {
      {"a", bezier_curve(p(0, 0, 0), p(0.4, 0, 0), p(0.8, 0.1, 0.1), p(1, 0.4, 0.2))},
      {"b", bezier_curve(p(1, 0.4, 0.2), p(0.9, 0.6, 0.2), p(0.8, 0.7, 0.2), p(0.6, 0.8, 0.2))},
      {"c", bezier_curve(p(0.6, 0.8, 0.2), p(0.5, 0.4, 0.1), p(0.3, 0, 0), p(0, 0, 0))}};
  SkinOptions options;
  for (const auto domain : {Domain::Auto, Domain::Developable}) {
    options.domain = domain;
    const RegionLayout layout("r", lines, options);
    CHECK(layout.domain() != Domain::Polygon);
    const SkinQuality quality = measure(solved(layout));
    CHECK(quality.min_jacobian_ratio > 0.9);
    CHECK(quality.max_line_gap < layout.tolerance());
  }
}

TEST_CASE("a polygon that is squashed by bulging sides gives way to a domain that embeds",
          "[skinning][domains]") {
  // Three corners of 10 degrees on a circle: no triangle has such angles.
  const auto point = [](double t) { return Vec3(std::cos(t), std::sin(t), 0); };
  const double k = 4.0 / 3 * std::tan(pi / 6 * 0.95);
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 3; ++i) {
    const double t0 = 2 * pi * i / 3 + 0.04, t1 = 2 * pi * (i + 1) / 3 + 0.04;
    const Vec3 a = point(t0), b = point(t1), da(-a.y(), a.x(), 0), db(-b.y(), b.x(), 0);
    const Vec3 out0 = da + 0.2 * a, in1 = db - 0.2 * b;
    lines.push_back({std::to_string(i), bezier_curve(a, a + k * out0, b - k * in1, b)});
  }
  const RegionLayout layout("r", lines, {});
  CHECK(layout.domain() != Domain::Polygon);
  CHECK(measure(solved(layout)).min_jacobian_ratio > 0.9);
}

TEST_CASE("holes and inner curves lie on a developable domain", "[skinning][domains]") {
  auto lines = stadium(4, 0.4, 1.1);
  const double b = 1.1;
  const auto on = [b](double x, double y) {
    return Vec3(std::sin(b * x) / b, (1 - std::cos(b * x)) / b, y);
  };
  lines.push_back(
      {"hole",
       formula(0, 2 * pi, [&](double t) { return on(1 + 0.2 * std::cos(t), 0.2 * std::sin(t)); }),
       CharacterLine::Role::Hole});
  lines.push_back(
      {"rib", formula(-0.3, 0.3, [&](double y) { return on(3, y); }), CharacterLine::Role::Inner});
  const RegionLayout layout("r", lines, {});
  CHECK(layout.domain() == Domain::Developable);
  const SkinQuality quality = measure(solved(layout));
  CHECK(quality.area == Approx(0.8 * 4 + pi * 0.16 - pi * 0.04).epsilon(0.01));
  CHECK(quality.max_line_gap < layout.tolerance());
  CHECK(quality.min_jacobian_ratio > 0.8);
}

TEST_CASE("developable domains do not depend on the unit", "[skinning][domains]") {
  const auto seam = [](double unit) {
    return formula(0, 2 * pi, [unit](double t) {
      return Vec3(unit * Vec3(std::cos(t), std::sin(t), 1.5 * std::cos(2 * t + 0.3)));
    });
  };
  SkinOptions options;
  options.domain = Domain::Developable;
  const RegionLayout a("r", {{"line", seam(1)}}, options), b("r", {{"line", seam(1000)}}, options);
  REQUIRE(a.mesh()->triangle_count() == b.mesh()->triangle_count());
  double difference = 0;
  for (int v = 0; v < a.mesh()->vertex_count(); ++v)
    difference = std::max(difference, (a.mesh()->vertices()[v] - b.mesh()->vertices()[v]).norm());
  CHECK(difference < 1e-8);
}

TEST_CASE("a knot is refused with the reason", "[skinning][domains]") {
  // Some of its fillings can be flattened: their surfaces intersect themselves, which is reported.
  std::vector<Vec3> knot;
  for (int i = 0; i < 120; ++i) {
    const double t = 2 * pi * i / 120;
    knot.emplace_back(std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t),
                      -std::sin(3 * t));
  }
  knot.push_back(knot.front());
  const auto trefoil = curve_through_points("trefoil", knot);
  CHECK_THROWS_WITH(RegionLayout("r", {{"trefoil", trefoil}}, {}),
                    Contains("trefoil") && Contains("flattened"));
  SkinOptions fitted;
  fitted.domain = Domain::Developable;
  auto lines = lune(90);
  lines[0].mesh_alignment = CharacterLine::MeshAlignment::EdgeAligned;
  CHECK_THROWS_WITH(RegionLayout("r", lines, fitted),
                    Contains("'a' has alignment = \"aligned\"") && Contains("always embedded"));
}
