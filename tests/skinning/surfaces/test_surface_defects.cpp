// SPDX-License-Identifier: MPL-2.0
// Surfaces with defects, and some that only appear to have them.
#include <limits>
#include <numbers>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/surfaces/surface_defects.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;
using Kind = SurfaceDefect::Kind;

namespace {

using std::numbers::pi;

SkinnedRegion solved(const std::string& name, const std::vector<CharacterLine>& lines,
                     double edge = 0.1) {
  SkinOptions options;
  options.edge_length = edge;
  const RegionLayout layout(name, lines, options);
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  const ConstrainedSolver solver(layout.line_constraints(), assembler.stiffness(SurfaceStiffness{}),
                                 nested_dissection_order(*layout.mesh()));
  return layout.region(solver.solve(Points::Zero(assembler.dofs().count(), 3)));
}

CharacterLine line(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_through_points(name, {a, b})};
}

// A planar quadrilateral with this name.
SkinnedRegion quad(const std::string& name, const Vec3& a, const Vec3& b, const Vec3& c,
                   const Vec3& d, double edge = 0.1) {
  return solved(name, {line("1", a, b), line("2", b, c), line("3", c, d), line("4", d, a)}, edge);
}

// The unit square's region with the shape of a function over its own (u, v) rectangle, 0 … 1 each.
SkinnedRegion shaped(const std::string& name, const std::function<Vec3(double, double)>& formula,
                     double edge_length = 0.04) {
  SkinnedRegion region = quad(name, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, edge_length);
  const ParametricMesh& mesh = region.surface.mesh();
  Vec2 low = mesh.vertices()[0], high = low;
  for (const Vec2& p : mesh.vertices()) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = high.x() - low.x();
  const auto x = [&](const Vec2& p) {
    return formula((p.x() - low.x()) / size, (p.y() - low.y()) / size);
  };
  const auto slope = [&](const Vec2& p, const Vec2& along) {
    constexpr double h = 1e-5;
    return Vec3((x(p + h * along) - x(p - h * along)) / (2 * h));
  };
  const DofMap dofs(mesh);
  Points q(dofs.count(), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2& p = mesh.vertices()[v];
    // Domains are rounded to 2^-30: shared parameters are equal exactly.
    q.row(dofs.vertex(v)) = formula(std::round((p.x() - low.x()) / size * 1e6) / 1e6,
                                    std::round((p.y() - low.y()) / size * 1e6) / 1e6);
    q.row(dofs.vertex(v, 1)) = slope(p, Vec2::UnitX());
    q.row(dofs.vertex(v, 2)) = slope(p, Vec2::UnitY());
  }
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    q.row(dofs.edge(e)) =
        slope(0.5 * (mesh.vertices()[edge.low] + mesh.vertices()[edge.high]), mesh.edge_normal(e));
  }
  region.surface = Surface(region.surface.shared_mesh(), region.surface.kind(), q);
  region.edge_aligned.clear();
  return region;
}

std::vector<SurfaceDefect> defects_of(const std::vector<SkinnedRegion>& regions,
                                      std::vector<double> plain = {}) {
  std::vector<const SkinnedRegion*> pointers;
  std::vector<SkinQuality> qualities;
  for (const SkinnedRegion& r : regions) {
    pointers.push_back(&r);
    qualities.push_back(measure(r));
  }
  plain.resize(regions.size(), 0);
  return find_defects(pointers, qualities, plain);
}

std::string texts(const std::vector<SurfaceDefect>& defects) {
  std::string all;
  for (const SurfaceDefect& defect : defects) all += defect.text + "\n";
  return all;
}

// Two squares along the y axis, with this wedge between them.
std::vector<SkinnedRegion> wedge(double degrees, double second_edge = 0.1) {
  const double a = degrees * pi / 180;
  const Vec3 side(std::cos(a), 0, std::sin(a)), y = Vec3::UnitY();
  return {quad("flat", {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}),
          quad("leaning", Vec3::Zero(), side, side + y, y, second_edge)};
}

}  // namespace

