// SPDX-License-Identifier: MPL-2.0
// Prescribed curves: used unchanged, with the same vertices on both sides.
#include <numbers>
#include <random>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/prescribed_lines.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
constexpr double kSize = 2.5;  // of a network around the regions

SkinnedRegion skinned(const RegionLayout& layout) {
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  const ConstrainedSolver solver(layout.line_constraints(),
                                 assembler.stiffness(SurfaceStiffness{}));
  return layout.region(solver.solve(Points::Zero(assembler.dofs().count(), 3)));
}

SkinOptions with_edge(double edge) {
  SkinOptions options;
  options.edge_length = edge;
  return options;
}

std::vector<CharacterLine> prescribed(const std::vector<CharacterLine>& lines, double edge,
                                      double size = kSize) {
  std::vector<CharacterLine> result;
  for (const CharacterLine& line : lines)
    result.push_back(prescribed_line(line.name, line.curve, size, edge));
  return result;
}

const EdgeAlignedLine& edge_aligned_line(const SkinnedRegion& region, const std::string& name) {
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
    if (aligned_line.line.name == name) return aligned_line;
  throw InputError("no run " + name);
}

// A loop of three to six large corners; its sides are divided at turns of 1 to 20 degrees in either
// direction, and bent by up to `bulge` of their length.
std::vector<CharacterLine> kinked_loop(unsigned seed, double bulge) {
  std::mt19937 engine(seed);
  const auto random = [&](double a, double b) { return a + (b - a) * (engine() / 4294967296.0); };
  const int sides = 3 + static_cast<int>(engine() % 4);
  std::vector<Vec3> corner;
  for (int i = 0; i < sides; ++i) {
    const double t = 2 * pi * (i + random(-0.2, 0.2)) / sides, r = random(0.7, 1.3);
    corner.emplace_back(r * std::cos(t), r * std::sin(t), random(-0.2, 0.2));
  }
  std::vector<CharacterLine> lines;
  for (int i = 0; i < sides; ++i) {
    const Vec3 &a = corner[i], &b = corner[(i + 1) % sides];
    const Vec3 out =
        random(-bulge, bulge) * (b - a).norm() * Vec3((b - a).y(), -(b - a).x(), 0).normalized() +
        Vec3(0, 0, random(-0.1, 0.1));
    const auto whole = bezier_curve(a, a + (b - a) / 3 + out, b - (b - a) / 3 + out, b);
    const int pieces = 1 + static_cast<int>(engine() % 4);
    std::vector<Vec3> x, in, leaving;
    for (int k = 0; k <= pieces; ++k) {
      const double s = static_cast<double>(k) / pieces;
      x.push_back(whole->evaluate(s));
      const Vec3 d = whole->evaluate(s, 1).normalized();
      const Vec3 side = (Vec3::UnitZ() - d.z() * d).normalized().cross(d);
      const double turning_angle = (engine() % 2 ? 1 : -1) * random(1, 20) * pi / 180;
      in.push_back((d - std::tan(turning_angle / 2) * side).normalized());
      leaving.push_back((d + std::tan(turning_angle / 2) * side).normalized());
    }
    for (int k = 0; k < pieces; ++k) {
      const double h = (x[k + 1] - x[k]).norm() / 3;
      lines.push_back(
          {std::to_string(i) + "." + std::to_string(k),
           bezier_curve(x[k], x[k] + h * leaving[k], x[k + 1] - h * in[k + 1], x[k + 1])});
    }
  }
  return lines;
}

}  // namespace

