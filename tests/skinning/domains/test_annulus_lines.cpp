// SPDX-License-Identifier: MPL-2.0
// Inner curves of annular domains: around, across, over the seam, with corners.
#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <set>

#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
using Role = CharacterLine::Role;

// radius (cos t, sin t), height + rise t, from `from` to `to`, rotated by `turn` and scaled.
CharacterLine helix(const std::string& name, Role role, double radius, double height,
                    double from = 0, double to = 2 * pi, double rise = 0, double unit = 1) {
  return {name,
          curve_from_formula(from, to,
                             [=](double t, int order) -> Vec3 {
                               const double s = t + order * pi / 2;
                               Vec3 x(radius * std::cos(s), radius * std::sin(s), 0);
                               if (order == 0) x.z() = height + rise * (t - from);
                               if (order == 1) x.z() = rise;
                               return unit * x;
                             }),
          role};
}

CharacterLine circle(const std::string& name, Role role, double radius, double height,
                     double turn = 0, double unit = 1) {
  return helix(name, role, radius, height, turn, turn + 2 * pi, 0, unit);
}

// A square around the axis, its corners at `radius`, the first at angle `turn`.
CharacterLine square(const std::string& name, double radius, double height, double turn = 0,
                     double unit = 1) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 4; ++i) {
    const double t = turn + i % 4 * pi / 2;
    points.push_back(unit * Vec3(radius * std::cos(t), radius * std::sin(t), height));
  }
  return {name, curve_through_points(name, points), Role::Inner};
}

// Approximately a square: the radius varies by a twelfth, t starts at `start`.
CharacterLine rounded_square(const std::string& name, double radius, double height, double turn = 0,
                             double start = 0) {
  return {name,
          curve_from_formula(
              start, start + 2 * pi,
              [=](double t, int order) -> Vec3 {
                const auto wave = [&](double k, int d) {
                  return std::pow(k, d) * std::cos(k * t + d * pi / 2);
                };
                const double r[3] = {1 + wave(4, 0) / 12, wave(4, 1) / 12, wave(4, 2) / 12};
                constexpr int binomial[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 2, 1}};
                Vec3 x(0, 0, order == 0 ? height : 0);
                for (int k = 0; k <= order; ++k) {
                  const double a = t + turn + k * pi / 2,
                               c = radius * binomial[order][k] * r[order - k];
                  x.x() += c * std::cos(a);
                  x.y() += c * std::sin(a);
                }
                return x;
              }),
          Role::Inner};
}

SkinOptions options_of(double edge, double tolerance) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = tolerance;
  return options;
}

struct SculptedRegion {
  RegionLayout layout;
  SculptResult sculpt;
  SkinnedRegion region;
  SkinQuality quality;
  SculptedRegion(const std::vector<CharacterLine>& lines, double edge, double tolerance,
                 const SurfaceStiffness& material = {})
      : layout("ring", lines, options_of(edge, tolerance)),
        sculpt(batten::reference_solver::sculpt(layout, layout.line_constraints(), {}, {material})),
        region(layout.region(sculpt.dofs)),
        quality(measure(region)) {}
};

void check_quality(const SculptedRegion& made) {
  CHECK(made.quality.max_line_gap <= made.layout.tolerance());
  CHECK(made.quality.max_line_deviation <= made.layout.tolerance());
  CHECK(made.quality.max_line_residual < 1e-11);
  CHECK(made.sculpt.max_constraint_residual < 1e-12);
  CHECK(made.quality.min_jacobian_ratio > 0.05);
  CHECK(made.quality.singular_nodes == 0);
  CHECK(made.quality.max_normal_jump_deg < 1e-9);
}

// The points of the surface along each curve.
double worst_point(const SculptedRegion& made) {
  const Surface& surface = made.region.surface;
  const TriangleLocator locator(surface.mesh());
  double worst = 0;
  for (const EmbeddedLine& line : made.region.embedded)
    for (const double t : line.points)
      worst = std::max(worst, (surface.position(locator.locate(drop_z(line.pcurve.evaluate(t)))) -
                               line.fitted.evaluate(t))
                                  .norm());
  return worst;
}

