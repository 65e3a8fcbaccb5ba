// Dense blocks of a Cholesky factorization: products, pivots, and the rows below them. Internal.
#pragma once

namespace batten {

/// Blocks are stored column by column, `stride` numbers from one column to the next. Every entry is
/// the sum of its products in ascending order of k, one after the other, in whichever tile of a
/// block it is computed: how rows are split among threads does not change a bit.
///
/// Tiles of 24×8 numbers (12×4 in 256 bits, 6×4 in 128) stay in registers. Rows that do not fill a
/// register are copied to `scratch`, which has room for scratch_size numbers of the deepest block:
/// nothing is read or written but the block itself.
constexpr long scratch_size(long columns) { return 8 * columns; }

/// A product of two sets of rows of one block, added to rows and columns of another.
struct ScatteredProduct {
  const double* a;              // the first of the rows i
  const double* b;              // the first of the rows j
  long stride, depth;           // of the block they are in
  int rows, columns;            // how many i and j
  const int* row_positions;     // where each i belongs in c, ascending
  const int* column_positions;  // where each j belongs in c, ascending
  double* c;
  long c_stride;
};

/// c(place of i, place of j) -= Σ_k a(i, k) b(j, k). Of c's lower triangle; above it anything may
/// be left.
void subtract_product(const ScatteredProduct& product, double* scratch);

/// Rows and columns first … end-1 of `block` become those of L in L Lᵀ, the columns before them
/// being L's already. Returns the first column whose pivot is not positive, or -1; what follows
/// such a pivot is left unfinished.
int factor_triangle(double* block, long stride, int first, int end, double* scratch);

/// The columns first … end-1 of some rows below that triangle become those of L. end - first is at
/// most kBlockColumns.
void solve_rows(double* block, long stride, int first_row, int end_row, int first, int end,
                double* scratch);

/// Columns that are finished together: 24 rows of them stay in the first cache.
inline constexpr int kBlockColumns = 96;

}  // namespace batten
