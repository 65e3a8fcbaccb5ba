// SPDX-License-Identifier: MPL-2.0
#include "batten/elements/reference_triangle.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/simd.h"
#include "batten/elements/bernstein_cubics.h"

namespace batten {

// Shape functions of the rational triangle Z12.

// reference_functions() of Z12 at barycentric L. At a vertex, second derivatives are the limits
// along the bisecting direction.
ReferenceTabulation z12_functions(const Vec3& L);

namespace {

std::array<Eigen::Matrix<double, 10, 12>, 3> make_hct_ordinates() {
  using Row = Eigen::Matrix<double, 1, 12>;
  const auto w = [](int i) { return Row(Row::Unit(3 * i)); };
  const auto along = [](int i, int j) {
    return Row(Row::Unit(3 * i + (j == (i + 1) % 3 ? 1 : 2)));
  };
  const auto on_edge = [&](int i, int j) { return Row(w(i) + along(i, j) / 3); };
  Row on_spoke[3], inside[3], inner[3], centre = Row::Zero();
  for (int i = 0; i < 3; ++i)
    on_spoke[i] = w(i) + (along(i, (i + 1) % 3) + along(i, (i + 2) % 3)) / 9;
  for (int s = 0; s < 3; ++s) {
    const int j = (s + 1) % 3, k = (s + 2) % 3;
    inside[s] =
        2 * (Row::Unit(9 + s) / 9 + (w(j) + 3 * on_edge(j, k) + 3 * on_edge(k, j) + w(k)) / 8) -
        (on_spoke[j] + on_spoke[k]) / 2;
  }
  for (int i = 0; i < 3; ++i) {
    inner[i] = (on_spoke[i] + inside[(i + 1) % 3] + inside[(i + 2) % 3]) / 3;
    centre += inner[i] / 3;
  }
  std::array<Eigen::Matrix<double, 10, 12>, 3> ordinates;
  for (int s = 0; s < 3; ++s) {
    const int j = (s + 1) % 3, k = (s + 2) % 3;
    ordinates[s] << w(j), w(k), centre, on_edge(j, k), on_edge(k, j), on_spoke[k], inner[k],
        inner[j], on_spoke[j], inside[s];
  }
  return ordinates;
}

// sum = ordinatesᵀ (12 × 10) times cubics (10 × columns), all stored by columns.
BATTEN_CLONES void combine_cubics(const double* ordinates, const double* cubics, int columns,
                                  double* sum) {
  for (int c = 0; c < columns; ++c) {
    double column[12] = {};
    for (int m = 0; m < 10; ++m)
      for (int a = 0; a < 12; ++a) column[a] += ordinates[12 * m + a] * cubics[10 * c + m];
    for (int a = 0; a < 12; ++a) sum[12 * c + a] = column[a];
  }
}

const double* transposed_ordinates(int sub) {
  static const auto ordinates = [] {
    std::array<Eigen::Matrix<double, 12, 10>, 3> transposed;
    for (int s = 0; s < 3; ++s) transposed[s] = hct_ordinates(s).transpose();
    return transposed;
  }();
  return ordinates[sub].data();
}

ReferenceTabulation hct_functions(const Vec3& L) {
  const HctSubtriangle at(L);
  const Vec3 d1 = at.to_local({1, 0, -1}), d2 = at.to_local({0, 1, -1});
  Eigen::Matrix<double, 10, 6> table;
  table.col(0) = bernstein_cubics(at.local);
  table.col(1) = bernstein_derivatives(at.local, d1);
  table.col(2) = bernstein_derivatives(at.local, d2);
  table.col(3) = bernstein_derivatives(at.local, d1, d1);
  table.col(4) = bernstein_derivatives(at.local, d1, d2);
  table.col(5) = bernstein_derivatives(at.local, d2, d2);
  ReferenceTabulation functions;
  combine_cubics(transposed_ordinates(at.sub), table.data(), 6, functions.data());
  return functions;
}

ReferenceTensors make_tensors(TriangleElement kind) {
  const TriangleRule rule =
      kind == TriangleElement::HCT ? split_triangle_rule(6) : six_duffy_rule(14);
  ReferenceTensors T;
  Eigen::Matrix<double, 12, 12, Eigen::RowMajor> sum[9];
  for (auto& m : sum) m.setZero();
  T.mass.setZero();
  T.load.setZero();
  for (long p = 0; p < rule.weights.size(); ++p) {
    const double w = rule.weights[p];
    const ReferenceTabulation f = reference_functions(kind, rule.L.row(p).transpose());
    const auto add = [&](int tensor, int x, int y) {
      const Mat12 product = w * f.col(x) * f.col(y).transpose();
      sum[tensor] += product;
      if (x != y) sum[tensor] += product.transpose();
    };
    add(0, 1, 1);
    add(1, 1, 2);
    add(2, 2, 2);
    add(3, 3, 3);
    add(4, 4, 4);
    add(5, 5, 5);
    add(6, 3, 4);
    add(7, 3, 5);
    add(8, 4, 5);
    T.mass += w * f.col(0) * f.col(0).transpose();
    T.load += w * f.col(0);
  }
  for (int t = 0; t < 9; ++t) std::copy(sum[t].data(), sum[t].data() + 144, T.stiffness[t]);
  return T;
}

// One side of the congruence transformation: K ← Pᵀ K. The caller transposes and applies it again.
inline __attribute__((always_inline)) void congruence_half(const DofTransformCoefficients& P,
                                                           double* K) {
  const auto axpy = [&](int to, double s, int from) {
    for (int c = 0; c < 12; ++c) K[12 * to + c] += s * K[12 * from + c];
  };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double mu = P.slant[i];
    axpy(3 * j, -1.5 * mu, 9 + i);
    axpy(3 * k, 1.5 * mu, 9 + i);
    axpy(3 * j + 1, -0.25 * mu, 9 + i);
    axpy(3 * k + 2, 0.25 * mu, 9 + i);
  }
  for (int i = 0; i < 3; ++i) {
    const double* g = P.gradient[i];
    double* next = K + 12 * (3 * i + 1);
    double* previous = next + 12;
    double* mid = K + 12 * (9 + i);
    for (int c = 0; c < 12; ++c) {
      const double a = next[c], b = previous[c];
      next[c] = g[0] * a + g[2] * b;
      previous[c] = g[1] * a + g[3] * b;
      mid[c] *= P.altitude[i];
    }
  }
}

inline __attribute__((always_inline)) void congruence(const DofTransformCoefficients& P,
                                                      double* K) {
  alignas(64) double transposed[144];
  congruence_half(P, K);
  for (int r = 0; r < 12; ++r)
    for (int c = 0; c < 12; ++c) transposed[12 * r + c] = K[12 * c + r];
  congruence_half(P, transposed);
  for (int e = 0; e < 144; ++e) K[e] = transposed[e];
}

BATTEN_CLONES void combine_and_map(const double (*tensors)[144], const double* scale,
                                   const DofTransformCoefficients& P, double* K) {
  alignas(64) double sum[144];
  for (int e = 0; e < 144; ++e) {
    double s = 0;
    for (int t = 0; t < 9; ++t) s += scale[t] * tensors[t][e];
    sum[e] = s;
  }
  congruence(P, sum);
  for (int e = 0; e < 144; ++e) K[e] = sum[e];
}

// K = Σ_p rows_pᵀ C_p rows_p with C_p = blockdiag(2×2, 3×3), given as 4 + 9 values per point; then
// K ← Pᵀ K P.
BATTEN_CLONES void accumulate_and_map(int points, const double* rows, const double* C,
                                      const DofTransformCoefficients& P, double* K) {
  alignas(64) double sum[144] = {};
  for (int p = 0; p < points; ++p, rows += 60, C += 13) {
    double weighted[60];
    for (int a = 0; a < 12; ++a) {
      const double d1 = rows[a], d2 = rows[12 + a];
      const double h1 = rows[24 + a], h2 = rows[36 + a], h3 = rows[48 + a];
      weighted[a] = C[0] * d1 + C[1] * d2;
      weighted[12 + a] = C[2] * d1 + C[3] * d2;
      weighted[24 + a] = C[4] * h1 + C[5] * h2 + C[6] * h3;
      weighted[36 + a] = C[7] * h1 + C[8] * h2 + C[9] * h3;
      weighted[48 + a] = C[10] * h1 + C[11] * h2 + C[12] * h3;
    }
    for (int a = 0; a < 12; ++a)
      for (int b = 0; b < 12; ++b)
        sum[12 * a + b] += weighted[a] * rows[b] + weighted[12 + a] * rows[12 + b] +
                           weighted[24 + a] * rows[24 + b] + weighted[36 + a] * rows[36 + b] +
                           weighted[48 + a] * rows[48 + b];
  }
  congruence(P, sum);
  for (int e = 0; e < 144; ++e) K[e] = sum[e];
}

}  // namespace

