// SPDX-License-Identifier: MPL-2.0
// Curve meshes: dofs of open and closed curves, corners, and properties of the deformable curve.
#include <cmath>
#include <set>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/band_cholesky.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/curve_assembler.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

std::vector<CurveMesh> sample_meshes() {
  return {CurveMesh({0, 1}),
          CurveMesh({-1, 0.2, 0.5, 2}),
          CurveMesh({-1, 0.2, 0.5, 2}, false, {2}),
          CurveMesh({0, 1, 1.5, 3, 3.2}, true),
          CurveMesh({0, 1, 1.5, 3, 3.2}, true, {0, 2}),
          CurveMesh({0, 1, 2}, true)};
}

HermiteCurve random_curve(const CurveMesh& mesh, unsigned seed) {
  Random random(seed);
  Points dofs(mesh.dof_count(), 3);
  for (long d = 0; d < dofs.rows(); ++d) dofs.row(d) = random.point();
  return {mesh, dofs};
}

MatX whole(const SparseMatrix& lower) {
  return MatX(SparseMatrix(lower.selfadjointView<Eigen::Lower>()));
}

}  // namespace

TEST_CASE("dofs are numbered along the curve, each once, and shared except at corners",
          "[fem][curve_mesh]") {
  for (const CurveMesh& mesh : sample_meshes()) {
    std::set<int> seen;
    for (int s = 0; s < mesh.segment_count(); ++s)
      for (const int d : mesh.segment_dofs(s)) seen.insert(d);
    CHECK(static_cast<int>(seen.size()) == mesh.dof_count());
    CHECK(*seen.rbegin() == mesh.dof_count() - 1);
    const HermiteCurve curve = random_curve(mesh, 3);
    for (int n = mesh.closed() ? 0 : 1; n < mesh.node_count() - (mesh.closed() ? 0 : 1); ++n) {
      const int before = (n + mesh.segment_count() - 1) % mesh.segment_count();
      CHECK((curve.evaluate({before, 1}) - curve.evaluate({n, 0})).norm() < 1e-14);
      const double kink = (curve.evaluate({before, 1}, 1) - curve.evaluate({n, 0}, 1)).norm();
      if (mesh.is_corner(n))
        CHECK(kink > 0.01);
      else
        CHECK(kink < 1e-13);
    }
  }
  const CurveMesh ring({0, 1, 1.5, 3, 3.2}, true);
  CHECK(ring.locate(3.2 + 1.2).segment == 1);
  CHECK(ring.locate(-0.1).segment == 3);
  CHECK(ring.wrapped(-0.2) == Approx(3.0));
  CHECK(CurveMesh({0, 1, 2}).locate(7).segment == 1);
}

TEST_CASE("curve meshes that are none are refused", "[fem][curve_mesh]") {
  CHECK_THAT(error_message([] { CurveMesh({1.0}); }), Contains("two nodes"));
  CHECK_THAT(error_message([] { CurveMesh({0, 1}, true); }), Contains("two segments"));
  CHECK_THAT(error_message([] { CurveMesh({0, 1, 1}); }), Contains("u[1] = 1, u[2] = 1"));
  CHECK_THAT(error_message([] { CurveMesh({0, NAN, 1}); }), Contains("increase"));
  CHECK_THAT(error_message([] { CurveMesh({0, 1, INFINITY}); }), Contains("finite"));
  CHECK_THAT(error_message([] {
               CurveMesh({0, 1, 2}, false, {0});
             }),
             Contains("corner at node 0") && Contains("from 1 to 1"));
  CHECK_THAT(error_message([] {
               CurveMesh({0, 1, 2}, true, {2});
             }),
             Contains("corner at node 2") && Contains("from 0 to 1"));
  CHECK_THAT(error_message([] {
               HermiteCurve(CurveMesh({0, 1}), Points::Zero(3, 3));
             }),
             Contains("3 dofs"));
}

