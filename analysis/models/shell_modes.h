// SPDX-License-Identifier: MPL-2.0
// Natural frequencies, mode shapes and linear buckling of a shell.
#pragma once

#include <vector>

#include "batten/analysis/models/shell_model.h"

namespace batten {

/// Natural vibration modes of a shell, lowest frequency first.
struct ShellModes {
  VecX frequencies;  ///< natural frequencies, 1/time: Hz if the unit of time is the second
  std::vector<Points> shapes;  ///< mode shapes q (n×3), scaled so that tr(qᵀ M q) = 1 (M: mass)
  int rigid_body_count = 0;    ///< number of rigid-body modes, which come first
  /// Participation factors of the modes for accelerations along x, y and z: Γ = qᵀ M 1. Their
  /// squares are the effective masses, whose sums over all modes of an unconstrained direction are
  /// the mass.
  std::vector<Vec3> participation;
  double mass = 0;  ///< mass of the shell
};

/// Computes the lowest `count` natural frequencies f and modes q, K q = (2π f)² M q with the
/// stiffness matrix K and the mass matrix M. For an unsupported shell
/// (ShellModel::RigidBodyHandling::Shifted), the rigid-body modes come first, in addition to the
/// `count` modes.
///
/// Uses the implicitly restarted Lanczos iteration [Sorensen1992] of Spectra in shift-and-invert
/// mode: about 3 · count solves with the factor of the shell. Throws InputError if a section has no
/// density, or if count is not positive or at least half of the unknowns; NoSolutionError if the
/// iteration does not converge.
ShellModes natural_modes(const ShellModel& shell, int count);

/// Load factors at which a shell buckles, smallest first.
struct ShellBuckling {
  /// Factors on the load, above 0, ascending; fewer than requested if further ones are negative, and
  /// none if the shell has no membrane forces, such as a flat plate under pressure.
  VecX factors;
  std::vector<Points> shapes;  ///< buckling modes (n×3); the largest displacement is 1 model unit
};

/// Linear buckling under the load F whose displacement is q = shell.solve(F): solves (K + λ G(q)) u
/// = 0 for the smallest load factors λ > 0, with the stiffness matrix K, and G the geometric
/// stiffness (ShellAssembler::geometric_stiffness()) minus that of loads that follow the surface.
/// Bending prestress and displacements before buckling are neglected.
///
/// `q`: displacement dofs, n×3, model units. `count`: number of load factors. `follower`:
/// follower_stiffness() of the load F; empty: dead loads. `temperature`: that of the load case. Throws InputError for an invalid count,
/// and NoSolutionError, as natural_modes() does. Cost: as natural_modes(); twice as much if no
/// positive load factor exists.
ShellBuckling buckling(const ShellModel& shell, const Points& q, int count,
                       const SparseMatrix& follower = {}, const ShellTemperature& temperature = {});

}  // namespace batten