double distance(const Surface& from, const Surface& to, const Mat3& turn = Mat3::Identity(),
                double scale = 1) {
  double worst = 0;
  const int step = std::max(1, from.mesh().triangle_count() / 40);
  for (int t = 0; t < from.mesh().triangle_count(); t += step) {
    const Vec3 x = scale * (turn * from.position({t, Vec3::Constant(1.0 / 3)}));
    worst = std::max(worst, to.closest_point(x).distance);
  }
  return worst;
}

// Facets are closed around: Euler characteristic 0, two boundaries, no inverted facet.
void check_facets(const SkinnedRegion& region) {
  if (!have_delaunay_mesher()) return;
  const QuadraticElements facets = quadratic_elements(region);
  std::map<std::pair<int, int>, int> edges;
  std::set<int> corners;
  double area = 0;
  for (const auto& f : facets.triangles) {
    for (int i = 0; i < 3; ++i) {
      corners.insert(f[i]);
      ++edges[std::minmax(f[i], f[(i + 1) % 3])];
    }
    const auto x = [&](int i) { return region.surface.position(facets.nodes[f[i]]); };
    const Vec3 twice = (x(1) - x(0)).cross(x(2) - x(0));
    area += 0.5 * twice.norm();
    const Vec3 n = region.surface.jet(facets.nodes[f[3]]).normal();
    CHECK(twice.normalized().dot(n) > 0.3);
  }
  int once = 0;
  for (const auto& [edge, count] : edges) {
    CHECK(count <= 2);
    once += count == 1;
  }
  CHECK(static_cast<int>(corners.size()) - static_cast<int>(edges.size()) +
            static_cast<int>(facets.triangles.size()) ==
        0);
  CHECK(once > 0);
  CHECK(area == Approx(region.surface.area()).epsilon(0.02));
  // Curves are chains of edges from end to end.
  for (const auto& line : facets.lines)
    for (size_t k = 0; k + 1 < line.size(); ++k) CHECK(line[k][1] == line[k + 1][0]);
}

}  // namespace

TEST_CASE("a curve that lies on the surface of the boundaries changes nothing",
          "[skinning][domains]") {
  const std::vector<CharacterLine> rims{circle("low", Role::Outline, 1, 0),
                                        circle("high", Role::Outline, 0.6, 1.2)};
  const SculptedRegion plain(rims, 0.15, 1e-6);
  const Surface& surface = plain.region.surface;
  const double period = surface.mesh().period();
  double top = 0;
  for (const Vec2& p : surface.mesh().vertices()) top = std::max(top, p.y());
  const TriangleLocator locator(surface.mesh());
  // x(u, v) over curves of the strip: a wavy one once around, a slanted one over the seam, a small
  // loop on it.
  const auto on_surface = [&](const std::string& name, const Vec2& from, const Vec2& along,
                              const Vec2& cosine, const Vec2& sine) {
    return CharacterLine{
        name,
        curve_from_formula(0, 2 * pi,
                           [=, &locator](double t, int order) -> Vec3 {
                             const Vec2 uv = from + t / (2 * pi) * along + std::cos(t) * cosine +
                                             std::sin(t) * sine;
                             const Vec2 d = along / (2 * pi) - std::sin(t) * cosine +
                                            std::cos(t) * sine,
                                        dd = -std::cos(t) * cosine - std::sin(t) * sine;
                             const SurfaceJet jet = surface.jet(locator.locate(uv));
                             if (order == 0) return jet.x;
                             if (order == 1) return d.x() * jet.x_u + d.y() * jet.x_v;
                             return dd.x() * jet.x_u + dd.y() * jet.x_v + d.x() * d.x() * jet.x_uu +
                                    2 * d.x() * d.y() * jet.x_uv + d.y() * d.y() * jet.x_vv;
                           }),
        Role::Inner};
  };
  const std::vector<CharacterLine> lines{
      on_surface("around", {0.3 * period, 0.3 * top}, {period, 0}, {0, 0.06 * top}, {0, 0}),
      on_surface("across", {0.85 * period, 0.45 * top}, {0.3 * period, 0.2 * top}, {0, 0}, {0, 0}),
      on_surface("loop", {0.98 * period, 0.8 * top}, {0, 0}, {0.08 * period, 0}, {0, 0.1 * top})};
  for (const CharacterLine& line : lines) {
    INFO(line.name);
    auto all = rims;
    all.push_back(line);
    const SculptedRegion made(all, 0.15, 1e-4);
    check_quality(made);
    CHECK(made.quality.max_line_gap < 5e-5);
    CHECK(distance(made.region.surface, surface) < 1e-4);
    check_facets(made.region);
  }
}

