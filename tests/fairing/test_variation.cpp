// SPDX-License-Identifier: MPL-2.0
// Curvature variation: zero on cyclides, independent of the parametrisation, with derivatives
// checked by finite differences.
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/fairing/minimum_variation/block_reduction.h"
#include "batten/fairing/minimum_variation/curvature_variation_terms.h"
#include "batten/fairing/minimum_variation/gauss_newton_system.h"
#include "batten/fairing/minimum_variation/minimum_variation_surface.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

Jet3 random_jet(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  Jet3 jet;
  for (double& x : jet.reshaped()) x = normal(generator);
  return jet;
}

// Derivatives of x(u, v) by finite differences in long double.
template <class Place>
Jet3 jet_of(const Place& place, long double u, long double v) {
  const long double h = 2e-3L;
  using Row = std::array<long double, 3>;
  const auto at = [&](int i, int j) -> Row { return place(u + i * h, v + j * h); };
  // Fourth-order central differences on five points.
  const long double d0[5] = {0, 0, 1, 0, 0},
                    d1[5] = {1 / 12.0L, -2 / 3.0L, 0, 2 / 3.0L, -1 / 12.0L},
                    d2[5] = {-1 / 12.0L, 4 / 3.0L, -2.5L, 4 / 3.0L, -1 / 12.0L},
                    d3[5] = {-0.5L, 1, 0, -1, 0.5L};
  const long double* d[4] = {d0, d1, d2, d3};
  const int orders[9][2] = {{1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}, {3, 0}, {2, 1}, {1, 2}, {0, 3}};
  Jet3 jet = Jet3::Zero();
  for (int k = 0; k < 9; ++k)
    for (size_t c = 0; c < 3; ++c) {
      long double sum = 0;
      for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
          if (const long double w = d[orders[k][0]][i] * d[orders[k][1]][j]; w != 0)
            sum += w * at(i - 2, j - 2)[c];
      jet(static_cast<long>(c), k) =
          static_cast<double>(sum / std::pow(h, orders[k][0] + orders[k][1]));
    }
  return jet;
}

CurvatureTensors forms_of(const Jet3& jet) { return curvature_tensors(jet, principal_frame(jet)); }

// A cubic graph over the unit square, which C1 elements represent exactly.
Surface cubic_graph(int n, double tilt = 0.3) {
  auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(n));
  const DofMap map(*mesh);
  Points q = Points::Zero(map.count(), 3);
  const auto height = [&](const Vec2& p) { return p.x() * p.x() + tilt * p.y() * p.y() * p.x(); };
  const auto slope = [&](const Vec2& p) {
    return Vec2(2 * p.x() + tilt * p.y() * p.y(), 2 * tilt * p.y() * p.x());
  };
  for (int v = 0; v < mesh->vertex_count(); ++v) {
    const Vec2 p = mesh->vertices()[v];
    q.row(map.vertex(v)) << p.x(), p.y(), height(p);
    q.row(map.vertex(v, 1)) << 1, 0, slope(p).x();
    q.row(map.vertex(v, 2)) << 0, 1, slope(p).y();
  }
  for (int e = 0; e < mesh->edge_count(); ++e) {
    const auto& edge = mesh->edges()[e];
    const Vec2 n2 = mesh->edge_normal(e);
    const Vec2 p = (mesh->vertices()[edge.low] + mesh->vertices()[edge.high]) / 2;
    q.row(map.edge(e)) << n2.x(), n2.y(), n2.dot(slope(p));
  }
  return {mesh, TriangleElement::HCT, q};
}

template <class Rows>
double squares(const Rows& rows) {
  double sum = 0;
  for (int r = 0; r < rows.count; ++r) sum += rows.r[r] * rows.r[r];
  return sum;
}

Points gradient_of(const CurvatureVariationTerms& terms, const Surface& s) {
  Points g = Points::Zero(s.dof_map().count(), 3);
  const auto add = [&](const auto& dofs, const auto& rows) {
    for (size_t k = 0; k < 3 * dofs.size(); ++k)
      for (int r = 0; r < rows.count; ++r)
        g(dofs[k % dofs.size()], static_cast<long>(k / dofs.size())) +=
            2 * rows.r[r] * rows.J[k][r];
  };
  TriangleResiduals triangle;
  for (int t = 0; t < s.mesh().triangle_count(); ++t) {
    terms.triangle(s, t, {}, triangle);
    add(s.dof_map().triangle(s.mesh(), t), triangle);
  }
  EdgeResiduals edge;
  for (const int e : terms.edges()) {
    terms.edge(s, e, edge);
    add(CurvatureVariationTerms::edge_dofs(s, e), edge);
  }
  return g;
}