TEST_CASE("energies of any mesh equal quadrature of the curve, with weights linear in a segment",
          "[fem][curve_mesh]") {
  Random random(9);
  for (const CurveMesh& mesh : sample_meshes()) {
    const HermiteCurve curve = random_curve(mesh, 7);
    CurveAssembler::Coefficient alpha, beta;
    std::vector<double> weight;
    for (int s = 0; s < mesh.segment_count(); ++s) {
      alpha.emplace_back(random.between(0, 2), random.between(0, 2));
      beta.emplace_back(random.between(0, 2), random.between(0, 2));
      weight.push_back(random.between(0, 2));
    }
    const CurveAssembler assembler(mesh);
    const SegmentRule rule = gauss_legendre(5);
    double stretching = 0, bending = 0, mass = 0;
    for (int s = 0; s < mesh.segment_count(); ++s)
      for (long p = 0; p < rule.s.size(); ++p) {
        const double x = rule.s[p], du = mesh.length(s) * rule.weights[p];
        const auto linear = [&](const HermiteSegment::Linear& f) {
          return f.start + (f.end - f.start) * x;
        };
        stretching += du * linear(alpha[s]) * curve.evaluate({s, x}, 1).squaredNorm();
        bending += du * linear(beta[s]) * curve.evaluate({s, x}, 2).squaredNorm();
        mass += du * weight[s] * curve.evaluate({s, x}).squaredNorm();
      }
    const auto energy = [&](const SparseMatrix& K) {
      return curve.dofs().cwiseProduct(whole(K) * curve.dofs()).sum();
    };
    CHECK(energy(assembler.stiffness(alpha, {0})) == Approx(stretching).epsilon(1e-13));
    CHECK(energy(assembler.stiffness({0}, beta)) == Approx(bending).epsilon(1e-13));
    CHECK(energy(assembler.mass(weight)) == Approx(mass).epsilon(1e-13));
    // A constant load: the integrals of the shape functions, by sums of the virtual work.
    Points f(mesh.segment_count() + 1, 3);
    for (long i = 0; i < f.rows(); ++i) f.row(i) = random.point();
    double work = 0;
    for (int s = 0; s < mesh.segment_count(); ++s)
      for (long p = 0; p < rule.s.size(); ++p)
        work += mesh.length(s) * rule.weights[p] *
                curve.evaluate({s, rule.s[p]})
                    .dot(((1 - rule.s[p]) * f.row(s) + rule.s[p] * f.row(s + 1)).transpose());
    CHECK(assembler.load(f).cwiseProduct(curve.dofs()).sum() == Approx(work).epsilon(1e-13));
    const double u = mesh.start() + 0.37 * (mesh.end() - mesh.start());
    CHECK(assembler.point_load(u, {1, 2, 3}).cwiseProduct(curve.dofs()).sum() ==
          Approx(curve.evaluate(u).dot(Vec3(1, 2, 3))).epsilon(1e-13));
  }
}

TEST_CASE("two clamped segments under a uniform load sag by 1/384 in the middle",
          "[fem][curve_mesh]") {
  const CurveMesh mesh({0, 0.5, 1});
  ConstraintSet clamped(mesh.dof_count());
  CurveConstraints rows(mesh, clamped);
  for (const double end : {0.0, 1.0}) {
    rows.point("end", end, Vec3::Zero());
    rows.derivative("slope", end, Vec3::Zero());
  }
  const CurveAssembler assembler(mesh);
  const Points q = solve_constrained(clamped, assembler.stiffness({0}, {1}),
                                     assembler.load(Vec3(0, 0, 1).transpose().replicate(3, 1)));
  CHECK(std::abs(q(mesh.position_dof(1), 2) - 1.0 / 384) < 1e-15);
  CHECK(std::abs(q(mesh.slope_out(1), 2)) < 1e-15);
}

TEST_CASE(
    "refinement orders: value 4, slope 3, curvature 2, with varying weights and a closed curve",
    "[fem][curve_mesh]") {
  // -(alpha w')' + (beta w'')'' = f for w = sin, periodic; beta = 1 + 0.3 t/(2 pi) open, clamped.
  const double whole = 2 * M_PI;
  const auto solve = [&](int n, bool closed, double* errors) {
    std::vector<double> u;
    for (int i = 0; i <= n; ++i)
      u.push_back(whole * (i + (i % n ? 0.3 * std::sin(2.0 * i) : 0)) / n);
    const CurveMesh mesh(u, closed);
    const auto beta = [&](double t) { return closed ? 1.0 : 1 + 0.3 * t; };
    const auto force = [&](double t) {  // beta'' = 0
      return beta(t) * std::sin(t) - 2 * (closed ? 0 : 0.3) * std::cos(t) + std::sin(t);
    };
    CurveAssembler::Coefficient along;
    for (int s = 0; s < n; ++s) along.emplace_back(beta(u[s]), beta(u[s + 1]));
    const CurveAssembler assembler(mesh);
    Points F = Points::Zero(mesh.dof_count(), 3);
    const SegmentRule rule = gauss_legendre(6);
    for (int s = 0; s < n; ++s)
      for (long p = 0; p < rule.s.size(); ++p) {
        const double t = u[s] + mesh.length(s) * rule.s[p];
        F += assembler.point_load(t, Vec3(0, mesh.length(s) * rule.weights[p] * force(t), 0));
      }
    ConstraintSet set(mesh.dof_count());
    CurveConstraints rows(mesh, set);
    rows.point("start", 0, Vec3::Zero());
    if (!closed) {
      rows.point("end", whole, Vec3::Zero());
      rows.derivative("slope", 0, Vec3::UnitY());
      rows.derivative("slope", whole, Vec3::UnitY());
    }
    const HermiteCurve curve(mesh, solve_constrained(set, assembler.stiffness({1}, along), F));
    for (int k = 0; k < 3; ++k) errors[k] = 0;
    for (int i = 0; i < 40 * n; ++i) {
      const double t = whole * (i + 0.5) / (40 * n);
      for (int k = 0; k < 3; ++k)
        errors[k] += std::pow(curve.evaluate(t, k).y() - std::sin(t + k * M_PI / 2), 2) / (40 * n);
    }
  };
  for (const bool closed : {false, true}) {
    double coarse[3], fine[3];
    solve(24, closed, coarse);
    solve(96, closed, fine);
    for (int k = 0; k < 3; ++k) {
      INFO((closed ? "closed" : "open") << ", derivative " << k);
      CHECK(0.25 * std::log2(coarse[k] / fine[k]) == Approx(4 - k).margin(0.3));
    }
  }
}

