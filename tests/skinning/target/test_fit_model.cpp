// SPDX-License-Identifier: MPL-2.0
// Models fitted to given surfaces: as close as the triangles allow, with their curves kept.
#include "batten/skinning/target/fit_model.h"

#include <cmath>
#include <numbers>

#include "batten/benchmarks/analytic_shapes.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sample_lines.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// An unbounded surface given by a function.
class FormulaTarget : public TargetSurface {
 public:
  explicit FormulaTarget(const bench::Formula& formula) : formula_(formula) {
    formula_.closest(Vec3::Zero());  // computes its samples once
  }
  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto foot_point = formula_.closest(p);
    if (!along.isZero(0) && foot_point.normal.dot(along) <= 0) return {};
    return Nearest{foot_point.at, foot_point.normal, false};
  }
  std::vector<Nearest> samples() const override {
    std::vector<Nearest> points;
    for (int i = 0; i < 20; ++i)
      for (int j = 0; j < 20; ++j) {
        const Vec3 at = formula_((i + 0.5) / 20, (j + 0.5) / 20);
        points.push_back({at, formula_.closest(at).normal, false});
      }
    return points;
  }

 private:
  const bench::Formula& formula_;
};

/// The plane z = 0.05 up to x = 0.5.
class HalfPlane : public TargetSurface {
 public:
  std::optional<Nearest> nearest(const Vec3& p, const Vec3&) const override {
    return Nearest{{std::min(p.x(), 0.5), p.y(), 0.05}, Vec3::UnitZ(), p.x() >= 0.5};
  }
  std::vector<Nearest> samples() const override {
    return {{{0.25, 0.5, 0.05}, Vec3::UnitZ(), false}};
  }
};

/// z = 16 h x (1 - x) y (1 - y) over the unit square, as flat triangles.
class Hill : public TargetSurface {
 public:
  explicit Hill(double height) : mesh_(grid(height)) {}
  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        mesh_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return Nearest{found->at, found->normal, found->on_boundary};
  }
  std::vector<Nearest> samples() const override {
    std::vector<Nearest> points;
    for (int t = 0; t < mesh_.mesh().triangle_count(); t += 7)
      points.push_back({mesh_.triangle(t).at(Vec3::Constant(1.0 / 3)),
                        mesh_.mesh().area_vector(t).normalized(), false});
    return points;
  }

 private:
  static PnTriangleMesh grid(double height) {
    constexpr int n = 40;
    Points points((n + 1) * (n + 1), 3);
    std::vector<std::array<int, 3>> triangles;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double x = double(i) / n, y = double(j) / n;
        const int a = j * (n + 1) + i;
        points.row(a) << x, y, 16 * height * x * (1 - x) * y * (1 - y);
        if (i == n || j == n) continue;
        triangles.push_back({a, a + 1, a + n + 2});
        triangles.push_back({a, a + n + 2, a + n + 1});
      }
    return PnTriangleMesh(TriangleMesh(points, triangles));
  }
  PnTriangleMesh mesh_;
};

/// Most of the unit sphere, above a circle of radius 0.5 in the plane z = 0.
class Balloon : public TargetSurface {
 public:
  explicit Balloon(bool mapped) : mapped_(mapped), mesh_(sphere()) {}
  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        mesh_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return Nearest{found->at, found->normal, found->on_boundary};
  }
  std::vector<Nearest> samples() const override { return {*nearest({0, 0, 3}, Vec3::Zero())}; }
  Parametrization parametrize(const std::function<Vec2(const Vec3&)>& rim) const override {
    if (!mapped_) return {};
    return [map = std::make_shared<HarmonicMap>(mesh_, rim)](const Vec2& p) {
      return map->surface_point(p);
    };
  }

 private:
  static PnTriangleMesh sphere() {
    constexpr int rings = 60, around = 60;
    const double last = std::numbers::pi - std::asin(0.5), below = std::cos(last);
    Points points(1 + rings * around, 3);
    points.row(0) << 0, 0, 1 - below;
    std::vector<std::array<int, 3>> triangles;
    std::vector<PnTriangle::Corners> normals;
    for (int r = 1; r <= rings; ++r)
      for (int i = 0; i < around; ++i) {
        const double down = last * r / rings, angle = 2 * std::numbers::pi * i / around;
        const int c = 1 + (r - 1) * around + i, d = 1 + (r - 1) * around + (i + 1) % around;
        points.row(c) << std::sin(down) * std::cos(angle), std::sin(down) * std::sin(angle),
            std::cos(down) - below;
        const int a = r == 1 ? 0 : c - around, b = r == 1 ? 0 : d - around;
        triangles.push_back({a, c, d});
        if (r > 1) triangles.push_back({a, d, b});
      }
    for (const auto& t : triangles)
      for (auto& corners = normals.emplace_back(); size_t k : {0, 1, 2})
        corners[k] = (Vec3(points.row(t[k])) + below * Vec3::UnitZ()).normalized();
    return PnTriangleMesh(TriangleMesh(points, triangles), normals);
  }
  bool mapped_;
  PnTriangleMesh mesh_;
};

