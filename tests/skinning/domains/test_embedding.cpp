// SPDX-License-Identifier: MPL-2.0
#include <numbers>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/random_outlines.h"
#include "batten/tests/support/reference_static_solver.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
using MeshAlignment = CharacterLine::MeshAlignment;

CharacterLine ellipse(const std::string& name, Role role, const Vec3& centre, double a, double b,
                      double wave = 0, int waves = 3) {
  return {name,
          curve_from_formula(0, 2 * pi,
                             [=](double t, int order) -> Vec3 {
                               const double s = t + order * pi / 2, w = waves * t + order * pi / 2;
                               Vec3 x(a * std::cos(s), b * std::sin(s),
                                      wave * std::pow(waves, order) * std::cos(w));
                               return order == 0 ? Vec3(centre + x) : x;
                             }),
          role};
}

CharacterLine arc(const std::string& name, const std::vector<Vec3>& points, Role role) {
  return {name, curve_through_points(name, points), role};
}

struct SculptedRegion {
  RegionLayout layout;
  SculptResult sculpt;
  SkinnedRegion region;
  SkinQuality quality;
  SculptedRegion(const std::vector<CharacterLine>& lines, const SkinOptions& options)
      : layout("region", lines, options),
        sculpt(batten::reference_solver::sculpt(layout, layout.line_constraints(), {}, {})),
        region(layout.region(sculpt.dofs)),
        quality(measure(region)) {}
};

SkinOptions fine(double edge, double tolerance) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = tolerance;
  return options;
}

void check_quality(const SculptedRegion& made) {
  CHECK(made.quality.max_line_gap <= made.layout.tolerance());
  CHECK(made.quality.max_line_deviation <= made.layout.tolerance());
  CHECK(made.quality.max_line_residual < 1e-10);
  CHECK(made.sculpt.max_constraint_residual < 1e-12);
  CHECK(made.quality.min_jacobian_ratio > 0.05);
  CHECK(made.quality.singular_nodes == 0);
  CHECK(made.quality.max_normal_jump_deg < 1e-9);
}

// A rectangle with rounded corners, its sides straight and its corners quarter circles.
std::vector<CharacterLine> rounded_rectangle(double a, double b, double r, bool one_line) {
  std::vector<CharacterLine> lines;
  std::vector<Vec3> points;
  const Vec2 centre[4] = {{a - r, b - r}, {-a + r, b - r}, {-a + r, -b + r}, {a - r, -b + r}};
  for (int i = 0; i < 4; ++i) {
    const double from = i * pi / 2;
    const auto at = [=](double t) {
      return Vec3(centre[i].x() + r * std::cos(t), centre[i].y() + r * std::sin(t), 0);
    };
    lines.push_back({"corner " + std::to_string(i),
                     curve_from_formula(from, from + pi / 2,
                                        [=](double t, int order) -> Vec3 {
                                          if (order == 0) return at(t);
                                          const double s = t + order * pi / 2;
                                          return {r * std::cos(s), r * std::sin(s), 0};
                                        }),
                     Role::Outline});
    const double to = (i + 1) * pi / 2;
    const Vec2 next = centre[(i + 1) % 4];
    lines.push_back({"side " + std::to_string(i),
                     curve_through_points("side", {at(to), Vec3(next.x() + r * std::cos(to),
                                                                next.y() + r * std::sin(to), 0)}),
                     Role::Outline});
    for (int k = 0; k < 12; ++k) points.push_back(at(from + (to - from) * k / 12));
    const Vec3 end(next.x() + r * std::cos(to), next.y() + r * std::sin(to), 0);
    for (int k = 0; k < 12; ++k) points.push_back(at(to) + (end - at(to)) * k / 12.0);
  }
  if (!one_line) return lines;
  points.push_back(points.front());
  return {arc("outline", points, Role::Outline)};
}

}  // namespace

