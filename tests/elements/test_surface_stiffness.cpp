// SPDX-License-Identifier: MPL-2.0
#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/reference_triangle.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// w = p(u, v) of degree 3 and its derivatives; 12 dofs on a triangle.
struct Cubic {
  std::array<double, 10> c;  // 1 u v u² uv v² u³ u²v uv² v³
  explicit Cubic(Random& random) {
    for (double& x : c) x = random();
  }
  Vec2 gradient(const Vec2& p) const {
    const double u = p.x(), v = p.y();
    return {c[1] + 2 * c[3] * u + c[4] * v + 3 * c[6] * u * u + 2 * c[7] * u * v + c[8] * v * v,
            c[2] + c[4] * u + 2 * c[5] * v + c[7] * u * u + 2 * c[8] * u * v + 3 * c[9] * v * v};
  }
  Mat2 hessian(const Vec2& p) const {
    const double u = p.x(), v = p.y();
    Mat2 H;
    H(0, 0) = 2 * c[3] + 6 * c[6] * u + 2 * c[7] * v;
    H(0, 1) = H(1, 0) = c[4] + 2 * c[7] * u + 2 * c[8] * v;
    H(1, 1) = 2 * c[5] + 2 * c[8] * u + 6 * c[9] * v;
    return H;
  }
  double value(const Vec2& p) const {
    const double u = p.x(), v = p.y();
    return c[0] + c[1] * u + c[2] * v + c[3] * u * u + c[4] * u * v + c[5] * v * v +
           c[6] * u * u * u + c[7] * u * u * v + c[8] * u * v * v + c[9] * v * v * v;
  }
};

// Dofs of w(R p) on a triangle, for a rotation R of the plane.
template <class Function>
Vec12 dofs_on(const TriangleShape& shape, const Function& w, const Mat2& R) {
  Vec12 q;
  for (int i = 0; i < 3; ++i) {
    q[3 * i] = w.value(R * shape.vertex[i]);
    q.segment<2>(3 * i + 1) = R.transpose() * w.gradient(R * shape.vertex[i]);
    const Vec2 &a = shape.vertex[(i + 1) % 3], &b = shape.vertex[(i + 2) % 3];
    const Vec2 t = shape.edge_sign[i] * (b - a).normalized();
    q[9 + i] = Vec2(-t.y(), t.x()).dot(R.transpose() * w.gradient(R * (0.5 * (a + b))));
  }
  return q;
}

template <class Density>
double integral(const TriangleShape& shape, const Density& density) {
  const TriangleRule rule = symmetric_triangle_rule(6);
  double sum = 0;
  for (long p = 0; p < rule.weights.size(); ++p)
    sum += shape.area * rule.weights[p] * density(shape.point(rule.L.row(p)));
  return sum;
}

TriangleShape random_triangle(Random& random) {
  return {Vec2(0.1, 0.2) + 0.2 * Vec2(random(), random()),
          Vec2(1.3, 0.4) + 0.2 * Vec2(random(), random()),
          Vec2(0.5, 1.1) + 0.2 * Vec2(random(), random()),
          {1, -1, 1}};
}

Mat12 varying(TriangleElement kind, const TriangleShape& shape, const SurfaceStiffness& material) {
  Mat12 K;
  const TabulatedRule rule(
      kind, kind == TriangleElement::HCT ? split_triangle_rule(4) : six_duffy_rule(10));
  variable_stiffness(
      rule, shape, [&](const Vec3&) { return material; }, K.data());
  return K;
}

}  // namespace

TEST_CASE("resistance in a direction costs the derivatives in that direction",
          "[elements][stiffness]") {
  Random random(3);
  for (const auto kind : kBothElements)
    for (int round = 0; round < 20; ++round) {
      const TriangleShape shape = random_triangle(random);
      const Cubic w(random);
      const double angle = 4 * random(), alpha = random.between(0, 2), beta = random.between(0, 2);
      const Vec2 t(std::cos(angle), std::sin(angle));
      const double expected = integral(shape, [&](const Vec2& p) {
        return alpha * std::pow(t.dot(w.gradient(p)), 2) +
               beta * std::pow(t.dot(w.hessian(p) * t), 2);
      });
      const auto material = SurfaceStiffness::directional(t, alpha, beta);
      const Vec12 q = dofs_on(shape, w, Mat2::Identity());
      CHECK(q.dot(C1Triangle(kind, shape).stiffness(material) * q) ==
            Approx(expected).epsilon(1e-10));
      CHECK(q.dot(varying(kind, shape, material) * q) == Approx(expected).epsilon(1e-10));
      CHECK(material.is_valid());
    }
}