/// The closer of two surfaces.
class NearerOf : public TargetSurface {
 public:
  NearerOf(const TargetSurface& a, const TargetSurface& b) : a_(a), b_(b) {}
  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto a = a_.nearest(p, along), b = b_.nearest(p, along);
    if (!a || !b) return a ? a : b;
    return (a->at - p).norm() <= (b->at - p).norm() ? a : b;
  }
  std::vector<Nearest> samples() const override { return a_.samples(); }

 private:
  const TargetSurface &a_, &b_;
};

bench::AnalyticShape shape_named(const std::string& name) {
  for (const bench::AnalyticShape& shape : bench::analytic_shapes())
    if (shape.name == name) return shape;
  throw InputError("no shape '" + name + "'");
}

std::shared_ptr<const ModelLayout> layout_of(const bench::AnalyticShape& shape, double edge) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = 1e-3 * std::pow(edge, 4);
  return std::make_shared<const ModelLayout>(RegionLayout(shape.name, shape.boundary(), options));
}

std::shared_ptr<const ModelLayout> unit_square() {
  SkinOptions options;
  options.edge_length = 0.1;
  return std::make_shared<const ModelLayout>(
      RegionLayout("square", polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), options));
}

double residual(const ModelFit& fit) {
  return fit.layout->line_constraints().max_residual(fit.dofs) / fit.layout->size();
}

}  // namespace

TEST_CASE("halving triangles makes a fit four times closer, and it passes through its curves",
          "[skinning][target]") {
  for (const std::string name : {"cylinder 90", "sphere octant", "torus quarter"}) {
    INFO(name);
    const bench::AnalyticShape shape = shape_named(name);
    const FormulaTarget target(shape.surface);
    ModelFitOptions options;
    options.tolerance = 1e-12;
    options.max_refinements = 0;
    double off[2];
    for (const int k : {0, 1}) {
      const auto layout = layout_of(shape, shape.coarse / (1 + k));
      const Points bent = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
      const ModelFit fit = fit_model(layout, bent, target, options);
      CHECK(residual(fit) < 1e-12);
      CHECK(fit.after.largest() < 0.05 * fit.before.largest());
      CHECK_FALSE(fit.reached);
      off[k] = fit.after.largest() / layout->size();
    }
    CAPTURE(off[0], off[1]);
    CHECK(off[1] < off[0] / 3.5);
    CHECK(off[1] < 2e-5);
  }
}

TEST_CASE("triangles are halved until the tolerance is reached", "[skinning][target]") {
  const bench::AnalyticShape shape = shape_named("torus quarter");
  const FormulaTarget target(shape.surface);
  const auto layout = layout_of(shape, shape.coarse);
  const Points bent = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  ModelFitOptions options;
  options.tolerance = 1e-5 * layout->size();
  const ModelFit fit = fit_model(layout, bent, target, options);
  CHECK(fit.reached);
  CHECK(fit.refinements > 0);
  CHECK(fit.after.largest() <= options.tolerance);
  CHECK(fit.after.back.points == 400);
  CHECK(residual(fit) < 1e-12);
}

