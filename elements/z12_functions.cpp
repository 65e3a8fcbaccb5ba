#include "batten/elements/z12_functions.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

namespace batten {
namespace {

// Value, gradient and Hessian of one function of (L1, L2, L3) treated as independent.
struct Jet {
  double value = 0;
  Vec3 gradient = Vec3::Zero();
  Mat3 hessian = Mat3::Zero();
};

Jet variable(int i, const Vec3& L) { return {L[i], Vec3::Unit(i), Mat3::Zero()}; }

Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.gradient + b.gradient, a.hessian + b.hessian};
}
Jet operator*(double s, const Jet& a) { return {s * a.value, s * a.gradient, s * a.hessian}; }
Jet operator-(const Jet& a, const Jet& b) { return a + -1.0 * b; }
Jet operator*(const Jet& a, const Jet& b) {
  const Mat3 cross = a.gradient * b.gradient.transpose();
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient,
          a.value * b.hessian + b.value * a.hessian + cross + cross.transpose()};
}

using Row6 = Eigen::Matrix<double, 1, 6>;

Row6 reduced(const Jet& f) {
  const auto& g = f.gradient;
  const auto& H = f.hessian;
  Row6 r;
  r << f.value, g[0] - g[2], g[1] - g[2], H(0, 0) - 2 * H(0, 2) + H(2, 2),
      H(0, 1) - H(0, 2) - H(1, 2) + H(2, 2), H(1, 1) - 2 * H(1, 2) + H(2, 2);
  return r;
}

// e_i = p(L_i) g(L_j) g(L_k), p = x(1+x), g = x²/(1-x). 1 - L_k is taken as L_i + L_j.
Jet rational_bubble(int i, const Vec3& L) {
  constexpr double at_vertex = 1e-12;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  for (int v = 0; v < 3; ++v) {
    const int a = (v + 1) % 3, b = (v + 2) % 3;
    if (std::abs(L[a]) + std::abs(L[b]) > at_vertex) continue;
    // Limit at vertex v along the bisecting direction: value and gradient vanish, and the Hessian
    // in (L_a, L_b) is [[-1/4, 1/2], [1/2, 1/4]] for e_a, its mirror image for e_b, zero for e_v.
    Jet limit;
    if (i == v) return limit;
    const int other = i == a ? b : a;
    limit.hessian(i, i) = -0.25;
    limit.hessian(other, other) = 0.25;
    limit.hessian(i, other) = limit.hessian(other, i) = 0.5;
    return limit;
  }
  const auto g = [&](int m) {
    const double x = L[m], y = L[(m + 1) % 3] + L[(m + 2) % 3];
    Jet f;
    f.value = x * x / y;
    f.gradient[m] = x * (1 + y) / (y * y);
    f.hessian(m, m) = 2 / (y * y * y);
    return f;
  };
  Jet p;
  p.value = L[i] * (1 + L[i]);
  p.gradient[i] = 1 + 2 * L[i];
  p.hessian(i, i) = 2;
  return p * (g(j) * g(k));
}

// Raw functions f1 f2 f3 f12 f13 f23 f21 f31 f32 e1 e2 e3.
std::array<Jet, 12> z12_raw(const Vec3& L) {
  const Jet x[3] = {variable(0, L), variable(1, L), variable(2, L)};
  const Jet half_bubble = 0.5 * (x[0] * x[1] * x[2]);
  const auto f = [&](int i, int j) { return x[i] * x[i] * x[j] + half_bubble; };
  std::array<Jet, 12> raw;
  for (int i = 0; i < 3; ++i) {
    const Jet &j = x[(i + 1) % 3], &k = x[(i + 2) % 3];
    raw[i] = x[i] + x[i] * x[i] * (j + k) - x[i] * (j * j + k * k);
    raw[9 + i] = rational_bubble(i, L);
  }
  raw[3] = f(0, 1);
  raw[4] = f(0, 2);
  raw[5] = f(1, 2);
  raw[6] = f(1, 0);
  raw[7] = f(2, 0);
  raw[8] = f(2, 1);
  return raw;
}

// Columns: coefficients of N̂_a over the raw functions, the inverse of "reference dofs of raw".
const Mat12& z12_coefficients() {
  static const Mat12 coefficients = [] {
    Mat12 dofs_of_raw;
    for (int i = 0; i < 3; ++i) {
      const int next = (i + 1) % 3, previous = (i + 2) % 3;
      const auto at_vertex = z12_raw(Vec3::Unit(i));
      const auto at_middle = z12_raw(0.5 * (Vec3::Unit(next) + Vec3::Unit(previous)));
      const Vec3 median = Vec3::Unit(i) - 0.5 * (Vec3::Unit(next) + Vec3::Unit(previous));
      for (int r = 0; r < 12; ++r) {
        const Vec3& g = at_vertex[r].gradient;
        dofs_of_raw(3 * i, r) = at_vertex[r].value;
        dofs_of_raw(3 * i + 1, r) = g[next] - g[i];
        dofs_of_raw(3 * i + 2, r) = g[previous] - g[i];
        dofs_of_raw(9 + i, r) = at_middle[r].gradient.dot(median);
      }
    }
    return Mat12(dofs_of_raw.inverse());
  }();
  return coefficients;
}

}  // namespace

ReferenceTabulation z12_functions(const Vec3& L) {
  const auto raw = z12_raw(L);
  ReferenceTabulation t;
  for (int r = 0; r < 12; ++r) t.row(r) = reduced(raw[r]);
  return z12_coefficients().transpose() * t;
}

}  // namespace batten
