// SPDX-License-Identifier: MPL-2.0
#include "batten/elements/quadrature.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

// ∫ L1^a L2^b L3^c over a triangle of area 1.
double monomial_integral(int a, int b, int c) {
  return 2 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 2);
}

double whole_power(double x, int e) { return e == 0 ? 1 : x * whole_power(x, e - 1); }

// Largest error over all monomials L1^a L2^b L3^c with a + b + c = degree.
double error_at_degree(const TriangleRule& rule, int degree) {
  double worst = 0;
  for (int a = 0; a <= degree; ++a)
    for (int b = 0; a + b <= degree; ++b) {
      const int c = degree - a - b;
      double sum = 0;
      for (long p = 0; p < rule.weights.size(); ++p)
        sum += rule.weights[p] * whole_power(rule.L(p, 0), a) * whole_power(rule.L(p, 1), b) *
               whole_power(rule.L(p, 2), c);
      worst = std::max(worst, std::abs(sum - monomial_integral(a, b, c)));
    }
  return worst;
}

void check_is_a_rule(const TriangleRule& rule) {
  REQUIRE(rule.L.rows() == rule.weights.size());
  CHECK(std::abs(rule.weights.sum() - 1) < 1e-15 * std::sqrt(rule.weights.size()) + 1e-15);
  CHECK(rule.weights.minCoeff() > 0);
  CHECK(rule.L.minCoeff() >= 0);  // inside the triangle or on its boundary
  CHECK((rule.L.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-15);
}

}  // namespace

TEST_CASE("symmetric triangle rules integrate every monomial of their degree, no more",
          "[elements][quadrature]") {
  const int points[9] = {1, 1, 3, 6, 6, 7, 12, 16, 16};
  const int exact[9] = {1, 1, 2, 4, 4, 5, 6, 8, 8};
  for (int degree = 0; degree <= 8; ++degree) {
    INFO("degree " << degree);
    const TriangleRule rule = symmetric_triangle_rule(degree);
    check_is_a_rule(rule);
    CHECK(rule.weights.size() == points[degree]);
    for (int d = 0; d <= exact[degree]; ++d) CHECK(error_at_degree(rule, d) < 1e-15);
    CHECK(error_at_degree(rule, exact[degree] + 1) > 1e-7);
  }
}

