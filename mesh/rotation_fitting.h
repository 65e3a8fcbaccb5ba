// SPDX-License-Identifier: MPL-2.0
// Rotations and similarities fitted to deformations: polar decomposition, rotation of a face, mean
// and median of rotations, Procrustes fits.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Rotation nearest to a matrix (orthogonal Procrustes problem).
///
/// The result R maximises tr(Rᵀ M) over all R with det R = +1. With the SVD M = P Σ Qᵀ, R = P
/// diag(1, 1, det P det Qᵀ) Qᵀ; the last diagonal entry belongs to the smallest singular value. If
/// det M > 0, R is the rotation of the polar decomposition. If det M < 0, the direction of the
/// smallest singular value is flipped, so R is never a reflection. If M has rank 2, R maps the
/// normal of its row space to the normal of its column space. If M has rank 1, R is the smallest
/// rotation from the line of its rows to the line of its columns. If M has rank 0 or non-finite
/// entries, R is the identity.
///
/// Accuracy: about 1e-16 divided by the gap between the singular values, 4e-16 for well-conditioned
/// M. Cost: 0.3 µs (Newton iteration for the polar decomposition), 0.8 µs for matrices that are
/// nearly reflected or nearly of rank 1. References: [Higham1986] (iteration); [Umeyama1991]
/// (sign).
Mat3 nearest_rotation(const Mat3& M);

/// Best-fitting rotation of a face between the vertex positions `before` and `after` (n×3 each).
/// Let the columns of U and U' be the positions of the corners relative to their centroid, before
/// and after the deformation. The rotation is
///
///     R = nearest_rotation(H),   H = U' U⁺
///
/// U⁺ is the pseudo-inverse. For a planar face, H has rank 2 and R maps the normal before the
/// deformation to the normal after it. If the corners are collinear before or after the
/// deformation, R is the smallest rotation between the two lines; if the corners coincide, R is the
/// identity. Singular values of U below 1e-12 of the largest one count as zero. O(corners).
/// Reference: [Hu2012], section II B.
Mat3 rotation_of_face(std::span<const int> corners, const Points& before, const Points& after);

/// Deformation gradient H = F (Eᵀ E)⁻¹ Eᵀ of a triangle. The columns of E and F (3×2) are two edge
/// vectors of the triangle before and after the deformation. Empty if the face is not a triangle,
/// or if its corners are nearly collinear before the deformation.
std::optional<Mat3> deformation_gradient(std::span<const int> corners, const Points& before,
                                         const Points& after);

/// L2 mean of rotations R_i with weights w_i: the rotation R that minimises Σ w_i ‖R - R_i‖²
/// (Frobenius norm), which is nearest_rotation(Σ w_i R_i). The weights (areas, for example) must be
/// non-negative. The result is the identity if `rotations` is empty. Throws InputError if the
/// numbers of weights and rotations differ.
Mat3 mean_rotation(std::span<const Mat3> rotations, std::span<const double> weights);

/// L1 mean (geometric median) of rotations R_i with weights w_i: the rotation R that minimises Σ
/// w_i ‖R - R_i‖ (Frobenius norm). It is robust against outliers with up to half of the total
/// weight. Weiszfeld's iteration starts from mean_rotation() and repeatedly computes the mean with
/// the weights w_i / ‖R - R_i‖, which never increases the sum. Norms below 1e-12 are replaced by
/// 1e-12. The iteration stops when R changes by less than 1e-14, or after 1000 iterations (a few
/// tens suffice if most R_i are equal). Throws InputError if the numbers of weights and rotations
/// differ. Reference: [Hartley2013], section 5.
Mat3 median_rotation(std::span<const Mat3> rotations, std::span<const double> weights);

// Nearest rotations of many matrices at once (SIMD).

/// Eight 3×3 matrices in structure-of-arrays layout: entry (r, c) of matrix `lane` is
/// a[3 r + c][lane].
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

/// Computes the nearest rotation R of each of the eight 3×3 matrices M of a batch; see
/// nearest_rotation(). Let λ be the largest root of
///
///     (λ² - |M|²)² - 8 λ det M - 4 |cof M|² = 0
///
/// with the Frobenius norm |M| and the cofactor matrix cof M. With the singular values σ1 ≥ σ2 ≥ σ3
/// of M, λ = σ1 + σ2 ± σ3 = max tr(Rᵀ M), with the sign of det M. With κ = (λ² - |M|²) / 2, the
/// rotation is
///
///     R = [(κ + |M|²) M + λ cof M - M Mᵀ M] / (κ λ - det M)
///
/// These formulas also hold for rank-2 matrices (σ3 = 0) and reflected ones (det M < 0). If the
/// denominator (σ1 + σ2)(σ2 ± σ3)(σ3 ± σ1) is small, nearest_rotation() is called instead.
/// Accuracy: 1e-14 for well-conditioned matrices. Cost: 15 to 30 ns per matrix. Reference:
/// [Markley1993] (FOAM).
void nearest_rotations(const RotationBatch& M, RotationBatch& R);

/// Computes the best-fitting rotations of selected triangles between the vertex positions `before`
/// and `after` (n×3 each); see rotation_of_face(). `which`: indices of the triangles. `rotations`:
/// output, one rotation per index in `which`. Costs 50 ns per triangle.
void rotations_of_triangles(std::span<const std::array<int, 3>> triangles,
                            std::span<const int> which, const Points& before, const Points& after,
                            std::span<Mat3> rotations);

// Similarity fits (Procrustes).

/// Similarity transformation x → scale · R x + translation, with a rotation R.
struct Similarity {
  double scale = 1;
  Mat3 R = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  /// Largest distance between a transformed point and its target, relative to the diagonal of the
  /// bounding box of the original points; set by fit_similarity().
  double max_error = 0;
};

/// Least-squares similarity that maps the positions `before` of the given vertices to their
/// positions `after` (n×3 each). Rotation, translation and scale are fitted. For collinear points,
/// the rotation is the smallest one between the lines before and after. If `vertices` is empty, the
/// result is the identity. O(vertices). Reference: [Umeyama1991].
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices);
/// Least-squares similarity with a prescribed scale that maps the positions `before` of the given
/// vertices to their positions `after` (n×3 each).
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale);
/// Weighted least-squares similarity with a prescribed scale that maps the positions `before` of
/// the given vertices to their positions `after` (n×3 each). `weights`: one per given vertex,
/// non-negative, not all of them 0.
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale,
                          const std::vector<double>& weights);

}  // namespace batten
