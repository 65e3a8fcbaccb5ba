// SPDX-License-Identifier: MPL-2.0
// P-norm of the von Mises stress of a shell: a smooth measure of its largest stress.
#pragma once

#include "batten/analysis/shell_assembler.h"

namespace batten {

/// P-norm of the von Mises stress over both sides of a shell, and its gradient:
///
///     σ_P = (1/(2A) ∬ (σ_top^P + σ_bottom^P) dA)^(1/P),       A = ∬ dA
///
/// In laminates, the mean is over the two faces of all plies.
/// The stresses are those of the finite element solution at the quadrature points, without recovery.
/// The norm is at most the largest of these stresses, approaches it as P increases, and is
/// differentiable where the largest stress is not. ShellStresses::peak(), which is recovered at the
/// vertices, may be smaller or larger. Reference: [Duysinx1998].
struct VonMisesNorm {
  double value = 0;  ///< force per area
  /// Derivative of `value` with respect to the displacement dofs, n×3. Zero if `value` is.
  Points gradient;
};

/// Computes the norm and its gradient for the displacement q (n×3). `exponent`: P, from 2 to 100.
/// `temperature`: that of the load case. Throws InputError for another exponent, or if q has the
/// wrong number of dofs. Cost: O(triangles), on all threads; the result does not depend on their
/// number.
VonMisesNorm von_mises_norm(const ShellAssembler& shell, const Points& q, double exponent,
                            const ShellTemperature& temperature = {});

/// Mass ∬ ρ t dA of a shell, with density ρ and thickness t. O(triangles).
double shell_mass(const ShellAssembler& shell);

}  // namespace batten