const Eigen::Matrix<double, 10, 12>& hct_ordinates(int sub) {
  static const auto ordinates = make_hct_ordinates();
  return ordinates[sub];
}

ReferenceTabulation reference_functions(TriangleElement kind, const Vec3& L) {
  return kind == TriangleElement::HCT ? hct_functions(L) : z12_functions(L);
}

Eigen::Matrix<double, 12, 2> reference_gradients(TriangleElement kind, const Vec3& L) {
  if (kind != TriangleElement::HCT) return z12_functions(L).middleCols<2>(1);
  const HctSubtriangle at(L);
  Eigen::Matrix<double, 10, 2> table;
  table.col(0) = bernstein_derivatives(at.local, at.to_local({1, 0, -1}));
  table.col(1) = bernstein_derivatives(at.local, at.to_local({0, 1, -1}));
  Eigen::Matrix<double, 12, 2> slopes;
  combine_cubics(transposed_ordinates(at.sub), table.data(), 2, slopes.data());
  return slopes;
}

const ReferenceTensors& reference_tensors(TriangleElement kind) {
  static const ReferenceTensors hct = make_tensors(TriangleElement::HCT);
  static const ReferenceTensors z12 = make_tensors(TriangleElement::Z12);
  return kind == TriangleElement::HCT ? hct : z12;
}

