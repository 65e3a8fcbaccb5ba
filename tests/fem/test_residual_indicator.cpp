// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/refinement.h"
#include "batten/fem/surface_assembler.h"

#include "batten/constraints/constrained_solver.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

SurfaceJet wave(const Vec2& p) {
  const double s = std::sin(3 * p.x()), c = std::cos(3 * p.x()), e = std::exp(p.y());
  return {{0, 0, s * e},      {0, 0, 3 * c * e}, {0, 0, s * e},
          {0, 0, -9 * s * e}, {0, 0, 3 * c * e}, {0, 0, s * e}};
}

SurfaceJet cubic(const Vec2& p) {
  const double u = p.x(), v = p.y();
  return {{u, v * v * v, u * u * v - u * v * v},
          {1, 0, 2 * u * v - v * v},
          {0, 3 * v * v, u * u - 2 * u * v},
          {},
          {},
          {}};
}

// ∬ |second derivatives of surface - wave|², unit beta.
double energy_error(const Surface& surface) {
  const TriangleRule rule = split_triangle_rule(6);
  double sum = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    const TriangleShape shape = surface.mesh().shape(t);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p);
      const SurfaceJet a = surface.jet({t, L}), b = wave(shape.point(L));
      sum += shape.area * rule.weights[p] *
             ((a.x_uu - b.x_uu).squaredNorm() + 2 * (a.x_uv - b.x_uv).squaredNorm() +
              (a.x_vv - b.x_vv).squaredNorm());
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("a cubic has no jumps of curvature", "[fem][error_indicator]") {
  for (const auto kind : kBothElements) {
    const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(6, 3));
    CHECK(residual_indicator(interpolated(mesh, kind, cubic)).maxCoeff() < 1e-20);
  }
}

TEST_CASE("jumps fall as the energy's error, and are as large as it", "[fem][error_indicator]") {
  for (const auto kind : kBothElements) {
    double before = 0, error_before = 0;
    for (const int n : {8, 16, 32}) {
      const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(n, 5));
      const Surface surface = interpolated(mesh, kind, wave);
      const double eta = residual_indicator(surface).sum(), error = energy_error(surface);
      if (before > 0) {
        const double rate = std::log2(before / eta);
        CHECK(rate == Approx(4).margin(0.4));
        CHECK(rate == Approx(std::log2(error_before / error)).margin(0.25));
      }
      CHECK(eta > error);
      CHECK(eta < 30 * error);
      before = eta;
      error_before = error;
    }
  }
}

TEST_CASE("the jumps are those of the second normal derivative", "[fem][error_indicator]") {
  // One coordinate, one inner edge: compared with the definition by jets from both sides.
  Random random(8);
  const auto mesh =
      std::make_shared<ParametricMesh>(std::vector<Vec2>{{0, 0}, {1, 0.1}, {0.2, 0.9}, {1.1, 1}},
                                       std::vector<ParametricMesh::Triangle>{{0, 1, 2}, {1, 3, 2}});
  Points q(DofMap(*mesh).count(), 3);
  for (long i = 0; i < q.rows(); ++i) q.row(i) = random.point();
  const Surface surface(mesh, TriangleElement::HCT, q);
  const auto nn = [&](int t, const Vec3& L, const Vec2& n) -> Vec3 {
    const SurfaceJet j = surface.jet({t, L});
    return n.x() * n.x() * j.x_uu + 2 * n.x() * n.y() * j.x_uv + n.y() * n.y() * j.x_vv;
  };
  // h ∫ |jump|² between two points of the plane, evaluated at a tiny distance on both sides.
  const SegmentRule gauss = gauss_legendre(4);
  const auto across = [&](int left, int right, const Vec2& a, const Vec2& b) {
    const Vec2 d = b - a, n = Vec2(-d.y(), d.x()).normalized();
    double sum = 0;
    for (long g = 0; g < gauss.s.size(); ++g) {
      const Vec2 p = a + gauss.s[g] * d;
      constexpr double hair = 1e-9;
      const Vec3 jump = nn(left, mesh->shape(left).barycentric(p + hair * n), n) -
                        nn(right, mesh->shape(right).barycentric(p - hair * n), n);
      sum += gauss.weights[g] * d.squaredNorm() * jump.squaredNorm();
    }
    return sum;
  };
  const VecX eta = residual_indicator(surface);
  for (const int t : {0, 1}) {
    double expected = 0.5 * across(0, 1, mesh->vertices()[2], mesh->vertices()[1]);
    const TriangleShape shape = mesh->shape(t);
    for (int i = 0; i < 3; ++i)
      expected += across(t, t, shape.vertex[i], shape.point(Vec3::Constant(1.0 / 3)));
    CHECK(eta[t] == Approx(expected).epsilon(1e-6));
  }
}