// The surface with random vertical displacements of its vertices.
Surface bumped(const Surface& s) {
  Points q = s.dofs();
  std::mt19937 generator(2);
  std::normal_distribution<double> normal(0, 0.01);
  for (int v = 0; v < s.mesh().vertex_count(); ++v)
    q(s.dof_map().vertex(v), 2) += normal(generator);
  return {s.shared_mesh(), s.kind(), q};
}

}  // namespace

TEST_CASE("the change of curvature has the derivatives that differences show",
          "[fairing][variation]") {
  std::mt19937 generator(3);
  for (int round = 0; round < 20; ++round) {
    const Jet3 jet = random_jet(generator);
    const Mat2 frame = principal_frame(jet);
    const CurvatureVariationWeights weights{0.04 * round, 0.7, 0.2};
    CurvatureVariationVector residuals;
    const CurvatureVariationJacobian exact =
        curvature_variation_jacobian(jet, frame, weights, residuals);
    CHECK(
        (residuals - curvature_variation_residuals(curvature_tensors(jet, frame), weights)).norm() <
        1e-10 * residuals.norm());
    CurvatureVariationJacobian differences;
    constexpr double h = 1e-6;
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 9; ++k) {
        Jet3 a = jet, b = jet;
        a(c, k) += h;
        b(c, k) -= h;
        differences.col(9 * c + k) =
            (curvature_variation_residuals(curvature_tensors(a, frame), weights) -
             curvature_variation_residuals(curvature_tensors(b, frame), weights)) /
            (2 * h);
      }
    CHECK((exact - differences).cwiseAbs().maxCoeff() < 1e-7 * exact.cwiseAbs().maxCoeff());
  }
}

TEST_CASE(
    "curvature is constant on spheres and cylinders, and on cones and tori along curvature lines",
    "[fairing][variation]") {
  using Row = std::array<long double, 3>;
  const auto sphere = [](long double u, long double v) {
    return Row{2 * std::cos(u) * std::cos(v), 2 * std::sin(u) * std::cos(v), 2 * std::sin(v)};
  };
  const auto cylinder = [](long double u, long double v) {
    return Row{3 * std::cos(u + v), 3 * std::sin(u + v), v - u * u};
  };
  const auto cone = [](long double u, long double v) {
    return Row{(1 + v) * std::cos(u), (1 + v) * std::sin(u), 2 * v};
  };
  const auto torus = [](long double u, long double v) {
    const long double r = 3 + std::cos(v);
    return Row{r * std::cos(u), r * std::sin(u), std::sin(v)};
  };
  for (const double u : {0.1, 0.7}) {
    const CurvatureTensors ball = forms_of(jet_of(sphere, u, 0.3));
    CHECK(ball.C.norm() < 1e-6);
    CHECK(std::abs(std::abs(ball.II[0]) - 0.5) < 1e-8);
    CHECK(std::abs(ball.II[0] - ball.II[2]) < 1e-8);
    const CurvatureTensors tube = forms_of(jet_of(cylinder, u, 0.3));
    CHECK(tube.C.norm() < 1e-6);
    CHECK(std::abs(tube.II[0] + tube.II[2]) == Approx(1.0 / 3).epsilon(1e-8));
    for (const CurvatureTensors& forms :
         {forms_of(jet_of(cone, u, 0.3)), forms_of(jet_of(torus, u, 0.3))}) {
      CHECK(std::abs(forms.C[0]) < 1e-6);
      CHECK(std::abs(forms.C[3]) < 1e-6);
      CHECK(forms.C.norm() > 0.01);
      CHECK(std::abs(forms.II[1]) < 1e-9);
      CHECK(curvature_variation_residuals(forms, {1, 0, 0}).norm() < 1e-5);
    }
  }
}

