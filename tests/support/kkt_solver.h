// The saddle point twin of the reduction, apart from it so that they share no code.
#pragma once

#include "batten/constraints/affine_reduction.h"

namespace batten {

/// The system [K Cᵀ; C 0] by sparse LU. Rows must be independent. Throws NoSolutionError when it is
/// singular. K is n×n, or 3n×3n over [x; y; z] of a coupled set.
Points solve_kkt(const ConstraintSet& set, const SparseMatrix& K, const Points& F);

}  // namespace batten
