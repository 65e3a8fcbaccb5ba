// SPDX-License-Identifier: MPL-2.0
// Static analysis of a free shell by inertia relief.
#pragma once

#include <vector>

#include "batten/analysis/shell_assembler.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Inertia relief: the static response of a shell without supports. The loads F accelerate the shell
/// as a rigid body; the inertia forces of this motion balance them,
///
///     F' = F - M R a,   a = (Rᵀ M R)⁻¹ Rᵀ F,
///
/// with the six rigid-body displacements R and the mass matrix M. The balanced loads are applied to
/// the shell on statically determinate supports, whose reactions are zero. Of the displacement, the
/// rigid-body part is removed: it is orthogonal to R in the inner product of M.
class InertiaRelief {
 public:
  /// `shape`: absolute dofs of the middle surface; `mass`: mass matrix of one coordinate (lower
  /// triangle, n×n). Throws InputError if the mass is zero.
  InertiaRelief(const ModelLayout& model, const Points& shape, const SparseMatrix& mass);

  /// The balanced loads F' (n×3).
  Points balanced(const Points& F) const;
  /// A displacement (n×3) without its rigid-body part.
  Points without_rigid_motion(const Points& q) const;

 private:
  VecX moments(const Points& F) const;        // Rᵀ F
  std::vector<Points> R_, MR_;                // n×3 each
  Eigen::Matrix<double, 6, 6> inverse_mass_;  // (Rᵀ M R)⁻¹
};

}  // namespace batten