TEST_CASE("the forms depend on the shape, not on its parameters or its position",
          "[fairing][variation]") {
  std::mt19937 generator(5);
  const Jet3 jet = random_jet(generator);
  const CurvatureTensors forms = forms_of(jet);
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const CurvatureTensors turned = forms_of(rotation * jet);
  CHECK((turned.C - forms.C).norm() < 1e-10 * forms.C.norm());
  Jet3 stretched = jet;  // u twice as fast, v half
  const double factors[9] = {2, 0.5, 4, 1, 0.25, 8, 2, 0.5, 0.125};
  for (int k = 0; k < 9; ++k) stretched.col(k) *= factors[k];
  const CurvatureTensors same = forms_of(stretched);
  CHECK((same.C.cwiseAbs() - forms.C.cwiseAbs()).norm() < 1e-10 * forms.C.norm());
  CHECK((same.II - forms.II).norm() < 1e-10 * forms.II.norm());
}

TEST_CASE("the functional has the gradient that differences show, where curvature does not jump",
          "[fairing][variation]") {
  const Surface s = cubic_graph(2);
  CurvatureVariationTerms terms(s, 0.1, 2);
  terms.add_side(s, {0, 1, 2});
  terms.set_frames(s);
  const Points exact = gradient_of(terms, s);
  constexpr double h = 1e-6;
  double worst = 0;
  for (long i = 0; i < s.dofs().size(); ++i) {
    Points a = s.dofs(), b = s.dofs();
    a(i) += h;
    b(i) -= h;
    const double slope = (terms.value({s.shared_mesh(), s.kind(), a}) -
                          terms.value({s.shared_mesh(), s.kind(), b})) /
                         (2 * h);
    worst = std::max(worst, std::abs(slope - exact(i)));
  }
  CHECK(worst < 1e-7 * exact.norm());
}

TEST_CASE("the value is the sum of the elements' values, and curvature that jumps costs",
          "[fairing][variation]") {
  Surface s = cubic_graph(3);
  const CurvatureVariationTerms terms(s, 0.1, 2);
  const auto sums = [&](const Surface& surface) {
    double triangles = 0, edges = 0;
    TriangleResiduals triangle;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      terms.triangle(surface, t, {1, 1}, triangle);
      triangles += squares(triangle);
    }
    EdgeResiduals edge;
    for (const int e : terms.edges()) {
      terms.edge(surface, e, edge);
      edges += squares(edge);
    }
    return std::pair{triangles, edges};
  };
  const auto [smooth, none] = sums(s);
  CHECK(smooth == Approx(terms.value(s)).epsilon(1e-12));
  CHECK(none < 1e-18);
  Points bent = s.dofs();
  bent(s.dof_map().vertex(5, 1), 2) += 0.05;
  const Surface kinked(s.shared_mesh(), s.kind(), bent);
  CurvatureVariationTerms again(kinked, 0.1, 2);
  double jumps = 0;
  EdgeResiduals edge;
  for (const int e : again.edges()) {
    again.edge(kinked, e, edge);
    jumps += squares(edge);
  }
  CHECK(jumps > 1);
}