TEST_CASE("a given curve is the run, bit for bit, with its vertices and no others",
          "[skinning][layout]") {
  const auto lines = prescribed(curved_polygon(5, 0.2, 0.1), 0.13);
  for (const bool against : {false, true}) {
    SkinOptions options = with_edge(0.2);
    options.reverse_orientation = against;
    const RegionLayout layout("r", lines, options);
    REQUIRE(layout.edge_aligned().size() == lines.size());
    const SkinnedRegion region = skinned(layout);
    for (const CharacterLine& line : lines) {
      const EdgeAlignedLine& aligned_line = edge_aligned_line(region, line.name);
      CHECK(aligned_line.fitted.parameters() == line.prescribed->curve.parameters());
      CHECK(aligned_line.fitted.dofs() == line.prescribed->curve.dofs());
      CHECK(aligned_line.parameters == line.prescribed->vertices);
      CHECK(aligned_line.line.curve == line.curve);
    }
    const SkinQuality quality = measure(region);
    CHECK(quality.max_line_residual < 1e-12);
    CHECK(quality.min_jacobian_ratio > 0.3);
  }
}

TEST_CASE("faces on both sides of given curves share positions along them", "[skinning][layout]") {
  // Two quadrilaterals with a common wavy curve, of different shape and edge length.
  const auto p = [](double x, double y, double z) { return Vec3(x, y, z); };
  const auto wave = bezier_curve(p(0, 0, 0), p(0.4, 0.3, 0.2), p(0.2, 0.7, -0.2), p(0, 1, 0));
  const CharacterLine shared = prescribed_line("shared", wave, kSize, 0.11);
  const auto side = [&](const std::string& name, const Vec3& a, const Vec3& b) {
    return prescribed_line(name, curve_through_points(name, {a, b}), kSize, 0.15);
  };
  const SkinnedRegion left = skinned(
      RegionLayout("left",
                   {shared, side("a", p(0, 1, 0), p(-1, 1.2, 0.3)),
                    side("b", p(-1, 1.2, 0.3), p(-1, 0, 0)), side("c", p(-1, 0, 0), p(0, 0, 0))},
                   with_edge(0.1)));
  const SkinnedRegion right = skinned(RegionLayout(
      "right", {side("d", p(0, 0, 0), p(2, -0.5, 0)), side("e", p(2, -0.5, 0), p(0, 1, 0)), shared},
      with_edge(0.3)));
  const EdgeAlignedLine &a = edge_aligned_line(left, "shared"),
                        &b = edge_aligned_line(right, "shared");
  REQUIRE(a.parameters == b.parameters);
  for (size_t i = 0; i < a.vertices.size(); ++i) {
    const Vec3 x = left.surface.dofs().row(3 * a.vertices[i]),
               y = right.surface.dofs().row(3 * b.vertices[i]);
    CHECK((x - y).norm() < 1e-14);
    CHECK((x - shared.prescribed->curve.evaluate(a.parameters[i])).norm() < 1e-14);
  }
}