TEST_CASE("squares around an annulus are constrained at their points, corners too",
          "[skinning][domains]") {
  const SculptedRegion made({circle("low", Role::Outline, 1, 0),
                             circle("high", Role::Outline, 1, 2), square("s", 0.6, 1, 0.3)},
                            0.2, 1e-3);
  check_quality(made);
  CHECK(worst_point(made) < 1e-12);
  REQUIRE(made.region.embedded.size() == 4);
  CHECK(made.region.embedded[3].line.name == "s.4");
  for (int i = 0; i < 4; ++i) {
    const EmbeddedLine &line = made.region.embedded[static_cast<size_t>(i)],
                       &next = made.region.embedded[static_cast<size_t>(i + 1) % 4];
    const Vec2 end = drop_z(line.pcurve.evaluate(line.pcurve.end())),
               begin = drop_z(next.pcurve.evaluate(next.pcurve.start()));
    CHECK((made.layout.mesh()->image_near(begin, end) - end).norm() < 1e-9);
  }
  check_facets(made.region);
}

TEST_CASE("where u begins does not matter to inner curves", "[skinning][domains]") {
  double before = 0;
  for (const double edge : {0.3, 0.15}) {
    const double tolerance = 1e-2 * edge * edge;
    const auto made = [&](double turn, double low, double high, double line) {
      return SculptedRegion({circle("low", Role::Outline, 1, 0, turn + low),
                             circle("high", Role::Outline, 0.8, 2, turn + high),
                             rounded_square("s", 0.55, 0.8, turn, line),
                             circle("c", Role::Inner, 0.62, 1.3, turn + line)},
                            edge, tolerance);
    };
    const SculptedRegion straight = made(0, 0, 0, 0);
    check_quality(straight);
    // The boundaries rotate with the curves, and u starts with the boundaries: the same mesh,
    // rotated.
    for (const double turn : {0.4, 2.9}) {
      const SculptedRegion turned = made(turn, 0, 0, 0);
      CHECK(distance(straight.region.surface, turned.region.surface,
                     Mat3(Eigen::AngleAxisd(turn, Vec3::UnitZ()))) < 1e-8);
    }
    // Every curve starts elsewhere, and u with the boundaries.
    const SculptedRegion shifted = made(0, 0.37, 1.3, 5);
    check_quality(shifted);
    const double away = distance(straight.region.surface, shifted.region.surface);
    INFO(edge << ": " << away);
    CHECK(away < 0.01 * edge);
    if (before > 0) CHECK(away < 0.3 * before);
    before = away;
  }
}

TEST_CASE("mm and m make the same annulus with inner curves", "[skinning][domains]") {
  const auto made = [](double unit) {
    return SculptedRegion(
        {circle("low", Role::Outline, 1, 0, 0, unit),
         circle("high", Role::Outline, 0.7, 1.5, 0.2, unit), square("s", 0.6, 0.7, 0.3, unit)},
        0.2 * unit, 1e-3 * unit);
  };
  const SculptedRegion m = made(1), mm = made(1000);
  CHECK(m.layout.mesh()->triangles() == mm.layout.mesh()->triangles());
  REQUIRE(m.sculpt.dofs.rows() == mm.sculpt.dofs.rows());
  CHECK((m.sculpt.dofs - mm.sculpt.dofs / 1000).cwiseAbs().maxCoeff() < 1e-7);
  for (size_t i = 0; i < m.region.embedded.size(); ++i)
    CHECK(m.region.embedded[i].points.size() == mm.region.embedded[i].points.size());
}

