// SPDX-License-Identifier: MPL-2.0
// Rotations of form features at which the moments on them vanish.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "batten/core/anderson_accelerator.h"
#include "batten/core/eigen.h"
#include "batten/mesh/deform/form_feature_deformer.h"

namespace batten {

/// Finds the rotations of form features that the surface around them determines: those at which the
/// moments M_f of the forces of the surface on each rigid feature vanish
/// (FormFeatureDeformer::feature_moments()). A feature then rotates like a rigid part that is welded
/// into an elastic sheet.
///
/// Newton's method for the rotations R_f. With S, v, w, H and n of
/// FormFeatureDeformer::feature_stiffness() and the first moments T_f of the forces,
///
///     K ω = -M,   R_f ← exp(ω_f) R_f
///     K_fh = tr(Q) I - Qᵀ + δ_fh (T_f - tr(T_f) I) + Σ_kl (R_f w_kf × n_k) H_kl (R_h v_lh × n_l)ᵀ
///     Q    = R_f S_fh R_hᵀ
///
/// K differs from the derivative of M by terms of the order of the curvature of the rotation field:
/// the error decreases by a factor of about 100 per step. If the symmetric part of K is not positive
/// definite, the terms of T_f are left out, and only that part is used, so that the steps descend
/// towards a stable equilibrium. Directions without stiffness, such as the axis of vertices on a
/// straight line, are left as they are. If there are more bodies than feature_stiffness() couples, K
/// is block diagonal, the steps are damped, and Anderson acceleration couples them.
class FeatureEquilibrium {
 public:
  /// Computes the stiffness. `deformer`: its last deform() had an estimate with rotations of the
  /// features. `body`: see FormFeatureDeformer::feature_stiffness(). Cost: that of
  /// feature_stiffness().
  FeatureEquilibrium(FormFeatureDeformer& deformer, std::vector<int> body);
  const std::vector<int>& body() const { return body_; }
  /// Forgets earlier steps, so that the next ones do not depend on them.
  void reset() { accelerator_.reset(); }

  /// One step: changes the rotations in `estimate`, with which the last solution of `deformer` was
  /// computed, of the features that belong to a body. Returns the largest angle of a step in degrees;
  /// 0: there is no body. Cost: O(m³) for m bodies, at most 256, and O(m) for more.
  double rotate_features(FormFeatureDeformer& deformer, ShapeEstimate& estimate);

 private:
  void linearize(FormFeatureDeformer& deformer, const ShapeEstimate& estimate);
  void find_free_directions();
  /// Replaces -M of `count` coupled bodies by their step.
  void solve(long first, long count);
  void solve_unsymmetric(const Eigen::Ref<const MatX>& K, Eigen::Ref<VecX> step);
  void add_moments(long body, double sign);
  auto diagonal_block(long body) { return K_.block<3, 3>(3 * body, is_coupled() ? 3 * body : 0); }
  const Mat3& rotation(const ShapeEstimate& estimate, long body) const {
    return *estimate.feature_rotations[member_[body]];
  }
  bool is_coupled() const { return stiffness_.S.cols() == stiffness_.S.rows(); }
  void add_point_constraints(const ShapeEstimate& estimate);

  std::vector<int> body_;    // per feature, or -1
  std::vector<int> member_;  // the first feature of each body
  FeatureStiffness stiffness_;
  MatX K_, movements_, constraint_moments_;  // columns R v_k × n_k and R w_k × n_k
  Points moments_;                           // first moments of the bodies, stacked
  VecX step_;                                // -M, then ω
  // Per body: the projection onto the axes with stiffness, in the undeformed shape and in the current
  // one, and the mean stiffness.
  std::vector<Mat3> free_directions_, rotated_directions_;
  std::vector<double> mean_stiffness_;
  MatX symmetric_;
  Eigen::LLT<MatX> factor_;
  AndersonAccelerator accelerator_;
  Points before_, after_, accelerated_;  // stacked rotation matrices of the bodies
};

}  // namespace batten
