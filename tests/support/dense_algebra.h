// Dense algebra by Eigen itself, for tests that write a problem down again. Its decompositions are compiled
// once here: in each test they would take seconds.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// x of A x = b, by an LU decomposition with full pivoting.
MatX solve_dense(const MatX& A, const MatX& b);
/// x of A x = b with a symmetric A, by LDLᵀ.
MatX solve_symmetric(const MatX& A, const MatX& b);
/// Orthonormal columns that span what C maps to zero.
MatX null_space(const MatX& C);

}  // namespace batten
