// Rotation parts of many matrices at once.
#pragma once

#include <array>
#include <span>

#include "batten/core/eigen.h"

namespace batten {

/// Matrices side by side: entry (r, c) of matrix l is a[3 r + c][l].
struct RotationBatch {
  static constexpr int kLanes = 8;
  alignas(64) double a[9][kLanes];

  void set(int lane, const Mat3& M) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) a[3 * r + c][lane] = M(r, c);
  }
  Mat3 get(int lane) const {
    Mat3 M;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) M(r, c) = a[3 * r + c][lane];
    return M;
  }
};

/// nearest_rotation() (mesh/rotation_fitting.h) of each matrix M. The largest root of
///
///     (λ² - |M|²)² - 8 λ det M - 4 |cof M|² = 0
///
/// is λ = σ1 + σ2 ± σ3 = max tr(Rᵀ M), and with κ = (λ² - |M|²) / 2
///
///     R = [(κ + |M|²) M + λ cof M - M Mᵀ M] / (κ λ - det M)
///
/// which holds for flat matrices (σ3 = 0) and mirrored ones (det M < 0) as it stands. Matrices
/// whose denominator (σ1 + σ2)(σ2 ± σ3)(σ3 ± σ1) is small go to nearest_rotation() itself. Exact to 1e-14
/// where the shape is good. 15 to 30 ns a matrix. Source: Markley 1993 (FOAM).
void nearest_rotations(const RotationBatch& M, RotationBatch& R);

/// rotation_of_face() (mesh/rotation_fitting.h) of those of a mesh's triangles whose numbers are `which`,
/// eight at once; `rotations` has room for as many. 50 ns each.
void rotations_of_triangles(std::span<const std::array<int, 3>> triangles,
                            std::span<const int> which, const Points& before, const Points& after,
                            std::span<Mat3> rotations);

}  // namespace batten
