// SPDX-License-Identifier: MPL-2.0
// Smooth minimisation problem of curvature fairing, which Ceres solves, and its integrands.
#pragma once

#include <vector>

#include "batten/fairing/curvature/quintic_curve.h"

namespace batten {

/// Computes the vector whose square is the integrand of the functional with respect to u.
///
/// d1, d2, d3 are X', X'', X'''. With v = |X'| and P = I - X'X'ᵀ/v²:
///
///     Energy      √v P X'' / v²                                    κN
///     Variation   √v P (X''' - 3 X'·X''/v² X'') / v³               κ'N + κτB
template <class T>
Eigen::Matrix<T, 3, 1> curvature_root(CurveFunctional functional, const Eigen::Matrix<T, 3, 1>& d1,
                                      const Eigen::Matrix<T, 3, 1>& d2,
                                      const Eigen::Matrix<T, 3, 1>& d3) {
  using std::sqrt;
  const T vv = d1.dot(d1), v = sqrt(vv);
  Eigen::Matrix<T, 3, 1> r = d2;
  T scale = sqrt(v) / vv;
  if (functional == CurveFunctional::Variation) {
    r = d3 - d2 * (T(3.0) * d1.dot(d2) / vv);
    scale /= v;
  }
  r -= d1 * (d1.dot(r) / vv);
  return r * scale;
}

/// Relative change of speed, (ln v)'; zero if the speed is uniform.
template <class T>
T speed_change(const Eigen::Matrix<T, 3, 1>& d1, const Eigen::Matrix<T, 3, 1>& d2) {
  return d1.dot(d2) / d1.dot(d1);
}

/// A minimisation problem over the dofs of `curve`, whose node parameters stay fixed:
///
///     ∫ |root|² du + length_weight ∫ |X'| du + parametrization_weight ∫ (ln |X'|)'² du
///     + Σ |S (X(at) - point)|²
///
/// where `root` is curvature_root(). Some positions are constant, and some X' have a constant
/// direction.
struct CurvatureMinimization {
  /// Term |S (X(at) - point)|².
  struct Spring {
    CurveMesh::SegmentPoint at;
    Vec3 point;
    Mat3 S;
  };
  QuinticCurve curve;
  CurveFunctional functional = CurveFunctional::Variation;
  double length_weight = 0, parametrization_weight = 0;
  /// Per node: 1 if the position, or the direction of X', is fixed.
  std::vector<char> fixed_position, fixed_tangent;
  std::vector<Spring> springs;
  int max_iterations = 0;
};

/// Solution of a CurvatureMinimization.
struct CurvatureMinimizationResult {
  Points dofs;
  int iterations = 0;
  bool converged = false;
};

/// Minimises from the dofs of `problem.curve`. Throws InputError in a build without Ceres.
CurvatureMinimizationResult minimize(const CurvatureMinimization& problem);

}  // namespace batten
