// SPDX-License-Identifier: MPL-2.0
// Inner loops of the supernodal Cholesky solver: dense blocks of the factorization, and panels of the
// triangular solves.
#pragma once

namespace batten {

// Factorization: products, pivots and solves of dense blocks.

/// Number of doubles that `scratch` must hold for a block with `columns` columns.
///
/// Blocks are stored by columns, with `stride` doubles from one column to the next. Every entry is
/// the sum of its products in ascending order of k, in whichever tile of a block it is computed.
/// The result therefore does not depend on how the rows are divided among threads, to the last bit.
///
/// Tiles of 24×8 entries (12×4 with 256-bit vectors, 6×4 with 128-bit ones) are kept in registers.
/// Rows that do not fill a register are copied to `scratch`, so that nothing outside of the block
/// is read or written.
constexpr long scratch_size(long columns) { return 8 * columns; }

/// Product of two sets of rows of one block, subtracted from scattered rows and columns of another
/// block.
struct ScatteredProduct {
  const double* a;              // first of the rows i
  const double* b;              // first of the rows j
  long stride, depth;           // stride and number of columns of their block
  int rows, columns;            // number of rows i and of rows j
  const int* row_positions;     // row of each i in c, ascending
  const int* column_positions;  // column of each j in c, ascending
  // Target block and its stride.
  double* c;
  long c_stride;
};

/// Subtracts the product: c(row of i, column of j) -= Σ_k a(i, k) b(j, k). Only the lower triangle
/// of c is meaningful; entries above it may receive any value.
void subtract_product(const ScatteredProduct& product, double* scratch);

/// Computes rows and columns first … end-1 of the Cholesky factor L in place; the columns before
/// `first` must already be those of L. Returns the first column whose pivot is not positive, or -1.
/// The columns after such a pivot are not finished.
int factor_triangle(double* block, long stride, int first, int end, double* scratch);

/// Computes the columns first … end-1 of L for the rows first_row … end_row-1 below that triangle.
/// end - first is at most kBlockColumns.
void solve_rows(double* block, long stride, int first_row, int end_row, int first, int end,
                double* scratch);

/// Number of columns that are computed together: 24 rows of them fit in the L1 cache.
inline constexpr int kBlockColumns = 96;

// Triangular solves: panels of eight rows times rows of right-hand sides.

/// Rows of a panel: the number of vectors for which every machine has enough registers.
inline constexpr int kPanelRows = 8;

/// One row of the work vector: 4 or 8 right-hand sides side by side.
using Row4 = double __attribute__((vector_size(32)));
using Row8 = double __attribute__((vector_size(64)));

/// Packed supernodes. The block of a supernode with w columns and r rows is a sequence of panels,
/// each stored by columns.
///
/// The panels of its triangle come first: 8 rows, and the columns up to the panel's own diagonal,
/// which stores the inverses of L's diagonal entries. The panels of the r - w rows below follow,
/// with 8 rows and w columns each. The last panel of either part has the remaining rows.
struct PackedSupernodes {
  const int* columns;     // first column of each supernode, then n
  const int* row_starts;  // offsets in targets; a supernode's own rows come first
  const long* starts;     // offset of each block in values
  const int* targets;     // position of each row in the work vector; own columns are at their index
  const double* values;
};

/// Packs a column-major block (lower triangle on top of full rows) into panels at `to` and returns
/// the end of the packed data. Entries above the diagonal within a panel are never used.
double* pack_supernode(const double* block, long rows, long columns, double* to);

/// Forward sweep: x := L⁻¹ x for the columns of supernodes first … end-1, and subtracts their
/// products from the rows below. `visit`: flag per supernode, or null to visit all. Memory is read
/// upwards.
void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row4* work);
void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row8* work);

/// Backward sweep: x := L⁻ᵀ (x - products with the rows below), from supernode end-1 down to first.
/// Memory is read strictly downwards, because hardware prefetchers follow only accesses in one
/// direction.
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit, Row4* work);
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit, Row8* work);

}  // namespace batten
