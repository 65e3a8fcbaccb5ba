// SPDX-License-Identifier: MPL-2.0
// Dense linear algebra of Eigen for reference implementations. Its decompositions are compiled once
// here: in each test they would take seconds.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Solves A x = b by an LU decomposition with full pivoting.
MatX solve_dense(const MatX& A, const MatX& b);
/// An orthonormal basis of the null space of C, as columns.
MatX null_space(const MatX& C);

}  // namespace batten
