// Rotations and similarities fitted to deformations: polar decomposition, rotation of a face, means
// of rotations, Procrustes fits.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Rotation nearest to a matrix (orthogonal Procrustes problem).
///
/// It maximises tr(Rᵀ M) over R with det R = +1. With the SVD M = P Σ Qᵀ, R = P diag(1, 1, det P
/// det Qᵀ) Qᵀ; the last sign belongs to the smallest singular value. For full rank and det M > 0
/// this is the rotation of the polar decomposition. A matrix of rank 2 is completed by the normal.
/// If det M < 0, the direction of the smallest singular value is flipped. For rank 1 the result is
/// the smallest rotation between the two lines, for rank 0 or non-finite entries the identity. The
/// result is never a reflection.
///
/// Accuracy: about 1e-16 divided by the gap of the singular values, 4e-16 for well-conditioned M.
/// Cost: 0.3 µs (Newton iteration for the polar decomposition), 0.8 µs for matrices that are nearly
/// reflected or nearly of rank 1. Sources: [Higham1986] (iteration); [Umeyama1991] (sign).
Mat3 nearest_rotation(const Mat3& M);

/// Rotation of a face from `before` to `after`. Let the columns of U and U' be the corners relative
/// to their centroid, before and after:
///
///     H = U' U⁺,   R = nearest_rotation(H)
///
/// U⁺ is the pseudo-inverse. A planar face has no extent across its plane, so H has rank 2 and R
/// maps the normal to the normal. A face whose corners are collinear, before or after, gets the
/// smallest rotation of that line; one that is a point gets the identity. Singular values of U
/// below 1e-12 of the largest one count as zero. O(corners). Source: [Hu2012], section II B.
Mat3 rotation_of_face(std::span<const int> corners, const Points& before, const Points& after);

/// Deformation gradient H of a triangle, which maps its edge vectors E to F: H = F (Eᵀ E)⁻¹ Eᵀ.
/// Empty if the face is not a triangle or nearly collinear before.
std::optional<Mat3> deformation_gradient(std::span<const int> corners, const Points& before,
                                         const Points& after);

/// L2 mean of rotations: min_R Σ w_i ‖R - R_i‖² with the Frobenius norm, which is
/// nearest_rotation(Σ w_i R_i). Weights (areas, for example) must be non-negative. No rotations:
/// the identity. Throws InputError if the numbers of weights and rotations differ.
Mat3 mean_rotation(std::span<const Mat3> rotations, std::span<const double> weights);

/// L1 mean (geometric median) of rotations: min_R Σ w_i ‖R - R_i‖. It is robust: outliers with up
/// to half of the weight do not carry it away. Computed by Weiszfeld's iteration from
/// mean_rotation(): R ← mean with weights w_i / ‖R - R_i‖, which never increases the sum; distances
/// are at least 1e-12. Stops when R changes by less than 1e-14 or after 1000 iterations (a few tens
/// if most R_i are equal). Source: [Hartley2013], section 5.
Mat3 median_rotation(std::span<const Mat3> rotations, std::span<const double> weights);

// Nearest rotations of many matrices at once (SIMD).

/// Eight matrices in structure-of-arrays layout: entry (r, c) of matrix `lane` is a[3 r + c][lane].
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

/// Nearest rotation (see nearest_rotation()) of each matrix M of a batch. The largest root of
///
///     (λ² - |M|²)² - 8 λ det M - 4 |cof M|² = 0
///
/// is λ = σ1 + σ2 ± σ3 = max tr(Rᵀ M), and with κ = (λ² - |M|²) / 2
///
///     R = [(κ + |M|²) M + λ cof M - M Mᵀ M] / (κ λ - det M)
///
/// These formulas also hold for rank-2 matrices (σ3 = 0) and reflected ones (det M < 0). If the
/// denominator (σ1 + σ2)(σ2 ± σ3)(σ3 ± σ1) is small, nearest_rotation() is called instead.
/// Accuracy: 1e-14 for well-conditioned matrices. Cost: 15 to 30 ns per matrix. Source:
/// [Markley1993] (FOAM).
void nearest_rotations(const RotationBatch& M, RotationBatch& R);

/// rotation_of_face() for selected triangles of a mesh, eight at a time. `which`: triangle indices.
/// `rotations`: output, one entry per index in `which`. Costs 50 ns per triangle.
void rotations_of_triangles(std::span<const std::array<int, 3>> triangles,
                            std::span<const int> which, const Points& before, const Points& after,
                            std::span<Mat3> rotations);

// Similarity fits (Procrustes).

/// Similarity transformation x → scale · R x + translation.
struct Similarity {
  double scale = 1;
  Mat3 R = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  double max_error = 0;  ///< largest residual of the fit, relative to the box diagonal of `before`
};

/// Least-squares similarity that maps `before` to `after` on the given vertices, with det R = +1.
/// This overload also fits the scale. For collinear points R is the smallest rotation that fits;
/// without vertices the result is the identity. O(vertices). Source: [Umeyama1991].
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices);
/// The same with a prescribed scale.
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale);
/// The same with weights: one per vertex, non-negative, not all of them 0.
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale,
                          const std::vector<double>& weights);

}  // namespace batten