TEST_CASE("a helix goes more than once around", "[skinning][domains]") {
  const SculptedRegion made(
      {circle("low", Role::Outline, 1, 0), circle("high", Role::Outline, 1, 2),
       helix("helix", Role::Inner, 0.95, 0.3, 1, 1 + 5 * pi, 1.4 / (5 * pi))},
      0.2, 1e-3);
  check_quality(made);
  CHECK(worst_point(made) < 1e-12);
  const HermiteCurve& pcurve = made.region.embedded[0].pcurve;
  CHECK(std::abs(pcurve.evaluate(pcurve.end()).x() - pcurve.evaluate(pcurve.start()).x()) ==
        Approx(2.5 * made.layout.mesh()->period()).epsilon(1e-3));
  check_facets(made.region);
}

TEST_CASE(
    "ribs from boundary to boundary, one of them where u begins, and a curve that crosses them",
    "[skinning][domains]") {
  std::vector<CharacterLine> lines{circle("low", Role::Outline, 1, 0),
                                   circle("high", Role::Outline, 1, 1.5)};
  for (int k = 0; k < 5; ++k) {
    const double t = 2 * pi * k / 5;
    const auto at = [&](double r, double z) { return Vec3(r * std::cos(t), r * std::sin(t), z); };
    lines.push_back({"rib " + std::to_string(k),
                     bezier_curve(at(1, 0), at(0.75, 0.5), at(0.75, 1), at(1, 1.5)), Role::Inner});
  }
  // The ribs at half the height: radius (1 + 3·0.75·2 + 1) / 8.
  lines.push_back(circle("waist", Role::Inner, 0.8125, 0.75, 0.1));
  const SculptedRegion made(lines, 0.2, 1e-3);
  check_quality(made);
  CHECK(worst_point(made) < 1e-12);
  check_facets(made.region);
  // Ribs at equal angles, five-fold symmetry: the same shape after a rotation by one fifth.
  CHECK(distance(made.region.surface, made.region.surface,
                 Mat3(Eigen::AngleAxisd(2 * pi / 5, Vec3::UnitZ()))) < 5e-3);
}

TEST_CASE("curves that an annulus cannot have are named", "[skinning][domains]") {
  const std::vector<CharacterLine> rims{circle("low", Role::Outline, 1, 0),
                                        circle("high", Role::Outline, 1, 1)};
  const auto with = [&](const std::vector<CharacterLine>& more) {
    auto lines = rims;
    lines.insert(lines.end(), more.begin(), more.end());
    return RegionLayout("ring", lines, options_of(0.2, 1e-3));
  };
  CHECK_THROWS_WITH(with({helix("out", Role::Inner, 1, 0.5, 0, 2, 0.5)}),
                    Contains("'out' leaves the face"));
  CHECK_THROWS_WITH(
      with({circle("a", Role::Inner, 0.9, 0.5), helix("b", Role::Inner, 1.05, 0.2, 5.5, 7.5, 0.3)}),
      Contains("'a' and 'b'") && Contains("apart"));
  CHECK_THROWS_WITH(with({{"fit", circle("fit", Role::Inner, 0.9, 0.5).curve, Role::Inner,
                           CharacterLine::MeshAlignment::EdgeAligned}}),
                    Contains("'fit' has alignment = \"aligned\""));
}