DerivativeMap::DerivativeMap(const TriangleShape& t) {
  const double s = 1 / (2 * t.area);
  const double u1 = t.b[0] * s, u2 = t.b[1] * s, v1 = t.c[0] * s, v2 = t.c[1] * s;
  first << u1, u2, v1, v2;
  second << u1 * u1, 2 * u1 * u2, u2 * u2,  //
      u1 * v1, u1 * v2 + u2 * v1, u2 * v2,  //
      v1 * v1, 2 * v1 * v2, v2 * v2;
}

TabulatedRule::TabulatedRule(TriangleElement kind, TriangleRule r) : rule(std::move(r)) {
  functions.reserve(static_cast<size_t>(rule.weights.size()));
  rows.reserve(60 * functions.capacity());
  for (long p = 0; p < rule.weights.size(); ++p)
    functions.push_back(reference_functions(kind, rule.L.row(p).transpose()));
  for (const auto& f : functions) rows.insert(rows.end(), f.col(1).data(), f.col(1).data() + 60);
}

DofTransformCoefficients::DofTransformCoefficients(const TriangleShape& t) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    // V_next - V_i = (c_k, -b_k) and V_previous - V_i = (-c_j, b_j).
    gradient[i][0] = t.c[k];
    gradient[i][1] = -t.b[k];
    gradient[i][2] = -t.c[j];
    gradient[i][3] = t.b[j];
    const double length2 = t.b[i] * t.b[i] + t.c[i] * t.c[i];
    altitude[i] = t.edge_sign[i] * 2 * t.area / std::sqrt(length2);
    // V_i - M_i = ((V_i - V_j) + (V_i - V_k))/2, projected onto the edge vector (c_i, -b_i).
    slant[i] = 0.5 * ((t.c[j] - t.c[k]) * t.c[i] + (t.b[j] - t.b[k]) * t.b[i]) / length2;
  }
}