TEST_CASE(
    "jumps of curvature and tangent plane between two parts have the derivatives that differences "
    "show",
    "[fairing][variation]") {
  // z = x²: points of equal x have equal second fundamental forms, so that the jumps between them
  // are zero, and the dofs on the two sides of an edge differ.
  const Surface s = cubic_graph(3, 0);
  JoinPoint point;
  point.weight = 0.7;
  point.at = {s.locate({0.4, 0.2}), s.locate({0.4, 0.85})};
  point.direction = {Vec2(0.6, 1), Vec2(0.6, 1)};
  CurvatureVariationTerms terms(s, 0.1, 2);
  terms.add_joins(s, {point});
  REQUIRE(terms.join_count() == 1);
  JoinResiduals rows;
  terms.join(s, 0, rows);
  REQUIRE(rows.count == 2);
  const auto dofs = terms.join_dofs(s, 0);
  Points exact[2];
  for (int r = 0; r < 2; ++r) {
    CHECK(std::abs(rows.r[r]) < 1e-12);
    exact[r] = Points::Zero(s.dofs().rows(), 3);
    for (size_t k = 0; k < 3 * dofs.size(); ++k)
      exact[r](dofs[k % dofs.size()], static_cast<long>(k / dofs.size())) += rows.J[k][r];
  }
  // Variations that keep the curves fixed: the slope along them does not change.
  std::mt19937 generator(8);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    Points step = Points::NullaryExpr(s.dofs().rows(), 3, [&] { return normal(generator); });
    for (size_t side = 0; side < 2; ++side) {
      const Surface change(s.shared_mesh(), s.kind(), step);
      const SurfaceJet jet = change.jet(point.at[side]);
      const Vec3 along = jet.x_u * point.direction[side].x() + jet.x_v * point.direction[side].y();
      // The dof with the largest contribution to that slope compensates it.
      const auto own = s.dof_map().triangle(s.mesh(), point.at[side].triangle);
      double most = 0;
      int taker = 0;
      for (const int dof : own) {
        Points unit = Points::Zero(step.rows(), 3);
        unit(dof, 0) = 1;
        const SurfaceJet one = Surface(s.shared_mesh(), s.kind(), unit).jet(point.at[side]);
        const double share =
            one.x_u.x() * point.direction[side].x() + one.x_v.x() * point.direction[side].y();
        if (std::abs(share) <= std::abs(most)) continue;
        most = share;
        taker = dof;
      }
      step.row(taker) -= along / most;
    }
    constexpr double h = 1e-6;
    JoinResiduals moved[2];
    for (int direction = 0; direction < 2; ++direction)
      terms.join({s.shared_mesh(), s.kind(), Points(s.dofs() + (direction ? h : -h) * step)}, 0,
                 moved[direction]);
    for (int r = 0; r < 2; ++r) {
      const double slope = exact[r].cwiseProduct(step).sum();
      CHECK(std::abs((moved[1].r[r] - moved[0].r[r]) / (2 * h) - slope) <
            1e-6 * exact[r].norm() * step.norm());
    }
  }
}

TEST_CASE("multipliers find the minimum under rows, rows that follow from others among them",
          "[fairing][variation]") {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  constexpr int n = 20, count = 5;
  const MatX A = MatX::NullaryExpr(n, n, [&] { return normal(generator); });
  const MatX H = A.transpose() * A + MatX::Identity(n, n);
  MatX B = MatX::NullaryExpr(count, n, [&] { return normal(generator); });
  const MatX g = MatX::NullaryExpr(n, 2, [&] { return normal(generator); }),
             miss_of = MatX::NullaryExpr(count, 2, [&] { return normal(generator); });
  MatX miss = miss_of;
  B.row(4) = B.row(0) - 2 * B.row(1);
  miss.row(4) = miss.row(0) - 2 * miss.row(1);
  MatX kkt = MatX::Zero(n + 4, n + 4), right(n + 4, 2);
  kkt << H, B.topRows(4).transpose(), B.topRows(4), MatX::Zero(4, 4);
  right << -g, -miss.topRows(4);
  const MatX exact = solve_dense(kkt, right).topRows(n);

  const RowMatrix rows = B.sparseView();
  const VecX weights = penalty_weights(rows, H.diagonal(), 1e4);
  const MatX weighted = H + B.transpose() * weights.asDiagonal() * B;
  SparseCholesky factor;
  const SparseMatrix sparse = weighted.sparseView();
  factor.analyze(sparse);
  REQUIRE(factor.factorize(sparse));
  CHECK((solve_augmented_lagrangian(factor, g, rows, weights, miss) - exact).cwiseAbs().maxCoeff() <
        1e-9);
}

