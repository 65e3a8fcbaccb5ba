// SPDX-License-Identifier: MPL-2.0
#include "batten/core/eigen.h"
#include "batten/elements/hermite_segment.h"

#include <Eigen/LU>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten;

namespace {

using Linear = HermiteSegment::Linear;
using Matrix = HermiteSegment::Matrix;
using Vector = HermiteSegment::Vector;

Matrix matrix_of(const nlohmann::json& rows) {
  Matrix m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) m(i, j) = rows[i][j];
  return m;
}

// Dofs of u^e on a segment from u0 to u0 + h.
Vector power_dofs(double u0, double h, int e) {
  const auto slope = [&](double u) { return e == 0 ? 0 : e * std::pow(u, e - 1); };
  return {std::pow(u0, e), slope(u0), std::pow(u0 + h, e), slope(u0 + h)};
}

}  // namespace

TEST_CASE("segment matrices are the reference matrices for every length",
          "[elements][hermite_segment]") {
  const auto gold = batten_test::reference("curve.json");
  const std::pair<double, const char*> cases[] = {{1, "h=1"}, {0.5, "h=0.5"}, {2, "h=2"}};
  for (const auto& [h, key] : cases) {
    INFO(key);
    const auto& expected = gold[key];
    const HermiteSegment segment(h);
    CHECK(segment.length() == h);
    const auto check = [&](const Matrix& found, const char* name) {
      INFO(name);
      CHECK(batten_test::relative_error(found, matrix_of(expected[name])) < 1e-12);
    };
    check(segment.stretching(), "K_alpha1");
    check(segment.bending(), "K_beta1");
    check(segment.mass(), "mass");
    check(segment.stretching({1, 0}), "K_alpha_linear_f0weight(1-u/h)");
    check(segment.stretching({0, 1}), "K_alpha_linear_weight(u/h)");
    check(segment.bending({1, 0}), "K_beta_weight(1-u/h)");
    check(segment.bending({0, 1}), "K_beta_weight(u/h)");
    for (int end = 0; end < 2; ++end) {
      Vector load;
      for (int i = 0; i < 4; ++i) load[i] = expected["F_matrix_f0_f1"][i][end];
      CHECK(batten_test::relative_error(segment.load({1.0 - end, 1.0 * end}), load) < 1e-12);
    }
  }
}

TEST_CASE("segment functions have the Kronecker property and hold all cubics",
          "[elements][hermite_segment]") {
  for (const double h : {1e-8, 0.3, 1.0, 7.0, 1e8}) {
    const HermiteSegment segment(h);
    Matrix dofs;
    dofs << segment.evaluate(0), segment.evaluate(0, 1), segment.evaluate(1),
        segment.evaluate(1, 1);
    CHECK((dofs - Matrix::Identity()).cwiseAbs().maxCoeff() < 1e-15 * std::max(1.0, h));
  }
  const double u0 = -0.4, h = 1.7;
  const HermiteSegment segment(h);
  for (int e = 0; e <= 3; ++e)
    for (const double s : {0.0, 0.21, 0.5, 0.83, 1.0}) {
      const double u = u0 + s * h;
      double expected = std::pow(u, e), factor = 1;
      for (int order = 0; order <= 3; ++order) {
        if (order > 0) {
          factor *= e - order + 1;
          expected = order > e ? 0 : factor * std::pow(u, e - order);
        }
        CHECK(std::abs(power_dofs(u0, h, e).dot(segment.evaluate(s, order)) - expected) < 1e-13);
      }
    }
}

TEST_CASE("segment derivatives are those of the functions one order below",
          "[elements][hermite_segment]") {
  constexpr double step = 1e-5;
  for (const double h : {0.25, 1.0, 3.0})
    for (int order = 1; order <= 3; ++order)
      for (const double s : {0.1, 0.5, 0.77}) {
        const HermiteSegment segment(h);
        const Vector difference =
            (segment.evaluate(s + step, order - 1) - segment.evaluate(s - step, order - 1)) /
            (2 * step * h);
        const Vector derivative = segment.evaluate(s, order);
        CHECK((difference - derivative).cwiseAbs().maxCoeff() <
              1e-8 * derivative.cwiseAbs().maxCoeff());
      }
}

TEST_CASE("segment matrices are the integrals they stand for", "[elements][hermite_segment]") {
  const double h = 0.8;
  const HermiteSegment segment(h);
  const Linear weight(0.7, 2.9);
  const SegmentRule rule = gauss_legendre(5);
  Matrix stretching = Matrix::Zero(), bending = Matrix::Zero(), mass = Matrix::Zero();
  Vector load = Vector::Zero();
  for (int p = 0; p < 5; ++p) {
    const double s = rule.s[p], w = h * rule.weights[p];
    const double c = (1 - s) * weight.start + s * weight.end;
    const Vector H = segment.evaluate(s), H1 = segment.evaluate(s, 1), H2 = segment.evaluate(s, 2);
    stretching += w * c * H1 * H1.transpose();
    bending += w * c * H2 * H2.transpose();
    mass += w * H * H.transpose();
    load += w * c * H;
  }
  CHECK(batten_test::relative_error(segment.stretching(weight), stretching) < 1e-14);
  CHECK(batten_test::relative_error(segment.bending(weight), bending) < 1e-14);
  CHECK(batten_test::relative_error(segment.mass(), mass) < 1e-14);
  CHECK(batten_test::relative_error(segment.load(weight), load) < 1e-14);
}

TEST_CASE("a segment stretches for all but constants and bends for all but linear functions",
          "[elements][hermite_segment]") {
  const HermiteSegment segment(0.6);
  const auto zero_modes = [](const Matrix& K) {
    const VecX values = symmetric_eigenvalues(K);
    return (values.array().abs() < 1e-12 * values[3]).count();
  };
  CHECK(zero_modes(segment.stretching()) == 1);
  CHECK(zero_modes(segment.bending()) == 2);
  CHECK(zero_modes(segment.mass()) == 0);
  const Vector one = power_dofs(2, 0.6, 0), linear = power_dofs(2, 0.6, 1);
  CHECK((segment.stretching() * one).norm() < 1e-14);
  CHECK((segment.bending() * one).norm() < 1e-12);
  CHECK((segment.bending() * linear).norm() < 1e-12);
}

TEST_CASE("a clamped beam under a uniform load has 1/384 in the middle",
          "[elements][hermite_segment]") {
  const auto gold = batten_test::reference("curve.json")["beam_test"];
  const HermiteSegment half(0.5);
  // Free: value and slope of the middle node, the second of the left and the first of the right
  // half.
  const Mat2 K = half.bending().bottomRightCorner<2, 2>() + half.bending().topLeftCorner<2, 2>();
  const Vec2 F = half.load().tail<2>() + half.load().head<2>();
  const Vec2 x = K.inverse() * F;
  CHECK(std::abs(x[0] - 1.0 / 384) < 1e-16);
  CHECK(std::abs(x[0] - gold["w_mid"].get<double>()) < 1e-16);
  CHECK(std::abs(x[1]) < 1e-16);
}

TEST_CASE("impossible segments are input errors", "[elements][hermite_segment]") {
  CHECK_THROWS_AS(HermiteSegment(0), InputError);
  CHECK_THROWS_AS(HermiteSegment(-1), InputError);
  CHECK_THROWS_AS(HermiteSegment(std::nan("")), InputError);
  CHECK_THROWS_AS(HermiteSegment(1).evaluate(0.5, 4), InputError);
  CHECK_THROWS_AS(HermiteSegment(1).evaluate(0.5, -1), InputError);
}
