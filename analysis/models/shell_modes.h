// Natural frequencies, mode shapes and linear buckling of a shell.
#pragma once

#include <vector>

#include "batten/analysis/models/shell_model.h"

namespace batten {

/// Natural vibration modes of a shell, lowest frequency first.
struct ShellModes {
  VecX frequencies;            ///< in 1/time: Hz if the unit of time is the second
  std::vector<Points> shapes;  ///< mass-normalised mode shapes (n×3): Σ over x, y, z of qᵀ M q = 1
  int rigid_body_count = 0;  ///< number of leading rigid-body modes (unsupported shell)
};

/// Computes the lowest `count` natural frequencies and modes, K q = (2π f)² M q, in addition to
/// rigid-body modes. For an unsupported shell (ShellModel::RigidBodyHandling::Shifted), the latter
/// come first.
///
/// Uses the implicitly restarted Lanczos iteration of Spectra in shift-and-invert mode: about
/// 3 · count solves with the factor of the shell. Throws InputError if a section has no density, or
/// if count is not positive or at least half of the unknowns; NoSolutionError if the iteration does
/// not converge.
ShellModes natural_modes(const ShellModel& shell, int count);

/// Load factors at which a shell buckles, smallest first.
struct ShellBuckling {
  /// Multiples of the load; fewer than requested if the others are negative.
  VecX factors;
  std::vector<Points> shapes;  ///< buckling modes (n×3); the largest displacement is 1 model unit
};

/// Linear buckling under the load whose displacement is q = shell.solve(F): solves (K + λ G(q))
/// u = 0 for the smallest λ > 0, with G from ShellAssembler::geometric_stiffness(). Bending
/// prestress and displacements before buckling are neglected. `count`: number of load factors.
/// Throws InputError for an invalid count, as natural_modes() does.
ShellBuckling buckling(const ShellModel& shell, const Points& q, int count);

}  // namespace batten
