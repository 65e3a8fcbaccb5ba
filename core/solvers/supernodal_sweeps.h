// Inner loops of the triangular solves: panels of eight rows times rows of right-hand sides.
#pragma once

namespace batten {

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