TEST_CASE("a box, flat faces side by side and strongly curved faces have no defects",
          "[skinning][surfaces]") {
  const auto p = [](int x, int y, int z) { return Vec3(x, y, z); };
  CHECK(defects_of({quad("bottom", p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0)),
                    quad("top", p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)),
                    quad("front", p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)),
                    quad("back", p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0)),
                    quad("left", p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)),
                    quad("right", p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1))},
                   {1, 1, 1, 1, 1, 1})
            .empty());
  CHECK(defects_of({quad("a", p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0)),
                    quad("b", p(1, 0, 0), p(2, 0, 0), p(2, 1, 0), p(1, 1, 0), 0.07)})
            .empty());
  CHECK(defects_of({shaped("tube", [](double u, double v) {
          const double t = 0.95 * 2 * pi * u;
          return Vec3(std::cos(t), v, std::sin(t));
        })}).empty());
}

TEST_CASE("an inverted surface is named with the position", "[skinning][surfaces]") {
  const auto defects = defects_of(
      {quad("good", {5, 0, 0}, {6, 0, 0}, {6, 1, 0}, {5, 1, 0}),
       shaped("bad", [](double u, double v) { return Vec3((u - 0.5) * (u - 0.5), v, 0); })});
  REQUIRE(defects.size() >= 2);
  CHECK(defects[0].kind == Kind::Jacobian);
  CHECK(defects[0].regions == std::vector<int>{1});
  CHECK(defects[0].value <= 0);
  CHECK(std::abs(defects[0].where.x()) < 0.01);
  CHECK_THAT(defects[0].text, Contains("'bad'"));
  CHECK(defects[1].kind == Kind::Fold);
  CHECK(defects[1].value == Approx(180).margin(1));
  CHECK(defects[1].regions == std::vector<int>{1});
}

TEST_CASE("a sharp fold inside is named, a round one of the same angle is not",
          "[skinning][surfaces]") {
  const auto folded = [](double radius) {
    // A half turn of this radius between two flat parts.
    return [radius](double u, double v) {
      const double s = 2 * (u - 0.5), half = 0.5 * pi * radius;
      if (s < -half) return Vec3(s + half, v, -radius);
      if (s > half) return Vec3(half - s, v, radius);
      return Vec3(radius * std::cos(s / radius), v, radius * std::sin(s / radius));
    };
  };
  CHECK(defects_of({shaped("round", folded(0.2))}).empty());
  const auto defects = defects_of({shaped("sharp", folded(0.004))});
  CHECK(std::any_of(defects.begin(), defects.end(), [](const SurfaceDefect& f) {
    return f.kind == Kind::Fold && f.value > 90 && std::abs(f.where.x()) < 0.1;
  }));
}

TEST_CASE("an area above twice the plain one is named, with the ratio", "[skinning][surfaces]") {
  const auto bump = [](double height) {
    return [height](double u, double v) {
      return Vec3(u, v, height * std::sin(pi * u) * std::sin(pi * v));
    };
  };
  CHECK(defects_of({shaped("low", bump(0.5))}, {1}).empty());
  const auto defects = defects_of({shaped("high", bump(1.5))}, {1});
  REQUIRE(defects.size() == 1);
  CHECK(defects[0].kind == Kind::Area);
  CHECK(defects[0].value == Approx(measure(shaped("high", bump(1.5))).area).epsilon(1e-9));
  CHECK(defects[0].value > 2);
  CHECK(defects_of({shaped("unknown", bump(1.5))}, {0}).empty());
}