TEST_CASE("further nodes change no point of a curve, and no bit elsewhere", "[fem][curve_mesh]") {
  for (const CurveMesh& mesh : sample_meshes()) {
    const HermiteCurve curve = random_curve(mesh, 21);
    const double a = mesh.start(), h = mesh.end() - a, first = mesh.parameters()[1];
    const HermiteCurve finer =
        curve.with_nodes({a + 0.1 * (first - a), a + 0.7 * (first - a), first, a - 1, a + 2 * h});
    CHECK(finer.segment_count() == curve.segment_count() + 2);
    CHECK(finer.mesh().corners().size() == mesh.corners().size());
    for (int k = 0; k <= 100; ++k)
      for (int order = 0; order < 4; ++order) {
        const double u = a + h * k / 100;
        const double size = std::pow(10, order) * 10;
        CHECK((curve.evaluate(u, order) - finer.evaluate(u, order)).norm() < 1e-12 * size * size);
        if (u > first) CHECK((curve.evaluate(u, order) - finer.evaluate(u, order)).norm() == 0);
      }
  }
}

TEST_CASE("the nearest point is never missed, on any curve", "[fem][curve_mesh]") {
  Random random(77);
  for (int trial = 0; trial < 60; ++trial) {
    const auto meshes = sample_meshes();
    const CurveMesh& mesh = meshes[trial % meshes.size()];
    Points dofs(mesh.dof_count(), 3);
    for (long d = 0; d < dofs.rows(); ++d)
      dofs.row(d) = std::pow(10, random.between(-1, 1)) * random.point();
    const HermiteCurve curve(mesh, dofs);
    const Vec3 p = 2 * random.point();
    double sampled = 1e300;
    for (int k = 0; k <= 20000; ++k)
      sampled = std::min(
          sampled,
          (curve.evaluate(mesh.start() + (mesh.end() - mesh.start()) * k / 20000) - p).norm());
    const CurvePoint nearest = curve.closest_point(p);
    CHECK(nearest.distance <= sampled);
    CHECK(nearest.distance > sampled - 1e-3);
    CHECK((curve.evaluate(nearest.u) - p).norm() == Approx(nearest.distance).epsilon(1e-12));
  }
}

TEST_CASE("a band matrix is added, solved, fixed and inverted like a dense one",
          "[fem][curve_mesh]") {
  Random random(31);
  for (const auto& [n, band] : {std::pair(1, 3), {2, 1}, {7, 3}, {40, 3}, {41, 7}, {12, 11}}) {
    MatX A = MatX::Zero(n, n);
    BandCholesky cholesky;
    cholesky.reset(n, band);
    for (int i = 0; i < n; ++i)
      for (int j = std::max(0, i - band); j <= i; ++j) {
        const double value = i == j ? 3 * band + random() : random();
        cholesky.add(j, i, value);  // both triangles
        A(i, j) = A(j, i) = value;
      }
    MatX B = MatX::Zero(n, n);
    BandCholesky other;
    other.reset(n, band);
    for (int i = 0; i < n; ++i)
      for (int j = std::max(0, i - band); j <= i; ++j) {
        B(i, j) = B(j, i) = random();
        other.add(i, j, B(i, j));
      }
    cholesky.add(other, 0.5);
    A += 0.5 * B;
    CHECK(cholesky.diagonal(n - 1) == Approx(A(n - 1, n - 1)));
    Points b(n, 3);
    for (int i = 0; i < n; ++i) b.row(i) = random.point();
    Points x = b;
    REQUIRE(cholesky.factorize());
    cholesky.solve(x);
    CHECK((A * x - b).norm() < 1e-13 * b.norm() * n);
    CHECK(std::abs(cholesky.trace_of_inverse_times(other) - (A.inverse() * B).trace()) < 1e-13 * n);
    if (n < 3) continue;
    BandCholesky fixed;
    fixed.reset(n, band);
    for (int i = 0; i < n; ++i)
      for (int j = std::max(0, i - band); j <= i; ++j) fixed.add(i, j, A(i, j));
    Points right = b;
    fixed.fix(1, {1, 2, 3}, right);
    REQUIRE(fixed.factorize());
    fixed.solve(right);
    CHECK((right.row(1) - Eigen::RowVector3d(1, 2, 3)).norm() == 0);
    const Points rest = A * right - b;
    for (int i = 0; i < n; ++i)
      if (i != 1) CHECK(rest.row(i).norm() < 1e-11);
  }
  BandCholesky bad;
  bad.reset(2, 1);
  bad.add(0, 0, 1);
  bad.add(1, 0, 2);
  bad.add(1, 1, 1);
  CHECK_FALSE(bad.factorize());
}