TEST_CASE("every term of the energy is its integral, constant and varying",
          "[elements][stiffness]") {
  Random random(5);
  for (const auto kind : kBothElements)
    for (int round = 0; round < 20; ++round) {
      const TriangleShape shape = random_triangle(random);
      const Cubic w(random);
      SurfaceStiffness m;
      m.alpha << random(), random(), 0, random();
      m.alpha(1, 0) = m.alpha(0, 1);
      m.beta = random.point();
      m.beta_mixed = random.point();
      const double expected = integral(shape, [&](const Vec2& p) {
        const Mat2 H = w.hessian(p);
        const double uu = H(0, 0), uv = H(0, 1), vv = H(1, 1);
        return w.gradient(p).dot(m.alpha * w.gradient(p)) + m.beta[0] * uu * uu +
               2 * m.beta[1] * uv * uv + m.beta[2] * vv * vv + 2 * m.beta_mixed[0] * uu * uv +
               2 * m.beta_mixed[1] * uu * vv + 2 * m.beta_mixed[2] * uv * vv;
      });
      const Vec12 q = dofs_on(shape, w, Mat2::Identity());
      CHECK(q.dot(C1Triangle(kind, shape).stiffness(m) * q) ==
            Approx(expected).epsilon(1e-9).margin(1e-9));
      CHECK(q.dot(varying(kind, shape, m) * q) == Approx(expected).epsilon(1e-9).margin(1e-9));
    }
}

TEST_CASE("the energy of a turned surface in a turned direction is the same",
          "[elements][stiffness]") {
  Random random(7);
  for (const auto kind : kBothElements)
    for (int round = 0; round < 20; ++round) {
      const TriangleShape shape = random_triangle(random);
      const double angle = 4 * random(), turn = 4 * random();
      const Mat2 R = Eigen::Rotation2Dd(turn).toRotationMatrix();
      const Cubic w(random);
      const Vec2 t(std::cos(angle), std::sin(angle));
      const TriangleShape turned(R * shape.vertex[0], R * shape.vertex[1], R * shape.vertex[2],
                                 shape.edge_sign);
      const auto energy = [&](const TriangleShape& on, const Vec2& direction, const Mat2& by) {
        const auto material = SurfaceStiffness::isotropic(0.3, 0.7) +
                              2.0 * SurfaceStiffness::directional(direction, 0.4, 1.1);
        const Vec12 q = dofs_on(on, w, by);
        return q.dot(C1Triangle(kind, on).stiffness(material) * q);
      };
      CHECK(energy(shape, t, R) == Approx(energy(turned, R * t, Mat2::Identity())).epsilon(1e-10));
    }
}

TEST_CASE("materials that add up have energies that add up, and zero mixed terms leave all bits",
          "[elements][stiffness]") {
  Random random(9);
  for (const auto kind : kBothElements) {
    const TriangleShape shape = random_triangle(random);
    const C1Triangle element(kind, shape);
    const auto a = SurfaceStiffness::directional({0.6, 0.8}, 1, 2),
               b = SurfaceStiffness::isotropic(0.2, 3);
    const Mat12 sum = element.stiffness(a + 0.5 * b),
                parts = element.stiffness(a) + 0.5 * element.stiffness(b);
    CHECK((sum - parts).norm() < 1e-13 * sum.norm());
    // Mixed terms that are negligible relative to the others: the other code path, the same
    // numbers.
    SurfaceStiffness nearly = b;
    nearly.beta_mixed.setConstant(1e-300);
    CHECK(element.stiffness(nearly) == element.stiffness(b));
    CHECK((b + 0.0 * a).beta_mixed == Vec3::Zero());
  }
}

TEST_CASE("which materials are valid", "[elements][stiffness]") {
  CHECK(SurfaceStiffness{}.is_valid());
  CHECK(SurfaceStiffness::isotropic(0, 0).is_valid());
  CHECK_FALSE(SurfaceStiffness::isotropic(-1e-3, 1).is_valid());
  CHECK_FALSE(SurfaceStiffness::isotropic(1, -1e-3).is_valid());
  CHECK_FALSE(SurfaceStiffness::isotropic(std::nan(""), 1).is_valid());
  SurfaceStiffness m;
  m.beta_mixed << 0, 0.99, 0;
  CHECK(m.is_valid());
  m.beta_mixed << 0, 1.01, 0;  // w_uu² + w_vv² + 2.02 w_uu w_vv
  CHECK_FALSE(m.is_valid());
  m.beta_mixed << 1.41, 0, 0;  // against w_uu² + 2 w_uv²
  CHECK(m.is_valid());
  m.beta_mixed << 1.42, 0, 0;
  CHECK_FALSE(m.is_valid());
  m = {};
  m.alpha << 1, 0.5, 0.4, 1;
  CHECK_FALSE(m.is_valid());
  CHECK_THROWS_AS(SurfaceStiffness::directional({1, 1}, 1, 1), InputError);
  CHECK_THROWS_AS(SurfaceStiffness::directional({std::nan(""), 1}, 1, 1), InputError);
}
