// Private to curvature fairing: the smooth problem that Ceres solves, and its densities.
#pragma once

#include <vector>

#include "batten/fairing/curvature/quintic_curve.h"

namespace batten {

/// A vector whose square is the functional's density in u, from X', X'', X''': with v = |X'| and
/// P = I - X'X'ᵀ/v²,
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

/// The relative change of speed, (ln v)' : zero where the speed is even.
template <class T>
T speed_change(const Eigen::Matrix<T, 3, 1>& d1, const Eigen::Matrix<T, 3, 1>& d2) {
  return d1.dot(d2) / d1.dot(d1);
}

/// Minimise over the dofs of `curve` (its parameters stay)
///
///     ∫ |root|² du + length_weight ∫ |X'| du + evenness ∫ (ln |X'|)'² du
///     + Σ |S (X(at) - point)|²
///
/// with some positions constant and some X' of constant direction.
struct CurvatureMinimization {
  struct Spring {
    CurveMesh::SegmentPoint at;
    Vec3 point;
    Mat3 S;
  };
  QuinticCurve curve;
  CurveFunctional functional = CurveFunctional::Variation;
  double length_weight = 0, parametrization_weight = 0;
  std::vector<char> fixed_position, fixed_tangent;  ///< what each node holds
  std::vector<Spring> springs;
  int max_iterations = 0;
};

struct CurvatureMinimizationResult {
  Points dofs;
  int iterations = 0;
  bool converged = false;
};

/// Throws InputError in a build without Ceres.
CurvatureMinimizationResult minimize(const CurvatureMinimization& problem);

}  // namespace batten