TEST_CASE("smoothly continuing curves share a side, others form a corner, however small its angle",
          "[skinning][layout]") {
  // A side of two segments of one curve, and one with a turn of a degree.
  const auto p = [](double x, double y, double z) { return Vec3(x, y, z); };
  const auto arc = curve_from_formula(0, 1, [](double t, int order) -> Vec3 {
    if (order == 0) return {t, 0.2 * t * (t - 1), 0};
    if (order == 1) return {1, 0.4 * t - 0.2, 0};
    return {0, 0.4, 0};
  });
  const CharacterLine whole = prescribed_line("whole", arc, kSize, 0.1);
  const HermiteCurve& curve = whole.prescribed->curve;
  const HermiteCurve cut = curve.with_nodes({0.15});
  const auto part = [&](const std::string& name, int from, int to) {
    std::vector<double> u(cut.parameters().begin() + from, cut.parameters().begin() + to + 1);
    Points x(to - from + 1, 3), d(to - from + 1, 3);
    for (int i = from; i <= to; ++i) {
      x.row(i - from) = cut.position(i);
      d.row(i - from) = cut.slope_out(i);
    }
    auto prescribed = std::make_shared<PrescribedCurve>(PrescribedCurve{HermiteCurve(u, x, d), u});
    CharacterLine line{name, curve_from_hermite(prescribed->curve)};
    line.prescribed = prescribed;
    return line;
  };
  const int node = static_cast<int>(
      std::find(cut.parameters().begin(), cut.parameters().end(), 0.15) - cut.parameters().begin());
  const auto straight = [&](const std::string& name, const Vec3& a, const Vec3& b) {
    return prescribed_line(name, curve_through_points(name, {a, b}), kSize, 0.2);
  };
  const double degree = pi / 180;
  const Vec3 middle = p(1, 1, 0) + 0.5 * p(-1, std::sin(degree), 0);
  const std::vector<CharacterLine> lines = {part("first", 0, node),
                                            part("second", node, cut.node_count() - 1),
                                            straight("right", p(1, 0, 0), p(1, 1, 0)),
                                            straight("top", p(1, 1, 0), middle),
                                            straight("top left", middle, p(0, 1, 0)),
                                            straight("left", p(0, 1, 0), p(0, 0, 0))};
  const RegionLayout layout("r", lines, with_edge(0.15));
  CHECK(layout.domain() == SkinOptions::Domain::Polygon);
  REQUIRE(layout.corners().size() == 5);
  const SkinnedRegion region = skinned(layout);
  CHECK(measure(region).min_jacobian_ratio > 0.3);
  // C1 across the junction: the two segments are on one straight line, with the same speed.
  const EdgeAlignedLine &a = edge_aligned_line(region, "first"),
                        &b = edge_aligned_line(region, "second");
  const HermiteCurve in = edge_aligned_pcurve(*layout.mesh(), a),
                     out = edge_aligned_pcurve(*layout.mesh(), b);
  CHECK((in.slope_in(1) - out.slope_out(0)).norm() < 1e-12 * in.slope_in(1).norm());
  // The corner of one or two degrees has a Jacobian like any other.
  for (const DomainCorner& corner : layout.corners())
    if (corner.line_angle_deg > 170)
      CHECK(std::sin(corner.line_angle_deg * degree) / std::sin(corner.domain_angle_deg * degree) ==
            Approx(1).epsilon(0.1));
}

TEST_CASE("loops with many corners of a few degrees keep their Jacobian", "[skinning][layout]") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    INFO(seed);
    const auto lines = prescribed(kinked_loop(seed, 0.1), 0.15);
    const RegionLayout layout("r", lines, with_edge(0.15));
    if (layout.domain() == SkinOptions::Domain::Polygon)
      for (const DomainCorner& corner : layout.corners()) {
        const double degree = pi / 180;
        const double ratio =
            std::sin(corner.line_angle_deg * degree) / std::sin(corner.domain_angle_deg * degree);
        CHECK(ratio > 0.3);
        CHECK(ratio < 3);
      }
    const SkinQuality quality = measure(skinned(layout));
    CHECK(quality.min_jacobian_ratio > 0.1);
    CHECK(quality.max_line_residual < 1e-11);
  }
}

TEST_CASE("reversing the first curve of an outline flips the normal and nothing else",
          "[skinning][layout]") {
  const auto lines = prescribed(curved_polygon(4, 0.2, 0.1), 0.15);
  SkinOptions options = with_edge(0.15);
  const SkinnedRegion along = skinned(RegionLayout("r", lines, options));
  options.reverse_orientation = true;
  const SkinnedRegion against = skinned(RegionLayout("r", lines, options));
  const Location middle = along.surface.locate(Vec2::Zero());
  const auto foot_point = against.surface.closest_point(along.surface.position(middle));
  CHECK(foot_point.distance < 1e-3);
  CHECK(along.surface.jet(middle).normal().dot(against.surface.jet(foot_point.where).normal()) <
        -0.99);
  CHECK(measure(along).area == Approx(measure(against).area).epsilon(1e-4));
  // Also for mesh-aligned curves.
  for (const bool turned : {false, true}) {
    SkinOptions plain;
    plain.reverse_orientation = turned;
    const SkinnedRegion flat = skinned(
        RegionLayout("r", polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), plain));
    CHECK(flat.surface.jet({0, Vec3::Constant(1.0 / 3)}).normal().z() == Approx(turned ? -1 : 1));
  }
}

