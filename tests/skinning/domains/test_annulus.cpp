// SPDX-License-Identifier: MPL-2.0
// Annular domains: periodic strips between two smooth boundary circles reproduce both exactly,
// without a seam.
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/domains/annulus_domain.h"

#include <Eigen/Dense>
#include <algorithm>
#include <numbers>
#include <set>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

// radius(t) (cos t, sin t) at height(t), one full turn from `start`, rotated by Q and moved to
// `origin`.
struct RimShape {
  double radius = 1, height = 0;
  double wave = 0, hills = 0;  // amplitudes of cos 3t in the radius, of cos 2t in the height
  double start = 0;
  int direction = 1;
  Mat3 Q = Mat3::Identity();
  Vec3 origin = Vec3::Zero();

  Vec3 operator()(double s, int order) const {
    const double t = start + direction * s;
    const auto wave_at = [](double k, double x, int d) {
      return std::pow(k, d) * std::cos(k * x + d * pi / 2);
    };
    const double r[3] = {radius + wave * wave_at(3, t, 0), wave * wave_at(3, t, 1),
                         wave * wave_at(3, t, 2)};
    Vec3 x(0, 0, hills * wave_at(2, t, order) + (order == 0 ? height : 0));
    constexpr int binomial[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 2, 1}};
    for (int k = 0; k <= order; ++k) {
      x.x() += binomial[order][k] * r[order - k] * std::cos(t + k * pi / 2);
      x.y() += binomial[order][k] * r[order - k] * std::sin(t + k * pi / 2);
    }
    return std::pow(direction, order) * (Q * x) + (order == 0 ? origin : Vec3(0, 0, 0));
  }
};

SmoothSegment whole(const std::string& name, const RimShape& shape) {
  return {name, CharacterLine::Role::Outline, curve_from_formula(0, 2 * pi, shape)};
}

// The boundary divided at the given fractions; odd segments are reversed.
std::vector<SmoothSegment> parts(const std::string& name, const RimShape& shape,
                                 const std::vector<double>& shares) {
  std::vector<SmoothSegment> all;
  for (size_t i = 0; i < shares.size(); ++i) {
    const double to = i + 1 < shares.size() ? shares[i + 1] : shares[0] + 1;
    auto curve = curve_from_formula(2 * pi * shares[i], 2 * pi * to, shape);
    all.push_back({name + std::to_string(i + 1), CharacterLine::Role::Outline,
                   i % 2 ? reversed(curve) : curve});
  }
  return all;
}

// Both boundaries, with segments in any order; the first segment is on boundary A.
RegionGeometry make_annulus_geometry(const std::vector<SmoothSegment>& a,
                                     const std::vector<SmoothSegment>& b, double size,
                                     double tolerance, double edge) {
  std::vector<SmoothSegment> all = a;
  all.insert(all.end(), b.begin(), b.end());
  DomainInput task{{}, size, std::max(tolerance, 1e-6 * size)};
  task.options.tolerance = tolerance;
  task.options.edge_length = edge;
  const auto loops = make_loops(all, size, task.gap_tolerance, task.options.corner_angle);
  REQUIRE(loops.size() == 2);
  return make_annulus_geometry(loops[0], loops[1], task);
}

SkinnedRegion solved(const RegionGeometry& ring, double size,
                     TriangleElement element = TriangleElement::HCT,
                     const SurfaceStiffness& material = {}) {
  ConstraintSet set(DofMap(*ring.mesh).count());
  SurfaceConstraints shape(*ring.mesh, element, set);
  for (const EdgeAlignedLine& aligned_line : ring.edge_aligned)
    shape.curve(aligned_line.line.name, aligned_line.vertices, aligned_line.parameters,
                aligned_line.fitted, ring.mesh->chain_vector(aligned_line.vertices));
  const SurfaceAssembler assembler(*ring.mesh, element);
  const ConstrainedSolver solver(set, assembler.stiffness(material),
                                 nested_dissection_order(*ring.mesh));
  return {"ring",
          Surface(ring.mesh, element, solver.solve(Points::Zero(set.dof_count(), 3))),
          ring.edge_aligned,
          size,
          {},
          ring.boundary};
}

void check_exact(const SkinnedRegion& region, double tolerance, double size_of_numbers = 1) {
  const SkinQuality q = measure(region);
  CHECK(q.max_line_residual <= 1e-12 * size_of_numbers);
  CHECK(q.max_line_deviation <= tolerance);
  CHECK(q.max_normal_jump_deg <= 1e-10 * size_of_numbers);
  CHECK(q.min_jacobian_ratio >= 0.05);
  CHECK(q.singular_nodes == 0);
}