TEST_CASE("inner curves are added to an annulus later and removed again", "[skinning][domains]") {
  RegionLayout layout("ring",
                      {circle("low", Role::Outline, 1, 0), circle("high", Role::Outline, 1, 1.5)},
                      options_of(0.2, 1e-3));
  const auto solved = [&] { return sculpt(layout, layout.line_constraints(), {}, {}).dofs; };
  const Points before = solved();
  const auto mesh = layout.mesh();
  layout.add_inner_line(square("s", 0.8, 0.7), layout.region(before).surface);
  CHECK(layout.has_line("s.1"));
  for (int round = 0; round < 8; ++round)
    if (!layout.refine(layout.region(solved()).surface, 0.5e-3)) break;
  const SkinnedRegion region = layout.region(solved());
  for (const EmbeddedLine& line : region.embedded) CHECK(line_gap(region.surface, line) < 1e-3);
  check_facets(region);
  layout.remove_inner_line("s");
  CHECK(layout.embedded().empty());
  CHECK(distance(layout.region(solved()).surface, Surface(mesh, layout.element(), before)) < 1e-3);
}

TEST_CASE("holes in an annulus, one of them where u begins", "[skinning][domains]") {
  // A round window in a tube: radius `a` along the wall, around angle `at`, height `z`.
  const auto window = [](const std::string& name, double at, double z, double a) {
    return CharacterLine{
        name,
        curve_from_formula(0, 2 * pi,
                           [=](double t, int order) -> Vec3 {
                             const double s = at + a * std::cos(t), d = -a * std::sin(t),
                                          dd = -a * std::cos(t);
                             if (order == 0) return {std::cos(s), std::sin(s), z + a * std::sin(t)};
                             if (order == 1)
                               return {-d * std::sin(s), d * std::cos(s), a * std::cos(t)};
                             return {-dd * std::sin(s) - d * d * std::cos(s),
                                     dd * std::cos(s) - d * d * std::sin(s), -a * std::sin(t)};
                           }),
        Role::Hole};
  };
  const std::vector<CharacterLine> rims{circle("low", Role::Outline, 1, 0),
                                        circle("high", Role::Outline, 1, 1.5)};
  std::vector<CharacterLine> lines = rims;
  lines.push_back(window("seam", 0, 0.75, 0.3));
  lines.push_back(window("side", 2.2, 0.6, 0.25));
  lines.push_back(circle("band", Role::Inner, 1, 1.2, 0.4));
  const double edge = 0.15;
  const SculptedRegion made(lines, edge, 1e-3);
  check_quality(made);
  CHECK(worst_point(made) < 1e-12);
  REQUIRE(made.region.boundary.size() == 4);
  // The radius of the tube is prescribed along the curves; between them the wall sinks slightly.
  CHECK(made.quality.area == Approx(2 * pi * 1.5 - pi * (0.3 * 0.3 + 0.25 * 0.25)).epsilon(0.05));
  if (have_delaunay_mesher()) {
    const QuadraticElements facets = quadratic_elements(made.region);
    std::map<std::pair<int, int>, int> edges;
    std::set<int> corners;
    double area = 0;
    for (const auto& f : facets.triangles) {
      const auto x = [&](int i) { return made.region.surface.position(facets.nodes[f[i]]); };
      area += 0.5 * (x(1) - x(0)).cross(x(2) - x(0)).norm();
      for (int i = 0; i < 3; ++i) {
        corners.insert(f[i]);
        ++edges[std::minmax(f[i], f[(i + 1) % 3])];
      }
    }
    // A tube with two windows.
    CHECK(static_cast<int>(corners.size()) - static_cast<int>(edges.size()) +
              static_cast<int>(facets.triangles.size()) ==
          -2);
    CHECK(area == Approx(made.quality.area).epsilon(0.02));
  }
  // The window where u starts equals one elsewhere.
  lines = rims;
  lines.push_back(window("a", 0, 0.75, 0.3));
  const SculptedRegion here(lines, edge, 1e-3);
  lines.back() = window("a", 2, 0.75, 0.3);
  const SculptedRegion there(lines, edge, 1e-3);
  CHECK(here.quality.area == Approx(there.quality.area).epsilon(1e-4));

  lines = rims;
  lines.push_back({"all around", circle("", Role::Hole, 1, 0.7).curve, Role::Hole});
  CHECK_THROWS_WITH(SculptedRegion(lines, edge, 1e-3),
                    Contains("'all around' runs around the annular face"));
}
