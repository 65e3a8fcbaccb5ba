// The reduced least-squares problem. Internal.
#pragma once

#include "batten/constraints/affine_reduction.h"
#include "batten/mesh/deform/deform_system.h"

namespace batten {

/// The matrix B = A D, by rows.
RowMatrix reduced_matrix(const RowMatrix& A, const AffineReduction& reduction);

/// Lower triangle of Bᵀ B, column by column: for each row that meets the column, its entries from
/// there on. `rows` is B by rows. On all cores, the same bits on one.
SparseMatrix normal_matrix(const SparseMatrix& B, const RowMatrix& rows);

}  // namespace batten