TEST_CASE("a fit has the same bits on one thread or two", "[skinning][target]") {
  const bench::AnalyticShape shape = shape_named("sphere octant");
  const FormulaTarget target(shape.surface);
  const auto layout = layout_of(shape, shape.coarse);
  const Points bent = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  ModelFitOptions options;
  options.max_refinements = 1;
  options.tolerance = 1e-7;
  Points found[2];
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    found[threads - 1] = fit_model(layout, bent, target, options).dofs;
  }
  set_thread_count(0);
  CHECK(found[0] == found[1]);
}

TEST_CASE("where a target ends no force acts, and points there do not count",
          "[skinning][target]") {
  const auto layout = unit_square();
  const Points flat = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  ModelFitOptions options;
  options.max_refinements = 0;
  const ModelFit fit = fit_model(layout, flat, HalfPlane(), options);
  double near = 1, far = 0;
  for (int v = 0; v < layout->mesh()->vertex_count(); ++v) {
    const Vec3 x = fit.dofs.row(3 * v);
    if ((x - Vec3(0.25, 0.5, 0.05)).norm() < 0.12) near = std::min(near, x.z());
    if (x.x() > 0.8) far = std::max(far, std::abs(x.z()));
  }
  CHECK(near > 0.045);
  CHECK(far < 0.02);  // of the 0.05: bending decays there
  CHECK(fit.before.regions[0].excluded > fit.before.regions[0].points / 2);
}

TEST_CASE("a face whose curves lie on one part of the target is fitted to that part",
          "[skinning][target]") {
  // Two hills on one outline, up and down: a flat face is between them.
  const Hill up(0.2), down(-0.2);
  const auto both = std::make_shared<NearerOf>(up, down);
  const auto layout = unit_square();
  const Points flat = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  for (const auto& [part, height] : {std::pair(&up, 0.2), std::pair(&down, -0.2)}) {
    ModelFitOptions options;
    options.tolerance = 2e-3;
    // A part without any curve is not part of the face.
    options.parts = {std::make_shared<HalfPlane>(), std::make_shared<Hill>(*part)};
    const ModelFit fit = fit_model(layout, flat, *both, options);
    double extreme = 0;
    for (int v = 0; v < fit.layout->mesh()->vertex_count(); ++v) {
      const double z = fit.dofs(3 * v, 2);
      if (std::abs(z) > std::abs(extreme)) extreme = z;
    }
    CHECK(extreme == Approx(height).epsilon(0.05));
  }
}

TEST_CASE("a target deeper than it is wide is reached by its map", "[skinning][target]") {
  SkinOptions skin;
  skin.edge_length = 0.06;
  const auto layout = std::make_shared<const ModelLayout>(
      RegionLayout("disc", {{"rim", curve_from_hermite(circle({0, 0}, 0.5, 24))}}, skin));
  const Points flat = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  for (const bool mapped : {true, false}) {
    const auto balloon = std::make_shared<Balloon>(mapped);
    ModelFitOptions options;
    options.tolerance = 5e-3;
    options.parts = {balloon};
    const ModelFit fit = fit_model(layout, flat, *balloon, options);
    double top = 0;
    for (int v = 0; v < fit.layout->mesh()->vertex_count(); ++v)
      top = std::max(top, fit.dofs(3 * v, 2));
    CAPTURE(fit.after.there(), fit.after.back.largest, top);
    if (mapped) {
      CHECK(fit.reached);
      CHECK(top == Approx(1 + std::sqrt(0.75)).epsilon(0.05));  // a vertex near the top
    } else {
      CHECK(top < 0.5);
    }
  }
}

TEST_CASE("targets and tolerances that cannot be are refused", "[skinning][target]") {
  class NoSurface : public TargetSurface {
    std::optional<Nearest> nearest(const Vec3&, const Vec3&) const override { return {}; }
    std::vector<Nearest> samples() const override { return {}; }
  };
  const auto layout = unit_square();
  const Points flat = layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  CHECK_THROWS_WITH(fit_model(layout, flat, NoSurface()), Contains("no point of the target"));
  ModelFitOptions options;
  options.tolerance = std::nan("");
  CHECK_THROWS_WITH(fit_model(layout, flat, HalfPlane(), options), Contains("tolerance"));
}