TEST_CASE("a wedge that the curves at the ends of the common curve require is no defect",
          "[skinning][surfaces]") {
  for (const double degrees : {180.0, 90.0, 60.0, 35.0, 25.0, 16.0, 10.0, 5.0, 2.0, 0.5}) {
    INFO(degrees);
    CHECK(texts(defects_of(wedge(degrees))) == "");
    CHECK(texts(defects_of(wedge(degrees, 0.07))) == "");  // the other elements
  }
  // Twice the same surface counts as one.
  const auto defects = defects_of(wedge(0));
  REQUIRE_FALSE(defects.empty());
  CHECK(defects[0].kind == Kind::Fold);
  CHECK(defects[0].value == Approx(180));
}

TEST_CASE("two faces that double back between distant ends are named", "[skinning][surfaces]") {
  // The second leans over the first in the middle of their common curve, down to `least` degrees.
  const auto leaning = [](double ends, double least) {
    return [=](double u, double v) {
      const double a = (ends + (least - ends) * std::sin(pi * v)) * pi / 180;
      return Vec3(u * std::cos(a), v, u * std::sin(a));
    };
  };
  const SkinnedRegion flat = shaped("flat", [](double u, double v) { return Vec3(u, v, 0); });
  CHECK(defects_of({flat, shaped("leaning", leaning(60, 40))}).empty());
  CHECK(defects_of({flat, shaped("leaning", leaning(16, 12))}).empty());
  for (const auto& [ends, least] : {std::pair{60.0, 10.0}, {40.0, 5.0}, {16.0, 3.0}}) {
    INFO(ends << " " << least);
    const auto defects = defects_of({flat, shaped("leaning", leaning(ends, least))});
    REQUIRE(defects.size() == 1);
    CHECK(defects[0].kind == Kind::Fold);
    CHECK(defects[0].regions == std::vector<int>{0, 1});
    CHECK(defects[0].value == Approx(180 - least).margin(0.5));
    CHECK(defects[0].where.y() == Approx(0.5).margin(0.05));
    CHECK(std::abs(defects[0].where.x()) < 1e-9);
    CHECK_THAT(defects[0].text, Contains("'leaning'") && Contains("'flat'"));
  }
}

TEST_CASE("curved surfaces at a sharp edge do not cross because of their facets",
          "[skinning][surfaces]") {
  // Two sheets of the same curvature, with a wedge between them and other elements.
  const auto sheet = [](double slope, bool mirrored) {
    return [=](double u, double v) {
      if (mirrored) v = 1 - v;
      return Vec3(u, v, u * (slope + 0.6 * u + 0.4 * std::sin(pi * v)));
    };
  };
  for (const double degrees : {5.0, 2.0, 1.0})
    for (const double edge : {0.04, 0.2}) {
      INFO(degrees << " degrees, edges of " << edge);
      const SkinnedRegion lower = shaped("lower", sheet(0, false), edge);
      CHECK(texts(defects_of(
                {lower, shaped("upper", sheet(std::tan(degrees * pi / 180), true), edge)})) == "");
      // They intersect if they penetrate each other by more than that.
      const auto through = [&](double u, double v) {
        return Vec3(sheet(0, true)(u, v) + Vec3(0, 0, 0.2 * u * (u - 0.5)));
      };
      const auto defects = defects_of({lower, shaped("through", through, edge)});
      CHECK(std::any_of(defects.begin(), defects.end(),
                        [](const SurfaceDefect& f) { return f.kind == Kind::Crossing; }));
    }
}

