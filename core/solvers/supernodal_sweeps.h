// The inner loops of the triangular solves: panels of eight rows against rows of right-hand sides.
#pragma once

namespace batten {

/// Rows of a panel: as many vectors as every machine has registers for.
inline constexpr int kPanelRows = 8;

/// One row of the work vector: 4 or 8 right-hand sides side by side.
using Row4 = double __attribute__((vector_size(32)));
using Row8 = double __attribute__((vector_size(64)));

/// Packed supernodes. The block of a supernode with w columns and r rows is a sequence of panels,
/// each stored column by column: first those of its triangle, 8 rows and as many columns as reach
/// to the panel's own diagonal (which holds the inverses of L's diagonal), then those of the r - w
/// rows below, 8 rows and w columns. The last panel of each part has the rows that are left.
struct PackedSupernodes {
  const int* columns;     // first column of each, and n
  const int* row_starts;  // into targets; a supernode's own rows come first
  const long* starts;     // of each block in values
  const int* targets;     // place of each row in the work vector; own columns are at their number
  const double* values;
};

/// Writes the column-major block (lower triangle on top of full rows) as panels; returns the end.
/// What stands above the diagonal within a panel is never used.
double* pack_supernode(const double* block, long rows, long columns, double* to);

/// x := L⁻¹ x for the columns of supernodes first … end-1, and minus their products for the rows
/// below. `visit`: the supernodes to visit, or null for all. Upwards through memory.
void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row4* work);
void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row8* work);

/// x := L⁻ᵀ (x - products with the rows below), from supernode end-1 to first. Downwards through
/// memory, strictly: processors read ahead only of a walk that keeps its direction.
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit, Row4* work);
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit, Row8* work);

}  // namespace batten
