// SPDX-License-Identifier: MPL-2.0
// Stiffness of form features against rotations.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Stiffness of rigid bodies of features against rotations, in the undeformed shape. If body h rotates
/// by ω, the moment on body f changes by K_fh ω, with
///
///     K_fh = tr(S_fh) I - S_fhᵀ + Σ_kl (w_kf × n_k) H_kl (v_lh × n_l)ᵀ,   S_fh = Σ_i c_f,i r_h,iᵀ
///
/// Column j of r_h contains the residuals A p - b if each lever c_h and each target that rotates with h
/// changes by its component j in a fixed direction, and component j of v_kh is the movement of the
/// point of equation k of the point constraints, without these constraints. A unit force n_k at this
/// point causes the moment w_kf × n_k on f. H is the inverse of the compliance of the point
/// constraints, n_k their directions.
struct FeatureStiffness {
  MatX S;     ///< up to 256 bodies: 3m×3m; more: the diagonal blocks only, approximately, 3m×3
  MatX v, w;  ///< 3m×q for q equations of point constraints
  MatX H;     ///< q×q
  std::vector<Vec3> n;
};

}  // namespace batten
