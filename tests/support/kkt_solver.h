// SPDX-License-Identifier: MPL-2.0
// KKT reference implementation of the reduction, in a separate file: it shares no code with it.
#pragma once

#include "batten/constraints/affine_reduction.h"

namespace batten {

/// Solves the system [K Cᵀ; C 0] by a sparse LU. Constraints must be independent. Throws
/// NoSolutionError if it is singular. K is n×n, or 3n×3n over [x; y; z] of a coupled set.
Points solve_kkt(const ConstraintSet& set, const SparseMatrix& K, const Points& F);

}  // namespace batten
