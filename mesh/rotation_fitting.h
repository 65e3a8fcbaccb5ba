// The rotation of a face between two shapes of a mesh, and means of rotations.
#pragma once

#include <optional>
#include <span>
#include <vector>
#include <array>

#include "batten/core/eigen.h"

namespace batten {

/// The rotation that M has the largest share of: max tr(Rᵀ M) over R with det R = +1.
///
/// With M = P Σ Qᵀ it is R = P diag(1, 1, det P det Qᵀ) Qᵀ, the last sign with the smallest singular
/// value: M = H of full rank and det H > 0 gives its polar part; a flat M (rank 2) is completed by
/// the normal; of a mirrored one the weakest direction is turned back. Of rank 1 the smallest
/// rotation between the two lines; of rank 0 the identity. Never a reflection.
///
/// Exact to about 1e-16 over the gap of the singular values, 4e-16 where M is well shaped. 0.3 µs
/// (a Newton iteration for the polar part), 0.8 µs for what is nearly mirrored or of rank 1.
/// Source: Higham 1986 (the iteration); Umeyama 1991 (the sign).
Mat3 nearest_rotation(const Mat3& M);

/// The rotation of a face from `before` to `after`: with the corners relative to their mean, u_j and
/// u'_j as columns of U and U',
///
///     H = U' U⁺,   R = nearest_rotation(H)
///
/// U⁺ is the pseudo-inverse. A plane face has no direction across it, so H has rank 2 and the normal
/// goes to the normal. A face whose corners lie on one line, before or after, turns by the smallest
/// rotation of that line; one that lies in a point does not turn. Directions of the face that are
/// below 1e-12 of its longest count as none. O(corners). Source: Hu, Song, Cao, section II B.
Mat3 rotation_of_face(std::span<const int> corners, const Points& before, const Points& after);

/// H of a triangle that is not nearly a line: edges go to edges, E and F their columns, so H = F (Eᵀ
/// E)⁻¹ Eᵀ. None for others.
std::optional<Mat3> deformation_gradient(std::span<const int> corners, const Points& before,
                                         const Points& after);

/// min_R Σ w_i ‖R - R_i‖² over rotations, ‖·‖ Frobenius: nearest_rotation(Σ w_i R_i). Weights are areas,
/// 0 or more; no rotations: the identity. Throws InputError when there are not as many weights.
Mat3 mean_rotation(std::span<const Mat3> rotations, std::span<const double> weights);

/// min_R Σ w_i ‖R - R_i‖: the unsquared norm, which up to half of the weight anywhere else does not
/// carry away. Weiszfeld's iteration from the mean above: R ← mean of weights w_i / ‖R - R_i‖, which
/// never raises the sum; distances count as 1e-12 at least. Ends when R moves by less than 1e-14 or
/// after 1000 rounds (where most R_i are one rotation it ends there after a few tens). Source:
/// Hartley, Trumpf, Dai, Li 2013, section 5.
Mat3 median_rotation(std::span<const Mat3> rotations, std::span<const double> weights);


// Rotation parts of many matrices at once.

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


// The best similarity between two shapes of the same points.

/// x → scale · R x + shift.
struct Similarity {
  double scale = 1;
  Mat3 R = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  double max_error = 0;  ///< largest distance left, over the size (box diagonal) of the first shape
};

/// Least-squares similarity from `before` to `after` on the given vertices, det R = +1. The scale
/// is fitted unless given. Source: Umeyama 1991. For points on one line R is the
/// smallest of the rotations that fit. O(vertices).
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices);
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale);
/// `weights`: one for each of the vertices, at least 0, not all of them 0.
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale,
                          const std::vector<double>& weights);

}  // namespace batten
