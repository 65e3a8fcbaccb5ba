// Dense block operations of the supernodal Cholesky factorization: products, pivots, and solves.
#pragma once

namespace batten {

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

}  // namespace batten