// The two loops are closed, with the strip to their left.
void check_boundary(const SkinnedRegion& region) {
  REQUIRE(region.boundary.size() == 2);
  const double period = region.surface.mesh().period();
  for (int loop = 0; loop < 2; ++loop) {
    double u = 0;
    const auto& segments = region.boundary[loop];
    for (size_t i = 0; i < segments.size(); ++i) {
      const HermiteCurve pcurve = boundary_pcurve(region, segments[i]);
      u += pcurve.evaluate(pcurve.end()).x() - pcurve.evaluate(pcurve.start()).x();
      const HermiteCurve here = boundary_curve(region, segments[i]),
                         next = boundary_curve(region, segments[(i + 1) % segments.size()]);
      CHECK((here.evaluate(here.end()) - next.evaluate(next.start())).norm() < 1e-12);
    }
    CHECK(u == Approx(loop == 0 ? period : -period));
  }
}

// Largest distance from samples of one surface to the other.
double distance(const Surface& from, const Surface& to) {
  double worst = 0;
  const int step = std::max(1, from.mesh().triangle_count() / 12);
  for (int t = 0; t < from.mesh().triangle_count(); t += step)
    worst = std::max(worst, to.closest_point(from.position({t, Vec3::Constant(1.0 / 3)})).distance);
  return worst;
}

}  // namespace

TEST_CASE("two equal circles make the minimiser of the bending energy, of order 3 or more",
          "[skinning][domains]") {
  // x = f(v) (cos u, sin u), u and v in units of the circle's angle: ∬ w_uu² + 2 w_uv² + w_vv² = π
  // ∫ f² + 2 f'² + f''², so f'''' - 2 f'' + f = 0, and f'' = 0 at the boundaries: f = a cosh v + b
  // v sinh v.
  constexpr double height = 1.2, size = 3.1;
  const double h = height / 2, c = std::cosh(h), s = std::sinh(h);
  Mat2 A;
  A << c, h * s, c, 2 * c + h * s;
  const Vec2 ab = A.inverse() * Vec2(1, 0);
  for (const auto element : kBothElements) {
    std::vector<double> errors;
    double tolerance = 1e-4;
    for (const double edge : {0.4, 0.2, 0.1}) {
      const RegionGeometry ring =
          make_annulus_geometry({whole("low", {.height = 0})}, {whole("high", {.height = height})},
                                size, tolerance, edge);
      const SkinnedRegion region = solved(ring, size, element);
      check_exact(region, tolerance);
      check_boundary(region);
      double worst = 0;
      for (int t = 0; t < ring.mesh->triangle_count(); ++t)
        for (const Vec3& L : {Vec3(1, 1, 1), Vec3(3, 0, 0), Vec3(0, 1.5, 1.5)}) {
          const Vec2 p = ring.mesh->shape(t).point(L / 3);
          const double angle = 2 * pi * p.x() / ring.mesh->period(), v = p.y() * size - h;
          const double f = ab[0] * std::cosh(v) + ab[1] * v * std::sinh(v);
          const Vec3 exact(f * std::cos(angle), f * std::sin(angle), p.y() * size);
          worst = std::max(worst, (region.surface.position({t, L / 3}) - exact).norm());
        }
      errors.push_back(worst);
      tolerance /= 10;
    }
    INFO(name(element) << ": " << errors[0] << ", " << errors[1] << ", " << errors[2]);
    CHECK(errors[0] < 1e-3);
    CHECK(errors[0] / errors[1] > 8);
    CHECK(errors[1] / errors[2] > 8);
  }
}

TEST_CASE("an annulus has no dofs twice: Euler's number 0, every column meets itself",
          "[skinning][domains]") {
  const RegionGeometry ring = make_annulus_geometry(
      {whole("low", {.radius = 1})}, {whole("high", {.radius = 0.6, .height = 1})}, 3, 1e-4, 0.2);
  const ParametricMesh& mesh = *ring.mesh;
  CHECK(mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count() == 0);
  std::set<std::pair<double, double>> places;
  for (const Vec2& p : mesh.vertices()) places.insert({p.x(), p.y()});
  CHECK(static_cast<int>(places.size()) == mesh.vertex_count());
  // Right triangles, nearly square cells of the requested length.
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    std::vector<double> l;
    for (const int e : mesh.edges_of(t)) l.push_back(3 * mesh.edge_length(e));
    std::sort(l.begin(), l.end());
    CHECK(l[2] * l[2] == Approx(l[0] * l[0] + l[1] * l[1]));
    CHECK(l[0] > 0.5 * 0.2);
    CHECK(l[1] < 1.5 * 0.2);
  }
  for (const EdgeAlignedLine& aligned_line : ring.edge_aligned) {
    CHECK(aligned_line.vertices.front() == aligned_line.vertices.back());
    CHECK(aligned_line.edges.size() + 1 == aligned_line.vertices.size());
    CHECK(aligned_line.parameters.front() == aligned_line.fitted.start());
    CHECK(aligned_line.parameters.back() == aligned_line.fitted.end());
    CHECK(aligned_line.fitted.closed());
  }
}