TEST_CASE("constraint equations of many dofs by Lagrange multipliers equal elimination",
          "[fairing][variation]") {
  const Surface s = cubic_graph(6), start = bumped(s);
  ConstraintSet rows(s.dof_map().count());
  SurfaceConstraints shape(s.mesh(), s.kind(), rows);
  for (int v = 0; v < s.mesh().vertex_count(); ++v)
    if (const Vec2 p = s.mesh().vertices()[v]; p.x() == 0 || p.x() == 1 || p.y() == 0 || p.y() == 1)
      rows.fix("rim", s.dof_map().vertex(v), start.dofs().row(s.dof_map().vertex(v)));
  for (double t = 0.08; t < 1; t += 0.12) {
    const Location at = start.locate({t, 0.31 + 0.4 * t});
    shape.point("line", at, start.position(at));
  }
  REQUIRE(AugmentedLagrangianConstraints::dense_rows(rows).constraints().size() == 8);
  // With a constraint that couples coordinates, all constraints are eliminated.
  ConstraintSet eliminated = rows;
  eliminated.add_coupled("again", {{s.dof_map().vertex(0), Vec3::UnitX()}},
                         start.dofs()(s.dof_map().vertex(0), 0));
  REQUIRE(AugmentedLagrangianConstraints::dense_rows(eliminated).constraints().empty());
  const MinimumVariationSurface held = minimize_curvature_variation(start, rows),
                                without = minimize_curvature_variation(start, eliminated);
  CHECK(held.max_residual < 1e-12);
  CHECK(held.functional == Approx(without.functional).epsilon(0.02));
  double apart = 0;  // along the normal: tangentially (u, v) may differ
  for (int v = 0; v < s.mesh().vertex_count(); ++v) {
    const int d = s.dof_map().vertex(v);
    const Vec3 u = held.dofs.row(d + 1), w = held.dofs.row(d + 2);
    const Vec3 direction = held.dofs.row(d) - without.dofs.row(d);
    apart = std::max(apart, std::abs(u.cross(w).normalized().dot(direction)));
  }
  CHECK(apart < 2e-3);
  CHECK(held.functional < 0.1 * held.start_functional);
}

TEST_CASE("triangles that stand still keep their dofs, and the others are faired beside them",
          "[fairing][variation]") {
  const Surface s = cubic_graph(6), start = bumped(s);
  MinimumVariationOptions options;
  std::vector<char> fixed(static_cast<size_t>(start.dofs().rows()), 0);
  for (int t = 0; t < s.mesh().triangle_count(); ++t) {
    options.frozen.push_back(s.mesh().shape(t).vertex[0].x() < 0.5);
    if (options.frozen.back())
      for (const int dof : s.dof_map().triangle(s.mesh(), t)) fixed[static_cast<size_t>(dof)] = 1;
  }
  const ConstraintSet none(s.dof_map().count());
  const MinimumVariationSurface faired = minimize_curvature_variation(start, none, options);
  double moved = 0, frozen = 0;
  for (long i = 0; i < start.dofs().rows(); ++i) {
    const double direction = (faired.dofs.row(i) - start.dofs().row(i)).norm();
    double& most = fixed[static_cast<size_t>(i)] ? frozen : moved;
    most = std::max(most, direction);
  }
  CHECK(frozen == 0);
  CHECK(moved > 1e-3);
  CHECK(faired.functional < 0.1 * faired.start_functional);
}

TEST_CASE("fairing keeps the rows exactly, and gives the same bits on one thread and two",
          "[fairing][variation]") {
  const Surface s = cubic_graph(6), start = bumped(s);
  ConstraintSet rows(s.dof_map().count());
  SurfaceConstraints shape(s.mesh(), s.kind(), rows);
  for (int v = 0; v < s.mesh().vertex_count(); ++v)
    if (const Vec2 p = s.mesh().vertices()[v]; p.x() == 0 || p.x() == 1 || p.y() == 0 || p.y() == 1)
      for (int d = 0; d < 3; ++d)
        rows.add("rim", {{s.dof_map().vertex(v, d), 1.0}},
                 Vec3(s.dofs().row(s.dof_map().vertex(v, d))));
  const MinimumVariationSurface faired = minimize_curvature_variation(start, rows);
  CHECK(faired.converged);
  CHECK(faired.functional < 0.1 * faired.start_functional);
  CHECK(faired.max_residual < 1e-12);
  CHECK(faired.factorizations <= 15);
  set_thread_count(1);
  const MinimumVariationSurface alone = minimize_curvature_variation(start, rows);
  set_thread_count(0);
  CHECK(alone.dofs == faired.dofs);
}

TEST_CASE("surfaces that cannot be faired are reported", "[fairing][variation]") {
  const Surface s = cubic_graph(2);
  const ConstraintSet rows(s.dof_map().count());
  CHECK_THAT(error_message([&] { minimize_curvature_variation(s, ConstraintSet(3)); }),
             Contains("constraints on 3 dofs"));
  const Surface z12(s.shared_mesh(), TriangleElement::Z12, s.dofs());
  CHECK_THAT(error_message([&] { minimize_curvature_variation(z12, rows); }),
             Contains("expected element = \"hct\""));
  Points broken = s.dofs();
  broken(0, 0) = std::nan("");
  CHECK_THAT(error_message([&] {
               minimize_curvature_variation({s.shared_mesh(), s.kind(), broken}, rows);
             }),
             Contains("not finite"));
  const Surface nothing(s.shared_mesh(), s.kind(), Points::Zero(s.dofs().rows(), 3));
  CHECK_THAT(error_message([&] { minimize_curvature_variation(nothing, rows); }),
             Contains("area zero"));
}