TEST_CASE("under a point load, the jumps crowd around it", "[fem][error_indicator]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(16);
  for (const auto kind : kBothElements) {
    const SurfaceAssembler assembler(mesh, kind);
    const Vec2 at(0.4, 0.55);
    const auto shared = std::make_shared<ParametricMesh>(mesh);
    const Location where =
        Surface(shared, kind, Points::Zero(assembler.dofs().count(), 3)).locate(at);
    const ConstrainedSolver solver(clamped_boundary(mesh), assembler.stiffness(SurfaceStiffness{}));
    const VecX eta = residual_indicator(
        Surface(shared, kind, solver.solve(assembler.point_load(where, Vec3(0, 0, 1)))));
    int most = 0;
    eta.maxCoeff(&most);
    CHECK((mesh.shape(most).point(Vec3::Constant(1.0 / 3)) - at).norm() < 0.1);
    double near = 0;
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if ((mesh.shape(t).point(Vec3::Constant(1.0 / 3)) - at).norm() < 0.15) near += eta[t];
    CHECK(near > 0.5 * eta.sum());
  }
}

TEST_CASE("triangles outside of a trim have no jumps", "[fem][error_indicator]") {
  Random random(4);
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(10, 3));
  const auto trim = std::make_shared<Trim>(*mesh, DomainLoops({{circle({0.5, 0.5}, 0.3, 12)}}));
  for (const auto kind : kBothElements) {
    const Surface plain = interpolated(mesh, kind, cubic);
    Points q = plain.dofs();
    std::vector<char> inside(static_cast<size_t>(q.rows()), 0);
    for (int t = 0; t < mesh->triangle_count(); ++t)
      for (const int d : plain.dof_map().triangle(*mesh, t))
        if (trim->side(t) != Trim::Side::Outside) inside[static_cast<size_t>(d)] = 1;
    for (long d = 0; d < q.rows(); ++d)
      if (!inside[static_cast<size_t>(d)]) q.row(d) = random.point();
    CHECK(residual_indicator(Surface(mesh, kind, q)).maxCoeff() > 1);
    CHECK(residual_indicator(Surface(mesh, kind, q, trim)).maxCoeff() < 1e-20);
    // A wave: inside as without the trim; in cut triangles, a part of it.
    const Surface waved = interpolated(mesh, kind, wave);
    const VecX all = residual_indicator(waved),
               part = residual_indicator(Surface(mesh, kind, waved.dofs(), trim));
    for (int t = 0; t < mesh->triangle_count(); ++t) {
      if (trim->side(t) == Trim::Side::Outside) CHECK(part[t] == 0);
      CHECK(part[t] <= all[t] * (1 + 1e-12));
    }
  }
}

TEST_CASE("a trim along element edges has no jumps across it", "[fem][error_indicator]") {
  const auto mesh = std::make_shared<ParametricMesh>(ParametricMesh::unit_square(8));
  DomainLoops::Loop box;
  const Vec2 corner[4] = {{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}};
  for (int i = 0; i < 4; ++i) {
    const Vec2 a = corner[i], d = corner[(i + 1) % 4] - a;
    box.push_back(hermite(0, 1, 1, false, [=](double t, int order) {
      const Vec2 p = order == 0 ? Vec2(a + t * d) : d;
      return Vec3(p.x(), p.y(), 0);
    }));
  }
  const auto trim = std::make_shared<Trim>(*mesh, DomainLoops({box}));
  REQUIRE(trim->cut_triangles().empty());
  Points q = interpolated(mesh, TriangleElement::HCT, cubic).dofs();
  for (int v = 0; v < mesh->vertex_count(); ++v) {
    const Vec2 p = mesh->vertices()[v];
    if ((p - Vec2(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.26)
      q.row(3 * v) += Vec3(1, 2, 3).transpose();
  }
  CHECK(residual_indicator(Surface(mesh, TriangleElement::HCT, q)).maxCoeff() > 1);
  CHECK(residual_indicator(Surface(mesh, TriangleElement::HCT, q, trim)).maxCoeff() < 1e-20);
}