TEST_CASE("given curves in mm and in m make one mesh", "[skinning][layout]") {
  const auto in_m = prescribed(curved_polygon(5, 0.2, 0.1), 0.15, 2.5),
             in_mm = prescribed(curved_polygon(5, 0.2, 0.1, 1000), 150, 2500);
  const RegionLayout a("r", in_m, with_edge(0.15)), b("r", in_mm, with_edge(150));
  REQUIRE(a.mesh()->triangle_count() == b.mesh()->triangle_count());
  CHECK(a.mesh()->triangles() == b.mesh()->triangles());
  for (int v = 0; v < a.mesh()->vertex_count(); ++v)
    CHECK((a.mesh()->vertices()[v] - b.mesh()->vertices()[v]).norm() < 1e-14);
}

TEST_CASE("given curves around a loop without corners enough are embedded as they are",
          "[skinning][layout]") {
  // Two smoothly connected arcs, in the projected and in the developable domain.
  const auto half = [](double from) {
    return curve_from_formula(from, from + pi, [](double t, int order) -> Vec3 {
      if (order == 0) return {std::cos(t), std::sin(t), 0.2 * std::cos(2 * t)};
      if (order == 1) return {-std::sin(t), std::cos(t), -0.4 * std::sin(2 * t)};
      return {-std::cos(t), -std::sin(t), -0.8 * std::cos(2 * t)};
    });
  };
  const std::vector<CharacterLine> lines = prescribed({{"a", half(0)}, {"b", half(pi)}}, 0.2);
  for (const auto domain : {SkinOptions::Domain::Projected, SkinOptions::Domain::Developable}) {
    SkinOptions options = with_edge(0.2);
    options.domain = domain;
    const RegionLayout layout("r", lines, options);
    REQUIRE(layout.embedded().size() == 2);
    for (size_t i = 0; i < 2; ++i) {
      CHECK(layout.embedded()[i].fitted.dofs() == lines[i].prescribed->curve.dofs());
      CHECK(layout.embedded()[i].pcurve.start() == layout.embedded()[i].fitted.start());
      CHECK(layout.embedded()[i].pcurve.end() == layout.embedded()[i].fitted.end());
    }
    const SkinQuality quality = measure(skinned(layout));
    CHECK(quality.max_line_gap < layout.tolerance());
    CHECK(quality.min_jacobian_ratio > 0.5);
  }
}

TEST_CASE("errors in given curves are reported", "[skinning][layout]") {
  const auto lines = prescribed(curved_polygon(4, 0.1, 0.1), 0.2);
  const auto refused = [&](auto&& change) {
    auto wrong = lines;
    PrescribedCurve curve = *wrong[1].prescribed;
    change(curve);
    wrong[1].prescribed = std::make_shared<const PrescribedCurve>(curve);
    try {
      RegionLayout("r", wrong, with_edge(0.2));
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK_THAT(refused([](PrescribedCurve& c) { c.vertices.clear(); }), Contains("'side 2'"));
  CHECK_THAT(refused([](PrescribedCurve& c) { c.vertices.back() *= 2; }),
             Contains("expected vertices from its start"));
  CHECK_THAT(refused([](PrescribedCurve& c) { std::swap(c.vertices[1], c.vertices[2]); }),
             Contains("do not increase"));
  CHECK_THAT(
      refused([](PrescribedCurve& c) { c.curve = c.curve.with_nodes({0.37 * c.curve.end()}); }),
      Contains("node"));
  CHECK_THAT(refused([](PrescribedCurve& c) { c.curve = HermiteCurve(); }), Contains("empty"));
  auto mixed = lines;
  mixed[2].prescribed = nullptr;
  CHECK_THROWS_WITH(RegionLayout("r", mixed, with_edge(0.2)), Contains("only one is prescribed"));
  SkinOptions fan = with_edge(0.2);
  fan.mesher = SkinOptions::Mesher::Fan;
  CHECK_THROWS_WITH(RegionLayout("r", lines, fan), Contains("delaunay"));
}