void constant_stiffness(const ReferenceTensors& tensors, const TriangleShape& shape,
                        const SurfaceStiffness& m, double* K) {
  const double A = shape.area, s = 1 / (2 * A);
  const double u1 = shape.b[0] * s, u2 = shape.b[1] * s, v1 = shape.c[0] * s, v2 = shape.c[1] * s;
  const double a11 = A * m.alpha(0, 0), a12 = A * m.alpha(0, 1), a22 = A * m.alpha(1, 1);
  const double b1 = A * m.beta[0], b2 = 2 * A * m.beta[1], b3 = A * m.beta[2];
  const double uu[3] = {u1 * u1, 2 * u1 * u2, u2 * u2};
  const double uv[3] = {u1 * v1, u1 * v2 + u2 * v1, u2 * v2};
  const double vv[3] = {v1 * v1, 2 * v1 * v2, v2 * v2};
  const auto bend = [&](int x, int y) {
    return b1 * uu[x] * uu[y] + b2 * uv[x] * uv[y] + b3 * vv[x] * vv[y];
  };
  double scale[9] = {a11 * u1 * u1 + 2 * a12 * u1 * v1 + a22 * v1 * v1,
                     a11 * u1 * u2 + a12 * (u1 * v2 + u2 * v1) + a22 * v1 * v2,
                     a11 * u2 * u2 + 2 * a12 * u2 * v2 + a22 * v2 * v2,
                     bend(0, 0),
                     bend(1, 1),
                     bend(2, 2),
                     bend(0, 1),
                     bend(0, 2),
                     bend(1, 2)};
  if (m.beta_mixed != Vec3::Zero()) {
    const double m1 = A * m.beta_mixed[0], m2 = A * m.beta_mixed[1], m3 = A * m.beta_mixed[2];
    const auto mixed = [&](int x, int y) {
      return m1 * (uu[x] * uv[y] + uv[x] * uu[y]) + m2 * (uu[x] * vv[y] + vv[x] * uu[y]) +
             m3 * (uv[x] * vv[y] + vv[x] * uv[y]);
    };
    constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int i = 0; i < 6; ++i) scale[3 + i] += mixed(pairs[i][0], pairs[i][1]);
  }
  combine_and_map(tensors.stiffness, scale, DofTransformCoefficients(shape), K);
}

void variable_stiffness(const TabulatedRule& points, const TriangleShape& shape,
                        const std::function<SurfaceStiffness(const Vec3& L)>& material, double* K) {
  constexpr int on_stack = 256;
  const int n = isize(points.functions);
  const DerivativeMap map(shape);
  double few[13 * on_stack];
  std::vector<double> many(n > on_stack ? 13 * static_cast<size_t>(n) : 0);
  double* C = many.empty() ? few : many.data();
  for (int p = 0; p < n; ++p) {
    const SurfaceStiffness m = material(points.rule.L.row(p).transpose());
    const double w = shape.area * points.rule.weights[p];
    Eigen::Map<Mat2> stretch(C + 13 * p);
    Eigen::Map<Mat3> bend(C + 13 * p + 4);
    stretch = w * map.first.transpose() * m.alpha * map.first;
    const Vec3 beta(m.beta[0], 2 * m.beta[1], m.beta[2]);
    bend = w * map.second.transpose() * beta.asDiagonal() * map.second;
    if (m.beta_mixed == Vec3::Zero()) continue;
    const Mat3 mixed = m.bending() - Mat3(beta.asDiagonal());
    bend += w * map.second.transpose() * mixed * map.second;
  }
  accumulate_and_map(n, points.rows.data(), C, DofTransformCoefficients(shape), K);
}