TEST_CASE("unequal, wavy and tilted boundaries, near and far, converge to one shape",
          "[skinning][domains]") {
  Mat3 tilt;
  tilt = Eigen::AngleAxisd(0.4, Vec3(1, 0.3, 0).normalized());
  const RimShape goblet[2] = {{.radius = 1, .wave = 0.12, .hills = 0.1},
                              {.radius = 0.7, .height = 1.1, .wave = -0.1, .hills = 0.15}};
  const RimShape cone[2] = {{.radius = 1}, {.radius = 0.5, .height = 0.8}};
  const RimShape tilted[2] = {{.radius = 1}, {.radius = 0.8, .height = 1.3, .Q = tilt}};
  for (const auto& rims : {goblet, cone, tilted})
    for (const auto element : kBothElements) {
      if (element == TriangleElement::Z12 && rims != goblet) continue;
      std::vector<SkinnedRegion> regions;
      double tolerance = 1e-4;
      for (const double edge : {0.4, 0.2, 0.1}) {
        regions.push_back(
            solved(make_annulus_geometry({whole("low", rims[0])}, {whole("high", rims[1])}, 3,
                                         tolerance, edge),
                   3, element));
        check_exact(regions.back(), tolerance);
        check_boundary(regions.back());
        tolerance /= 10;
      }
      const double first = distance(regions[0].surface, regions[2].surface),
                   second = distance(regions[1].surface, regions[2].surface);
      INFO(name(element) << ": " << first << ", " << second);
      CHECK(first < 2e-3);
      CHECK(first / second > 4);
    }
  // The same annulus far from the origin.
  RimShape far[2] = {goblet[0], goblet[1]};
  for (RimShape& rim : far) rim.origin = Vec3(1e4, -2e4, 3e4);
  const auto near_ring = make_annulus_geometry({whole("a", goblet[0])}, {whole("b", goblet[1])}, 3,
                                               1e-4, 0.15),
             far_ring =
                 make_annulus_geometry({whole("a", far[0])}, {whole("b", far[1])}, 3, 1e-4, 0.15);
  REQUIRE(near_ring.mesh->vertex_count() == far_ring.mesh->vertex_count());
  const SkinnedRegion region = solved(far_ring, 3);
  check_exact(region, 1e-4, 1e4);
  Points back = region.surface.dofs();
  for (int v = 0; v < far_ring.mesh->vertex_count(); ++v)
    back.row(3 * v) -= far[0].origin.transpose();
  CHECK((back - solved(near_ring, 3).surface.dofs()).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("where a boundary's curve starts, and in which direction it runs, does not matter",
          "[skinning][domains]") {
  const RimShape low{.radius = 1, .wave = 0.12, .hills = 0.1},
      high{.radius = 0.7, .height = 1.1, .wave = -0.1, .hills = 0.15};
  const auto ring = [&](double start_low, double start_high, int direction, double edge) {
    RimShape a = low, b = high;
    a.start = start_low;
    b.start = start_high;
    b.direction = direction;
    return solved(make_annulus_geometry({whole("low", a)}, {whole("high", b)}, 3,
                                        0.01 * std::pow(edge, 4), edge),
                  3);
  };
  // Only boundary B changes: the domain and the whole shape are the same.
  const SkinnedRegion plain = ring(0, 0, 1, 0.15);
  for (const int direction : {1, -1})
    for (const double start : {0.7, 6.2}) {
      const SkinnedRegion other = ring(0, start, direction, 0.15);
      INFO(start << " " << direction);
      check_boundary(other);
      CHECK(distance(other.surface, plain.surface) < 5e-5);
    }
  // Boundary A changes: the columns move, the shape changes only by the discretisation error.
  const double coarse = distance(ring(1.1, 2.3, 1, 0.3).surface, ring(0, 0, 1, 0.3).surface),
               fine = distance(ring(1.1, 2.3, 1, 0.15).surface, plain.surface);
  INFO(coarse << ", " << fine);
  CHECK(coarse < 2e-3);
  CHECK(coarse / fine > 4);
}

TEST_CASE("boundaries of several curves, one run each, in any order and direction",
          "[skinning][domains]") {
  const RimShape low{.radius = 1, .wave = 0.12, .hills = 0.1},
      high{.radius = 0.7, .height = 1.1, .wave = -0.1, .hills = 0.15};
  const SkinnedRegion plain =
      solved(make_annulus_geometry({whole("low", low)}, {whole("high", high)}, 3, 1e-5, 0.12), 3);
  const std::vector<std::vector<double>> cuts = {{0}, {0, 0.37}, {0.98, 1.31, 1.8}};
  for (const auto& a : cuts)
    for (const auto& b : cuts) {
      auto lines = parts("low", low, a), others = parts("high", high, b);
      std::reverse(others.begin(), others.end());
      const RegionGeometry ring = make_annulus_geometry(lines, others, 3, 1e-5, 0.12);
      INFO(a.size() << " and " << b.size() << " lines");
      REQUIRE(ring.edge_aligned.size() == lines.size() + others.size());
      const SkinnedRegion region = solved(ring, 3);
      check_exact(region, 1e-5);
      check_boundary(region);
      // The input curve, in its input direction.
      for (const EdgeAlignedLine& aligned_line : ring.edge_aligned)
        if (!aligned_line.fitted.closed()) {
          const InputCurve& line = *aligned_line.line.curve;
          CHECK((aligned_line.fitted.evaluate(aligned_line.fitted.start()) -
                 line.evaluate(line.start()))
                    .norm() < 1e-9);
          CHECK(
              (aligned_line.fitted.evaluate(aligned_line.fitted.end()) - line.evaluate(line.end()))
                  .norm() < 1e-9);
        }
      CHECK(distance(region.surface, plain.surface) < 1e-4);
    }
}

TEST_CASE("the normal points to the side given by boundary A's direction, and never flips",
          "[skinning][domains]") {
  for (const int direction : {1, -1}) {
    const SkinnedRegion region =
        solved(make_annulus_geometry({whole("low", {.radius = 1, .direction = direction})},
                                     {whole("high", {.radius = 0.7, .height = 0.9})}, 3, 1e-4, 0.2),
               3);
    for (int t = 0; t < region.surface.mesh().triangle_count(); ++t) {
      const SurfaceJet jet = region.surface.jet({t, Vec3::Constant(1.0 / 3)});
      CHECK(direction * jet.normal().dot(Vec3(jet.x.x(), jet.x.y(), 0).normalized()) > 0.5);
    }
  }
}

TEST_CASE("an annulus is flat if its boundaries lie in one plane", "[skinning][domains]") {
  const SkinnedRegion region =
      solved(make_annulus_geometry({whole("outer", {.radius = 1})},
                                   {whole("inner", {.radius = 0.4})}, 3, 1e-5, 0.1),
             3);
  check_exact(region, 1e-5);
  CHECK(region.surface.dofs().col(2).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(measure(region).area == Approx(pi * (1 - 0.16)).epsilon(1e-3));
}

TEST_CASE("mm and m make the same annulus", "[skinning][domains]") {
  const auto ring = [](double unit) {
    RimShape a{.radius = unit, .wave = 0.12 * unit}, b{.radius = 0.7 * unit, .height = 1.1 * unit};
    b.start = 0.4;
    return make_annulus_geometry({whole("a", a)}, {whole("b", b)}, 3 * unit, 1e-5 * unit,
                                 0.15 * unit);
  };
  const RegionGeometry m = ring(1), mm = ring(1000);
  CHECK(m.mesh->triangles() == mm.mesh->triangles());
  REQUIRE(m.mesh->vertex_count() == mm.mesh->vertex_count());
  double worst = 0;
  for (int v = 0; v < m.mesh->vertex_count(); ++v)
    worst = std::max(worst, (m.mesh->vertices()[v] - mm.mesh->vertices()[v]).norm());
  CHECK(worst < 1e-8);
}

TEST_CASE("boundaries that form no annulus are refused with the reason", "[skinning][domains]") {
  const auto make = [](const std::vector<SmoothSegment>& a, const std::vector<SmoothSegment>& b,
                       double edge = 0.2) { make_annulus_geometry(a, b, 3, 1e-4, edge); };
  const SmoothSegment low = whole("low", {}), high = whole("high", {.height = 1});
  CHECK_NOTHROW(make({low}, {high}));
  const std::vector<Vec3> triangle = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 1}};
  CHECK_THROWS_WITH(make({low}, split_at_corners({"t", curve_through_points("t", triangle)}, 20)),
                    Contains("must be smooth") && Contains("'t.1'") && Contains("degrees"));
  CHECK_THROWS_WITH(make({low}, {high}, 1e-4), Contains("triangles") && Contains("unit"));
}