TEST_CASE("facets that overlap in one plane intersect, whatever its normal",
          "[skinning][surfaces][defects]") {
  // Planes with exact coordinates, so that the facets are exactly coplanar.
  const std::pair<Vec3, Vec3> planes[] = {
      {Vec3::UnitX(), Vec3::UnitY()}, {Vec3::UnitX(), Vec3::UnitZ()},
      {Vec3::UnitY(), Vec3::UnitZ()}, {Vec3(1, 1, 0), Vec3::UnitZ()},
      {Vec3(1, 0, 1), Vec3::UnitY()}, {Vec3(1, 0, -1), Vec3(0, 1, -1)}};
  const auto count = [](const std::pair<Vec3, Vec3>& plane, const std::array<Vec2, 6>& corners) {
    std::vector<Vec3> points;
    for (const Vec2& c : corners)
      points.push_back(Vec3(1, 2, 3) + c.x() * plane.first + c.y() * plane.second);
    const std::vector<std::array<int, 3>> facets{{0, 1, 2}, {3, 4, 5}};
    return facet_intersections(points, facets, facets, {0, 1}, 0).size();
  };
  for (const auto& plane : planes) {
    CAPTURE(plane.first, plane.second);
    // Shifted, one inside the other, and a star of two triangles.
    CHECK(count(plane, {{{0, 0}, {4, 0}, {0, 4}, {1, 1}, {5, 1}, {1, 5}}}) == 1);
    CHECK(count(plane, {{{0, 0}, {8, 0}, {0, 8}, {1, 1}, {2, 1}, {1, 2}}}) == 1);
    CHECK(count(plane, {{{0, 0}, {6, 0}, {3, 6}, {0, 4}, {3, -2}, {6, 4}}}) == 1);
    // Separated in either direction of the plane, with overlapping bounding boxes.
    CHECK(count(plane, {{{0, 0}, {4, 0}, {0, 4}, {4, 1}, {4, 4}, {1, 4}}}) == 0);
    CHECK(count(plane, {{{0, 0}, {1, 0}, {0, 1}, {3, 0}, {4, 0}, {3, 1}}}) == 0);
    CHECK(count(plane, {{{0, 0}, {1, 0}, {0, 1}, {0, 3}, {1, 3}, {0, 4}}}) == 0);
  }
}

TEST_CASE("intersecting and self-intersecting faces are named", "[skinning][surfaces]") {
  const auto cross = defects_of({quad("flat", {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}),
                                 quad("upright", {0.4, 0.2, -0.3}, {0.6, 0.8, -0.3},
                                      {0.6, 0.8, 0.4}, {0.4, 0.2, 0.4}, 0.07)});
  REQUIRE(cross.size() == 1);
  CHECK(cross[0].kind == Kind::Crossing);
  CHECK(cross[0].regions == std::vector<int>{0, 1});
  CHECK(cross[0].value > 5);
  CHECK(std::abs(cross[0].where.z()) < 1e-9);

  // A sheet whose profile is the letter alpha.
  const auto alpha = defects_of({shaped("alpha", [](double u, double v) {
    const double t = 3 * (u - 0.5);
    return Vec3(t * t, v, t * (t * t - 1));
  })});
  REQUIRE(alpha.size() == 1);
  CHECK(alpha[0].kind == Kind::Crossing);
  CHECK(alpha[0].regions == std::vector<int>{0});
  CHECK(std::abs(alpha[0].where.x() - 1) < 0.05);
  CHECK(std::abs(alpha[0].where.z()) < 0.05);

  // Two coincident surfaces.
  const auto twice =
      defects_of({quad("one", {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}),
                  quad("two", {0.5, 0.1, 0}, {1.5, 0.1, 0}, {1.5, 0.9, 0}, {0.5, 0.9, 0})});
  REQUIRE(twice.size() == 1);
  CHECK(twice[0].kind == Kind::Crossing);
}

