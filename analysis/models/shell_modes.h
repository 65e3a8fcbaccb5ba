// Natural frequencies and buckling loads of a shell.
#pragma once

#include <vector>

#include "batten/analysis/models/shell_model.h"

namespace batten {

/// Ways in which a shell vibrates, slowest first.
struct ShellModes {
  VecX frequencies;            ///< 1/time: Hz, where the unit of time is the second
  std::vector<Points> shapes;  ///< displacements (n×3) of mass 1: Σ over x, y, z of qᵀ M q
  int rigid_body_count = 0;    ///< of them: motions without strain, of a shell that is not held
};

/// K q = (2π f)² M q for the lowest `count` frequencies, besides rigid motions: those of a shell that
/// is not held (ShellModel::Free::Shifted) come first. Lanczos
/// iteration by Spectra on the inverse (shift and invert, implicitly restarted): some 3 · count
/// solves with the shell's factor. Throws InputError: no density in some section, count not above 0
/// or half of the unknowns; NoSolutionError when the iteration does not end.
ShellModes natural_modes(const ShellModel& shell, int count);

/// Load factors at which a shell buckles, smallest first.
struct ShellBuckling {
  VecX factors;                ///< of the load; fewer than asked for where the others are negative
  std::vector<Points> shapes;  ///< displacements (n×3), the largest of 1 model unit
};

/// Linear buckling under the load whose displacement is q = shell.solve(F): (K + λ G(q)) u = 0 for
/// the smallest λ > 0, where G is ShellAssembler::geometric_stiffness(). Prestress by bending does not
/// count, nor what the shell moved before. Throws InputError for a count as above.
ShellBuckling buckling(const ShellModel& shell, const Points& q, int count);

}  // namespace batten