TriangleShape::TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                             const std::array<double, 3>& signs)
    : vertex{v1, v2, v3}, edge_sign(signs) {
  for (int i = 0; i < 3; ++i) {
    const Vec2 &j = vertex[(i + 1) % 3], &k = vertex[(i + 2) % 3];
    b[i] = j.y() - k.y();
    c[i] = k.x() - j.x();
  }
  area = 0.5 * (c[2] * b[1] - c[1] * b[2]);
  if (!(area > 0) || !std::isfinite(area))
    throw MeshError("found a parametric triangle of area " + format_number(area) + " at (" +
                    format_number(v1.x()) + ", " + format_number(v1.y()) +
                    "), expected counter-clockwise vertices that are not collinear");
}

Vec3 TriangleShape::barycentric(const Vec2& p) const {
  Vec3 L;
  for (int i = 0; i < 3; ++i) {
    const Vec2 d = p - vertex[(i + 1) % 3];
    L[i] = (b[i] * d.x() + c[i] * d.y()) / (2 * area);
  }
  return L;
}

SurfaceStiffness SurfaceStiffness::directional(const Vec2& t, double alpha, double beta) {
  constexpr double unit = 1e-9;
  if (!(std::abs(t.norm() - 1) <= unit))
    throw InputError("directional stiffness: found the direction (" + format_number(t.x()) + ", " +
                     format_number(t.y()) + ") of length " + format_number(t.norm()) +
                     ", expected length 1");
  // w_tt = a w_uu + 2 b w_uv + c w_vv.
  const double a = t.x() * t.x(), b = t.x() * t.y(), c = t.y() * t.y();
  return {alpha * t * t.transpose(), beta * Vec3(a * a, 2 * b * b, c * c),
          beta * Vec3(2 * a * b, a * c, 2 * b * c)};
}

SurfaceStiffness& SurfaceStiffness::operator+=(const SurfaceStiffness& other) {
  alpha += other.alpha;
  beta += other.beta;
  beta_mixed += other.beta_mixed;
  return *this;
}

SurfaceStiffness& SurfaceStiffness::operator*=(double factor) {
  alpha *= factor;
  beta *= factor;
  beta_mixed *= factor;
  return *this;
}

Mat3 SurfaceStiffness::bending() const {
  Mat3 B;
  B << beta[0], beta_mixed[0], beta_mixed[1],     //
      beta_mixed[0], 2 * beta[1], beta_mixed[2],  //
      beta_mixed[1], beta_mixed[2], beta[2];
  return B;
}

bool SurfaceStiffness::is_valid() const {
  if (!alpha.allFinite() || !beta.allFinite() || !beta_mixed.allFinite()) return false;
  constexpr double rounding = 1e-12;
  const Mat3 B = bending();
  return alpha.isApprox(alpha.transpose()) &&
         symmetric_eigenvalues(alpha)[0] >= -rounding * alpha.norm() &&
         symmetric_eigenvalues(B)[0] >= -rounding * B.norm();
}

namespace {

// Value, gradient and Hessian of a function of (L1, L2, L3), treated as independent variables.
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

// Rational bubble e_i = p(L_i) g(L_j) g(L_k), p = x(1+x), g = x²/(1-x). 1 - L_k is evaluated as L_i
// + L_j.
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

// Raw functions of the space, in the order f1 f2 f3 f12 f13 f23 f21 f31 f32 e1 e2 e3.
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

// Columns: coefficients of N̂_a in the raw functions; the inverse of the matrix of reference dofs
// of the raw functions.
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