TEST_CASE("symmetric triangle rules do not prefer a vertex", "[elements][quadrature]") {
  for (int degree = 1; degree <= 8; ++degree) {
    const TriangleRule rule = symmetric_triangle_rule(degree);
    const int permutations[5][3] = {{1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (const auto& permutation : permutations)
      for (long p = 0; p < rule.weights.size(); ++p) {
        bool found = false;
        for (long q = 0; q < rule.weights.size(); ++q) {
          double distance = std::abs(rule.weights[p] - rule.weights[q]);
          for (int i = 0; i < 3; ++i)
            distance += std::abs(rule.L(p, i) - rule.L(q, permutation[i]));
          found = found || distance < 1e-14;
        }
        CHECK(found);
      }
  }
}

TEST_CASE("Gauss-Legendre with n points is exact to degree 2n-1", "[elements][quadrature]") {
  for (int n = 1; n <= 12; ++n) {
    INFO(n << " points");
    const SegmentRule rule = gauss_legendre(n);
    REQUIRE(rule.s.size() == n);
    REQUIRE(rule.weights.size() == n);
    CHECK(std::abs(rule.weights.sum() - 1) < 1e-15);
    CHECK(rule.weights.minCoeff() > 0);
    CHECK(rule.s.minCoeff() > 0);
    CHECK(rule.s.maxCoeff() < 1);
    for (int i = 0; i < n; ++i) {
      CHECK(std::abs(rule.s[i] + rule.s[n - 1 - i] - 1) < 1e-15);
      if (i > 0) CHECK(rule.s[i] > rule.s[i - 1]);
    }
    const auto integral = [&](int degree) {
      double sum = 0;
      for (int i = 0; i < n; ++i) sum += rule.weights[i] * whole_power(rule.s[i], degree);
      return sum;
    };
    for (int degree = 0; degree < 2 * n; ++degree)
      CHECK(std::abs(integral(degree) - 1.0 / (degree + 1)) < 1e-15);
    // The error at degree 2n is known: (n!)^4 / ((2n+1) ((2n)!)²).
    const double missing =
        whole_power(factorial(n), 4) / ((2 * n + 1) * whole_power(factorial(2 * n), 2));
    CHECK(std::abs(1.0 / (2 * n + 1) - integral(2 * n) - missing) < 1e-6 * missing + 1e-15);
  }
}

TEST_CASE("large Gauss rules stay accurate", "[elements][quadrature]") {
  const SegmentRule rule = gauss_legendre(64);
  CHECK(std::abs(rule.weights.sum() - 1) < 4e-15);
  CHECK(std::abs(rule.weights.dot(rule.s.array().exp().matrix()) - (std::exp(1.0) - 1)) < 4e-15);
}

TEST_CASE("split rules integrate piecewise polynomials on the three sub-triangles",
          "[elements][quadrature]") {
  for (const int degree : {1, 2, 4, 5, 6, 8}) {
    INFO("degree " << degree);
    const TriangleRule rule = split_triangle_rule(degree);
    check_is_a_rule(rule);
    const long n = symmetric_triangle_rule(degree).weights.size();
    REQUIRE(rule.weights.size() == 3 * n);
    // λ1^a λ2^b λ3^c on sub-triangle s and 0 on the other two; (λ1, λ2, λ3) are its own barycentric
    // coordinates, λ3 at the centroid.
    for (int s = 0; s < 3; ++s)
      for (int a = 0; a <= degree; ++a)
        for (int b = 0; a + b <= degree; ++b)
          for (int c = 0; a + b + c <= degree; ++c) {
            double sum = 0;
            for (long p = 0; p < 3 * n; ++p) {
              const Vec3 L = rule.L.row(p);
              int sub = 0;
              L.minCoeff(&sub);
              REQUIRE(sub == p / n);  // ordered by sub-triangle
              if (sub != s) continue;
              sum += rule.weights[p] * whole_power(L[(s + 1) % 3] - L[s], a) *
                     whole_power(L[(s + 2) % 3] - L[s], b) * whole_power(3 * L[s], c);
            }
            CHECK(std::abs(sum - monomial_integral(a, b, c) / 3) < 1e-15);
          }
  }
}

TEST_CASE("the six-Duffy rule is exact to degree 2m-2 and resolves the rational Z12 functions",
          "[elements][quadrature]") {
  for (int m = 1; m <= 7; ++m) {
    INFO("m = " << m);
    const TriangleRule rule = six_duffy_rule(m);
    check_is_a_rule(rule);
    CHECK(rule.weights.size() == 6 * m * m);
    for (int degree = 0; degree <= 2 * m - 2; ++degree)
      CHECK(error_at_degree(rule, degree) < 3e-15);
    CHECK(error_at_degree(rule, 2 * m) > 1e-14);
  }

  // Bounded, but with a different limit for each direction at two vertices, as the second
  // derivatives of Z12. The integral is 1/9.
  const auto error = [](const TriangleRule& rule) {
    double sum = 0;
    for (long p = 0; p < rule.weights.size(); ++p) {
      const double x = rule.L(p, 0), y = rule.L(p, 1), z = rule.L(p, 2);
      sum += rule.weights[p] * whole_power(y / (x + y), 4) * whole_power(z / (x + z), 2);
    }
    return std::abs(sum - 1.0 / 9);
  };
  CHECK(error(six_duffy_rule(3)) < 1e-4);
  CHECK(error(six_duffy_rule(5)) < 1e-7);
  CHECK(error(six_duffy_rule(7)) < 1e-10);
  CHECK(error(six_duffy_rule(10)) < 3e-15);
  CHECK(error(symmetric_triangle_rule(8)) > 1e-3);
}

TEST_CASE("rules that do not exist are input errors", "[elements][quadrature]") {
  CHECK_THROWS_AS(gauss_legendre(0), InputError);
  CHECK_THROWS_AS(gauss_legendre(-3), InputError);
  CHECK_THROWS_AS(symmetric_triangle_rule(9), InputError);
  CHECK_THROWS_AS(symmetric_triangle_rule(-1), InputError);
  CHECK_THROWS_AS(split_triangle_rule(9), InputError);
  CHECK_THROWS_AS(six_duffy_rule(0), InputError);
}
