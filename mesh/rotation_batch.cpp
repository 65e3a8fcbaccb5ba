#include "batten/mesh/rotation_batch.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/simd.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

constexpr int L = RotationBatch::kLanes;
using Lane = double[L];

BATTEN_INLINE void cofactors(const Lane* m, Lane* c, int l) {
  c[0][l] = m[4][l] * m[8][l] - m[5][l] * m[7][l];
  c[1][l] = m[5][l] * m[6][l] - m[3][l] * m[8][l];
  c[2][l] = m[3][l] * m[7][l] - m[4][l] * m[6][l];
  c[3][l] = m[7][l] * m[2][l] - m[8][l] * m[1][l];
  c[4][l] = m[8][l] * m[0][l] - m[6][l] * m[2][l];
  c[5][l] = m[6][l] * m[1][l] - m[7][l] * m[0][l];
  c[6][l] = m[1][l] * m[5][l] - m[2][l] * m[4][l];
  c[7][l] = m[2][l] * m[3][l] - m[0][l] * m[5][l];
  c[8][l] = m[0][l] * m[4][l] - m[1][l] * m[3][l];
}

BATTEN_INLINE double square(const Lane* m, int l) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += m[k][l] * m[k][l];
  return sum;
}

/// `well`: 1 where the denominator is large enough.
BATTEN_CLONES void markley(const Lane* M, Lane* R, double* well) {
  alignas(64) Lane m[9], c[9], s[6], det, cof, lambda;
  for (int l = 0; l < L; ++l) {
    const double scale = 1 / std::sqrt(square(M, l));
    for (int k = 0; k < 9; ++k) m[k][l] = M[k][l] * scale;  // |m| = 1
    cofactors(m, c, l);
    det[l] = m[0][l] * c[0][l] + m[1][l] * c[1][l] + m[2][l] * c[2][l];
    cof[l] = square(c, l);
    lambda[l] = 1.7320508075688772;  // σ1 + σ2 + σ3 ≤ √3 |m|: Newton descends to the largest root
  }
  for (int round = 0; round < 8; ++round)
    for (int l = 0; l < L; ++l) {
      const double x = lambda[l], k = x * x - 1;
      const double f = k * k - 8 * x * det[l] - 4 * cof[l];
      lambda[l] = x - f / (4 * x * k - 8 * det[l]);
    }
  for (int l = 0; l < L; ++l) {
    const double x = lambda[l], k = 0.5 * (x * x - 1), zeta = k * x - det[l];
    const double f = 4 * k * k - 8 * x * det[l] - 4 * cof[l];
    const bool good = zeta > 0.05 && std::abs(f) < 1e-13;
    well[l] = good ? 1 : 0;
    // M Mᵀ is symmetric: 00 01 02 11 12 22.
    for (int r = 0, e = 0; r < 3; ++r)
      for (int q = r; q < 3; ++q, ++e)
        s[e][l] = m[3 * r][l] * m[3 * q][l] + m[3 * r + 1][l] * m[3 * q + 1][l] +
                  m[3 * r + 2][l] * m[3 * q + 2][l];
    const double inverse = 1 / zeta;
    for (int col = 0; col < 3; ++col) {
      const double a = m[col][l], b = m[3 + col][l], d = m[6 + col][l];
      R[col][l] =
          ((k + 1) * a + x * c[col][l] - (s[0][l] * a + s[1][l] * b + s[2][l] * d)) * inverse;
      R[3 + col][l] =
          ((k + 1) * b + x * c[3 + col][l] - (s[1][l] * a + s[3][l] * b + s[4][l] * d)) * inverse;
      R[6 + col][l] =
          ((k + 1) * d + x * c[6 + col][l] - (s[2][l] * a + s[4][l] * b + s[5][l] * d)) * inverse;
    }
  }
  // A step of the polar iteration, R ← (R + R⁻ᵀ) / 2, takes the rounding of lengths and angles.
  for (int l = 0; l < L; ++l) {
    cofactors(R, c, l);
    det[l] = 1 / (R[0][l] * c[0][l] + R[1][l] * c[1][l] + R[2][l] * c[2][l]);
  }
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < L; ++l) R[k][l] = 0.5 * (R[k][l] + c[k][l] * det[l]);
}

}  // namespace

void nearest_rotations(const RotationBatch& M, RotationBatch& R) {
  alignas(64) double well[L];
  markley(M.a, R.a, well);
  for (int l = 0; l < L; ++l)
    if (well[l] != 1) R.set(l, nearest_rotation(M.get(l)));  // not finite where M = 0
}

void rotations_of_triangles(std::span<const std::array<int, 3>> triangles,
                            std::span<const int> which, const Points& before, const Points& after,
                            std::span<Mat3> rotations) {
  constexpr size_t lanes = RotationBatch::kLanes;
  RotationBatch gradients, rotation_batch;
  for (size_t first = 0; first < which.size(); first += lanes) {
    const size_t count = std::min(lanes, which.size() - first);
    std::array<bool, lanes> nearly_lines{};
    for (size_t l = 0; l < lanes; ++l) {
      const auto H = l < count ? deformation_gradient(triangles[which[first + l]], before, after)
                               : std::optional(Mat3(Mat3::Identity()));
      nearly_lines[l] = !H;
      gradients.set(static_cast<int>(l), H ? *H : Mat3(Mat3::Identity()));
    }
    nearest_rotations(gradients, rotation_batch);
    for (size_t l = 0; l < count; ++l)
      rotations[first + l] = nearly_lines[l]
                                 ? rotation_of_face(triangles[which[first + l]], before, after)
                                 : rotation_batch.get(static_cast<int>(l));
  }
}

}  // namespace batten