TEST_CASE("a disc: smooth outline, exact area and flatness", "[skinning][domains]") {
  for (const TriangleElement kind : kBothElements) {
    SkinOptions options = fine(0.3, 1e-5);
    options.element = kind;
    const SculptedRegion made({ellipse("rim", Role::Outline, {0, 0, 0}, 1, 1)}, options);
    check_quality(made);
    CHECK(made.layout.domain() == SkinOptions::Domain::Projected);
    CHECK(made.layout.trim()->area() * 8 == Approx(pi).epsilon(1e-4));  // size 2 √2
    CHECK(made.quality.area == Approx(pi).epsilon(1e-4));
    CHECK(made.sculpt.energy.bending < 1e-9);  // a difference of large numbers
    CHECK(made.quality.min_jacobian_ratio == Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a smaller tolerance costs triangles near the curve only, and is met",
          "[skinning][domains]") {
  int triangles = 0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const SculptedRegion made({ellipse("rim", Role::Outline, {0, 0, 0}, 1, 0.7, 0.2)},
                              fine(0.25, tolerance));
    check_quality(made);
    CHECK(made.layout.mesh()->triangle_count() >= triangles);
    triangles = made.layout.mesh()->triangle_count();
  }
  CHECK(triangles < 4000);
}

TEST_CASE("holes, ribs, closed inner curves, intersections and junctions on one wavy face",
          "[skinning][domains]") {
  const auto height = [](double x, double y) { return 0.2 * x * x + 0.1 * std::sin(2 * y); };
  const auto on = [&](double x, double y) { return Vec3(x, y, height(x, y)); };
  const auto loop = [&](const std::string& name, Role role, double x, double y, double a,
                        double b) {
    std::vector<Vec3> p;
    for (int i = 0; i < 36; ++i)
      p.push_back(on(x + a * std::cos(i * pi / 18), y + b * std::sin(i * pi / 18)));
    p.push_back(p.front());
    return arc(name, p, role);
  };
  const auto track = [&](const std::string& name, double x0, double y0, double x1, double y1,
                         double bow) {
    std::vector<Vec3> p;
    for (int i = 0; i <= 12; ++i) {
      const double s = i / 12.0;
      p.push_back(on(x0 + s * (x1 - x0), y0 + s * (y1 - y0) + bow * std::sin(pi * s)));
    }
    return arc(name, p, Role::Inner);
  };
  std::vector<CharacterLine> lines = {
      loop("outline", Role::Outline, 0, 0, 1, 0.8), loop("hole", Role::Hole, 0.5, 0.1, 0.12, 0.1),
      loop("hollow", Role::Inner, -0.5, -0.2, 0.2, 0.15), track("rib", -0.6, 0.3, 0.3, 0.35, 0.1),
      track("across", -0.1, -0.5, -0.05, 0.6, 0.02)};
  // A rib from the outline: its start is on it.
  const Vec3 rim = lines[0].curve->evaluate(lines[0].curve->start());
  lines.push_back(
      arc("from rim", {rim, on(0.85, -0.02), on(0.75, -0.1), on(0.6, -0.2)}, Role::Inner));
  // Points of a surface that does not minimise the energy: the curves intersect within the
  // tolerance only.
  const SculptedRegion made(lines, fine(0.12, 4e-3));
  check_quality(made);
  CHECK(made.layout.trim()->area() > 0);
  CHECK(made.region.boundary.size() == 2);
  // Where curves meet, one constraint equation fixes the surface for both.
  CHECK(AffineReduction(made.layout.line_constraints()).redundant_count() == 0);
}

TEST_CASE("a rounded rectangle as one curve and as eight", "[skinning][domains]") {
  for (const bool one_line : {true, false}) {
    const SculptedRegion made(rounded_rectangle(1, 0.6, 0.25, one_line), fine(0.15, 1e-4));
    check_quality(made);
    CHECK(made.quality.area == Approx(4 * 0.6 - (4 - pi) * 0.0625).epsilon(1e-3));
    CHECK(made.layout.corners().empty());
  }
}

TEST_CASE("the same polygonal face, aligned and embedded, is the same shape, within the gap",
          "[skinning][domains]") {
  std::vector<CharacterLine> lines;
  const Vec3 corner[4] = {{0, 0, 0}, {1.2, 0, 0.1}, {1.1, 1, 0.3}, {-0.1, 0.9, 0}};
  for (int i = 0; i < 4; ++i) {
    const Vec3 a = corner[i], d = corner[(i + 1) % 4] - a;
    lines.push_back(
        {"side " + std::to_string(i),
         bezier_curve(a, a + d / 3 + Vec3(0, 0, 0.15), a + 2 * d / 3 + Vec3(0, 0, 0.1), a + d),
         Role::Outline});
  }
  SkinOptions options = fine(0.06, 1e-4);
  const SculptedRegion fitted(lines, options);
  options.domain = SkinOptions::Domain::Projected;
  const SculptedRegion embedded(lines, options);
  CHECK(fitted.layout.embedded().empty());
  CHECK(embedded.layout.edge_aligned().empty());
  CHECK(embedded.layout.corners().size() == 4);
  check_quality(fitted);
  check_quality(embedded);
  // Both minimise bending, over domains that differ by a few per cent.
  double largest = 0;
  for (double u = 0.1; u < 1; u += 0.2)
    for (double v = 0.1; v < 0.9; v += 0.2) {
      const auto near = embedded.region.surface.closest_point({u, v, 0.15});
      largest = std::max(
          largest, fitted.region.surface.closest_point(embedded.region.surface.position(near.where))
                       .distance);
    }
  CHECK(largest < 3e-3);
  // Over the same domain, a flat parallelogram under a load, they converge to each other under
  // refinement.
  std::vector<CharacterLine> flat;
  const Vec3 edge[4] = {{0, 0, 0}, {1, 0, 0}, {1.3, 0.9, 0}, {0.3, 0.9, 0}};
  for (int i = 0; i < 4; ++i)
    flat.push_back(arc("side " + std::to_string(i), {edge[i], edge[(i + 1) % 4]}, Role::Outline));
  double before = 1;
  for (const double h : {0.16, 0.08, 0.04}) {
    double height[2];
    for (const bool cut : {false, true}) {
      SkinOptions o = fine(h, 1e-2);
      o.domain = cut ? SkinOptions::Domain::Projected : SkinOptions::Domain::Polygon;
      const RegionLayout layout("region", flat, o);
      SculptOptions absolute;
      absolute.units = LoadUnits::Absolute;
      const Surface surface =
          layout
              .region(batten::reference_solver::sculpt(layout, layout.line_constraints(),
                                                       {{"f", UniformLoad{{0, 0, 20}}}}, absolute)
                          .dofs)
              .surface;
      height[cut] = surface.position(surface.closest_point({0.65, 0.45, 0.05}).where).z();
    }
    const double off = std::abs(height[1] / height[0] - 1);
    INFO("h " << h << " off " << off);
    CHECK(off < 0.5 * before);
    before = off;
  }
  CHECK(before < 2e-3);
}

TEST_CASE("an embedded face does not depend on its unit or position", "[skinning][domains]") {
  const auto lines = [](double unit, const Vec3& by) {
    const auto scaled = [=](const CharacterLine& line) {
      const auto curve = line.curve;
      return CharacterLine{line.name,
                           curve_from_formula(curve->start(), curve->end(),
                                              [=](double t, int order) -> Vec3 {
                                                const Vec3 x = unit * curve->evaluate(t, order);
                                                return order == 0 ? Vec3(x + by) : x;
                                              }),
                           line.role};
    };
    return std::vector<CharacterLine>{
        scaled(ellipse("rim", Role::Outline, {0, 0, 0}, 1, 0.8, 0.2)),
        scaled(ellipse("hole", Role::Hole, {0.3, 0.1, 0.02}, 0.2, 0.15))};
  };
  const SculptedRegion metres(lines(1, {0, 0, 0}), fine(0.2, 1e-3)),
      millimetres(lines(1000, {0, 0, 0}), fine(200, 1)),
      far(lines(1, {3e5, -2e5, 1e5}), fine(0.2, 1e-3));
  CHECK(metres.layout.mesh()->triangle_count() == millimetres.layout.mesh()->triangle_count());
  CHECK(metres.layout.mesh()->triangle_count() == far.layout.mesh()->triangle_count());
  for (int v = 0; v < metres.layout.mesh()->vertex_count(); ++v)
    CHECK(metres.layout.mesh()->vertices()[v] == millimetres.layout.mesh()->vertices()[v]);
  CHECK(millimetres.quality.area == Approx(1e6 * metres.quality.area).epsilon(1e-9));
  CHECK(far.quality.area == Approx(metres.quality.area).epsilon(1e-6));
  CHECK(millimetres.sculpt.energy.bending == Approx(metres.sculpt.energy.bending).epsilon(1e-6));
  CHECK(far.sculpt.energy.bending == Approx(metres.sculpt.energy.bending).epsilon(1e-6));
  CHECK(far.quality.max_line_deviation <= far.layout.tolerance());
  CHECK(far.sculpt.max_constraint_residual < 1e-12);
}

TEST_CASE("a hole in a polygonal face is embedded, its outline stays exact",
          "[skinning][domains]") {
  if (!have_delaunay_mesher()) return;
  auto lines = rounded_rectangle(1, 0.6, 0.25, true);
  std::vector<CharacterLine> square;
  const Vec3 corner[4] = {{-1, -1, 0}, {1, -1, 0.2}, {1, 1, 0}, {-1, 1, 0.2}};
  for (int i = 0; i < 4; ++i)
    square.push_back(
        arc("side " + std::to_string(i), {corner[i], corner[(i + 1) % 4]}, Role::Outline));
  square.push_back(ellipse("hole", Role::Hole, {0.2, 0.1, 0.12}, 0.3, 0.2));
  const SculptedRegion made(square, fine(0.2, 1e-3));
  check_quality(made);
  CHECK(made.layout.domain() == SkinOptions::Domain::Polygon);
  CHECK(made.layout.edge_aligned().size() == 4);
  CHECK(made.quality.max_line_residual < 1e-14);
  CHECK(made.region.boundary.size() == 2);
  // The hole is empty, and the area decreases by that of the hole.
  square.pop_back();
  const SculptedRegion whole(square, fine(0.2, 1e-3));
  CHECK(whole.quality.area - made.quality.area == Approx(pi * 0.06).epsilon(0.02));
}

TEST_CASE("holes far smaller than an element do not disturb the surface", "[skinning][domains]") {
  if (!have_delaunay_mesher()) return;
  std::vector<CharacterLine> square;
  const Vec3 corner[4] = {{-1, -1, 0}, {1, -1, 0.4}, {1, 1, 0}, {-1, 1, 0.4}};
  for (int i = 0; i < 4; ++i)
    square.push_back(
        arc("side " + std::to_string(i), {corner[i], corner[(i + 1) % 4]}, Role::Outline));
  const double whole = SculptedRegion(square, fine(0.3, 2e-3)).sculpt.energy.bending;
  for (const double slim : {1.0, 0.1})
    for (const double r : {1e-2, 1e-3, 1e-4, 1e-5}) {
      auto lines = square;
      lines.push_back(ellipse("hole", Role::Hole, {0.2, 0.3, 0.188}, r, slim * r));
      const SculptedRegion made(lines, fine(0.3, 2e-3));
      INFO("r " << r << " slim " << slim << " energy " << made.sculpt.energy.bending / whole);
      check_quality(made);
      CHECK(made.sculpt.energy.bending <= 1.3 * whole);
      Vec3 sum = Vec3::Zero();
      for (const auto& reaction : made.sculpt.reactions) sum += reaction.force;
      CHECK(sum.norm() < 1e-6);
    }
}

TEST_CASE("an inner curve between corners is embedded, and refused if it must be aligned",
          "[skinning][domains]") {
  if (!have_delaunay_mesher()) return;
  std::vector<CharacterLine> lines;
  const Vec3 corner[4] = {{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 0.1}};
  for (int i = 0; i < 4; ++i)
    lines.push_back(
        arc("side " + std::to_string(i), {corner[i], corner[(i + 1) % 4]}, Role::Outline));
  lines.push_back(arc("diagonal", {corner[0], {0.5, 0.5, 0.05}, corner[2]}, Role::Inner));
  const SculptedRegion made(lines, fine(0.15, 1e-3));
  check_quality(made);
  CHECK(made.layout.embedded().size() == 1);
  lines.back().mesh_alignment = MeshAlignment::EdgeAligned;
  CHECK_THROWS_WITH(RegionLayout("region", lines, {}), Contains("ends at a corner"));
}

TEST_CASE("a wave between points that another curve displaced is still measured",
          "[skinning][domains]") {
  // Two ribs at a distance of 0.03, the second with ripples that the grid cannot resolve.
  std::vector<Vec3> a, b;
  for (int i = 0; i <= 200; ++i) {
    const double x = -0.5 + i / 200.0;
    a.emplace_back(x, 0, 0);
    b.emplace_back(x, 0.004, 0.01 * std::sin(60 * x));
  }
  const SculptedRegion made({ellipse("rim", Role::Outline, {0, 0, 0}, 1, 1),
                             arc("a", a, Role::Inner), arc("b", b, Role::Inner)},
                            fine(0.15, 2e-3));
  double found = 0;
  const TriangleLocator locator(made.region.surface.mesh());
  for (const EmbeddedLine& line : made.region.embedded)
    for (int i = 0; i < 3001; ++i) {
      const double t =
          line.pcurve.start() + (line.pcurve.end() - line.pcurve.start()) * (i + 0.5) / 3001;
      const Vec3 c = line.pcurve.evaluate(t);
      found = std::max(found, (made.region.surface.position(locator.locate({c.x(), c.y()})) -
                               line.fitted.evaluate(t))
                                  .norm());
    }
  CHECK(made.quality.max_line_gap >= 0.9 * found);
}

TEST_CASE("loads act on the inside of a cut surface only", "[skinning][domains]") {
  const std::vector<CharacterLine> lines = {ellipse("rim", Role::Outline, {0, 0, 0}, 1, 1),
                                            ellipse("hole", Role::Hole, {0.2, 0, 0}, 0.3, 0.3)};
  const RegionLayout layout("region", lines, fine(0.1, 1e-3));
  SculptOptions options;
  options.units = LoadUnits::Absolute;
  const Vec3 f(0, 0, 2);
  const double area = layout.trim()->area() * layout.size() * layout.size();
  CHECK(area == Approx(pi * (1 - 0.09)).epsilon(1e-4));
  const SculptResult r =
      sculpt(layout, layout.line_constraints(), {{"f", UniformLoad{f}}}, options);
  Vec3 sum = Vec3::Zero();
  for (const auto& reaction : r.reactions) sum += reaction.force;
  CHECK(sum.z() == Approx(-2 * area).epsilon(1e-9));
  const SculptResult p =
      sculpt(layout, layout.line_constraints(), {{"p", PressureLoad{0.1}}}, options);
  sum.setZero();
  for (const auto& reaction : p.reactions) sum += reaction.force;
  CHECK(sum.z() == Approx(-0.1 * area).epsilon(1e-3));
}

TEST_CASE("embedding refuses invalid curves with the reason", "[skinning][domains]") {
  const auto layout = [](const std::vector<CharacterLine>& l, SkinOptions o = fine(0.15, 1e-3)) {
    RegionLayout("region", l, o);
  };
  const auto rim = ellipse("rim", Role::Outline, {0, 0, 0}, 1, 1);
  CHECK_THROWS_WITH(layout({rim, ellipse("hole", Role::Hole, {2, 0, 0}, 0.2, 0.2)}),
                    Contains("curve 'hole' does not bound the face") && Contains("outside"));
  CHECK_THROWS_WITH(layout({rim, ellipse("hole", Role::Hole, {0.95, 0, 0}, 0.2, 0.2)}),
                    Contains("does not bound the face"));
  CHECK_THROWS_WITH(layout({rim, ellipse("a", Role::Hole, {0, 0, 0}, 0.4, 0.4),
                            ellipse("b", Role::Hole, {0, 0.05, 0}, 0.2, 0.2)}),
                    Contains("does not bound the face") && Contains("another hole"));
  CHECK_THROWS_WITH(layout({rim, arc("rib", {{0, 0, 0}, {1.3, 0.1, 0}}, Role::Inner)}),
                    Contains("inner curve 'rib' leaves the face near"));
  CHECK_THROWS_WITH(layout({rim, arc("low", {{-0.5, 0, 0}, {0.5, 0.01, 0}}, Role::Inner),
                            arc("high", {{0, -0.5, 0.2}, {0.02, 0.5, 0.2}}, Role::Inner)}),
                    Contains("'low' and 'high'") && Contains("apart in space"));
  CHECK_THROWS_WITH(layout({rim, ellipse("second", Role::Outline, {0, 0, 0}, 0.5, 0.5),
                            ellipse("third", Role::Outline, {0, 0, 0}, 0.2, 0.2)}),
                    Contains("3 loops"));
  auto fitted = rim;
  fitted.mesh_alignment = MeshAlignment::EdgeAligned;
  CHECK_THROWS_WITH(layout({fitted}), Contains("'rim' has alignment = \"aligned\""));
  SkinOptions polygon = fine(0.15, 1e-3);
  polygon.domain = SkinOptions::Domain::Polygon;
  CHECK_THROWS_WITH(layout({rim}, polygon), Contains("0 corners"));
  polygon.domain = SkinOptions::Domain::Annulus;
  CHECK_THROWS_WITH(layout({rim}, polygon),
                    Contains("found 1 loop of outline curves, expected two"));
  // A loop with a vertical part has no projection to its plane.
  CHECK_THROWS_WITH(layout({ellipse("rim", Role::Outline, {0, 0, 0}, 1, 1, 5, 2)}),
                    Contains("perpendicular") || Contains("does not bound"));
  CHECK_THROWS_WITH(layout({rim}, fine(1e-5, 1e-3)), Contains("triangles"));
}

TEST_CASE("outlines at random: a surface that keeps what it reports, or a reason",
          "[skinning][domains]") {
  int surfaces = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    Random random(seed);
    RandomResult r;
    try {
      r = skin_at_random(random_lines(random));
    } catch (const Error& e) {
      r.error_message = e.what();
    }
    INFO("seed " << seed << ": " << r.error_message << " reported " << r.reported << " found "
                 << r.found);
    if (!r.error_message.empty()) {
      CHECK(r.error_message.size() > 20);
      continue;
    }
    ++surfaces;
    CHECK(r.finite);
    CHECK(r.found <= 1.2 * r.reported + 1e-9);
  }
  CHECK(surfaces >= 75);
}