TEST_CASE("steps along the normals keep the rows and go along the normals",
          "[fairing][variation]") {
  const Surface s = cubic_graph(4);
  ConstraintSet rows(s.dof_map().count());
  for (int v = 0; v < s.mesh().vertex_count(); ++v)
    if (s.mesh().vertices()[v].x() == 0)
      for (int d = 0; d < 3; d += 2)
        rows.add("rim", {{s.dof_map().vertex(v, d), 1.0}},
                 Vec3(s.dofs().row(s.dof_map().vertex(v, d))));
  rows.add("tie", {{s.dof_map().vertex(12, 1), 1.0}, {s.dof_map().vertex(13, 1), -1.0}},
           Vec3(s.dofs().row(s.dof_map().vertex(12, 1)) - s.dofs().row(s.dof_map().vertex(13, 1))));
  const BlockReduction reduction(rows);
  const NormalVariation steps(reduction, s);
  CHECK(3 * steps.count() == reduction.free_count());
  std::mt19937 generator(4);
  std::normal_distribution<double> normal;
  VecX amounts(steps.count());
  for (double& x : amounts) x = normal(generator);
  const VecX change = steps.at(s) * amounts;
  const Points moved = s.dofs() + change.reshaped(s.dof_map().count(), 3);
  CHECK(rows.max_residual(moved) < 1e-12 * amounts.norm());
  for (int v = 0; v < s.mesh().vertex_count(); ++v) {
    const int d = s.dof_map().vertex(v);
    const Vec3 direction = moved.row(d) - s.dofs().row(d);
    const Vec3 u = s.dofs().row(d + 1), w = s.dofs().row(d + 2);
    CHECK(direction.cross(u.cross(w)).norm() < 1e-12 * (1 + direction.norm()));
  }
}

TEST_CASE("the same amount everywhere makes the parallel surface of a sphere",
          "[fairing][variation]") {
  // Dofs of a part of the unit sphere, over (u, v) in [0, 0.5]².
  auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(6));
  const DofMap map(*mesh);
  const auto at = [](const Vec2& p) -> Vec3 {
    return {std::cos(p.x()) * std::cos(p.y()), std::sin(p.x()) * std::cos(p.y()), std::sin(p.y())};
  };
  const auto slopes = [](const Vec2& p) {
    Eigen::Matrix<double, 3, 2> X;
    X << -std::sin(p.x()) * std::cos(p.y()), -std::cos(p.x()) * std::sin(p.y()),
        std::cos(p.x()) * std::cos(p.y()), -std::sin(p.x()) * std::sin(p.y()), 0, std::cos(p.y());
    return X;
  };
  Points q(map.count(), 3);
  for (int v = 0; v < mesh->vertex_count(); ++v) {
    q.row(map.vertex(v)) = at(mesh->vertices()[v]);
    q.row(map.vertex(v, 1)) = slopes(mesh->vertices()[v]).col(0);
    q.row(map.vertex(v, 2)) = slopes(mesh->vertices()[v]).col(1);
  }
  for (int e = 0; e < mesh->edge_count(); ++e) {
    const auto& edge = mesh->edges()[e];
    const Vec2 p = (mesh->vertices()[edge.low] + mesh->vertices()[edge.high]) / 2;
    q.row(map.edge(e)) = slopes(p) * mesh->edge_normal(e);
  }
  const Surface s(mesh, TriangleElement::HCT, q);
  const BlockReduction free{ConstraintSet(map.count())};
  const NormalVariation steps(free, s);
  VecX amounts = VecX::Zero(steps.count());  // φ = 0.1: its slopes are zero
  for (int v = 0; v < mesh->vertex_count(); ++v) amounts[map.vertex(v)] = 0.1;
  const VecX change = steps.at(s) * amounts;
  CHECK((q + change.reshaped(map.count(), 3) - 1.1 * q).cwiseAbs().maxCoeff() < 2e-3);
}