TEST_CASE("faces that share a curve within a gap, or in other steps, only touch",
          "[skinning][surfaces]") {
  // Both embedded, on either side of a circle, with triangles of different sizes.
  const auto circle = curve_from_formula(0, 2 * pi, [](double t, int order) -> Vec3 {
    if (order == 0) return {std::cos(t), std::sin(t), 0.2 * std::cos(2 * t)};
    if (order == 1) return {-std::sin(t), std::cos(t), -0.4 * std::sin(2 * t)};
    return {-std::cos(t), -std::sin(t), -0.8 * std::cos(2 * t)};
  });
  const auto square = [](double r) {
    const Vec3 p[4] = {{r, r, 0}, {-r, r, 0}, {-r, -r, 0}, {r, -r, 0}};
    std::vector<CharacterLine> lines;
    for (int i = 0; i < 4; ++i) lines.push_back(line(std::to_string(i), p[i], p[(i + 1) % 4]));
    return lines;
  };
  auto around = square(2);
  around.push_back({"hole", circle, CharacterLine::Role::Hole});
  CHECK(
      defects_of({solved("disc", {{"rim", circle}}, 0.17), solved("plate", around, 0.11)}).empty());
  // The same disc, lower by a third of its height, no longer passes through the plate's hole.
  const auto lowered = curve_from_formula(0, 2 * pi, [&](double t, int order) {
    const Vec3 x = 1.2 * circle->evaluate(t, order);
    return order == 0 ? Vec3(x - Vec3(0, 0, 0.05)) : x;
  });
  const auto defects =
      defects_of({solved("disc", {{"rim", lowered}}, 0.17), solved("plate", around, 0.11)});
  REQUIRE(defects.size() == 1);
  CHECK(defects[0].kind == Kind::Crossing);
}

TEST_CASE("intersections of facets are those of an exhaustive search", "[skinning][surfaces]") {
  // Random facets; each pair is tested by its edges against the other's plane.
  unsigned state = 7;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return state / 4294967296.0;
  };
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  for (int f = 0; f < 300; ++f) {
    const Vec3 middle(random(), random(), random());
    const double size = f % 10 == 0 ? 0.8 : 0.2;
    for (int i = 0; i < 3; ++i)
      points.push_back(middle + size * (Vec3(random(), random(), random()) - Vec3::Constant(0.5)));
    facets.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).cross(c - a).dot(d - a);
  };
  std::vector<std::pair<int, int>> expected, found;
  for (int a = 0; a < 300; ++a)
    for (int b = a + 1; b < 300; ++b) {
      const auto pierces = [&](int x, int y) {
        const Vec3 *p = &points[3 * static_cast<size_t>(x)],
                   *q = &points[3 * static_cast<size_t>(y)];
        for (int i = 0; i < 3; ++i) {
          const Vec3 &s = p[i], &t = p[(i + 1) % 3];
          if ((volume(q[0], q[1], q[2], s) > 0) == (volume(q[0], q[1], q[2], t) > 0)) continue;
          const bool u = volume(s, t, q[0], q[1]) > 0, v = volume(s, t, q[1], q[2]) > 0,
                     w = volume(s, t, q[2], q[0]) > 0;
          if (u == v && v == w) return true;
        }
        return false;
      };
      if (pierces(a, b) || pierces(b, a)) expected.emplace_back(a, b);
    }
  for (const FacetIntersection& c :
       facet_intersections(points, facets, facets, std::vector<int>(300, 0), 0))
    found.emplace_back(c.a, c.b);
  CHECK(expected.size() > 100);
  CHECK(found == expected);

  // A facet with coordinates that are not finite hides none of the others.
  std::vector<Vec3> broken = points;
  broken[0].y() = std::numeric_limits<double>::quiet_NaN();
  found.clear();
  for (const FacetIntersection& c :
       facet_intersections(broken, facets, facets, std::vector<int>(300, 0), 0))
    found.emplace_back(c.a, c.b);
  std::erase_if(expected, [&](const auto& pair) {
    const auto has = [&](int f) {
      return facets[f][0] == 0 || facets[f][1] == 0 || facets[f][2] == 0;
    };
    return has(pair.first) || has(pair.second);
  });
  CHECK(found == expected);
}

TEST_CASE("faces that were not skinned are skipped, wrong counts are reported",
          "[skinning][surfaces]") {
  const SkinnedRegion flat = quad("flat", {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  CHECK(find_defects({nullptr, &flat, nullptr}, {{}, measure(flat), {}}, {0, 1, 0}).empty());
  CHECK(find_defects({}, {}, {}).empty());
  CHECK_THROWS_AS(find_defects({&flat}, {}, {1}), InputError);
}
