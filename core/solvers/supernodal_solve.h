// SPDX-License-Identifier: MPL-2.0
// Triangular solves with a supernodal Cholesky factor, limited only by memory bandwidth.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/solvers/supernodal_factor.h"

namespace batten {

/// In-place solution of A x = b with the factor A = Pᵀ L Lᵀ P, for any number of right-hand sides.
/// P is the permutation of the unknowns.
///
/// A solve reads every entry of L twice and does very little arithmetic with it, so memory
/// bandwidth limits its speed. Four techniques reach that limit (measurements in
/// docs/theory/solver.md):
///
/// - Each row of x holds 4 (or 8) right-hand sides side by side in one vector register.
/// - Blocks are repacked in panels of 8 rows, stored by columns, without gaps between blocks. In
///   both sweeps, eight registers hold the rows of a panel, and L is read as one contiguous stream.
/// - The backward sweep reads that stream strictly from end to start, because hardware prefetchers
///   follow only accesses in one direction.
/// - The elimination tree is partitioned into chunks. A chunk adds to its own unknowns and, for
///   unknowns of its ancestors, to a small vector of its own, which the parent chunk accumulates in
///   a fixed order. Chunks of different subtrees can run on different threads, and results are
///   bit-identical for any number of threads.
///
/// Solves poll the current ProgressScope in each chunk and throw CancelledError after the sweeps; x
/// is then undefined.
///
/// Not thread-safe: an object owns the work vectors of one solve. References: supernodes and
/// elimination tree [NgPeyton1993], [Davis2006] chapter 4; accumulation in the parent
/// (multifrontal method) [DuffReid1983].
class SupernodalSolve {
 public:
  SupernodalSolve() = default;

  /// Prepares solves for `pattern`. `order`: the unknown of each row of L. Supernodes must be in a
  /// postorder of their elimination tree. Cost: O(rows of the pattern). Allocates what solve()
  /// needs for 4 right-hand sides.
  SupernodalSolve(const SupernodalPattern& pattern, const int* order);

  /// Repacks the blocks in place and uses them in later solves; afterwards `values` no longer has
  /// the layout of the factor. The values must have the pattern of the constructor and outlive the
  /// solves. Cost: one read and one write of the factor.
  void pack(double* values);

  /// Solves in place: x holds b on entry and the solution on return. Right-hand sides are processed
  /// in groups of 8 and 4. Allocates memory only in the first solve with more than 4 columns.
  void solve(Eigen::Ref<MatX> x) const;

  /// Supernodes that a partial solve visits if b is zero outside of the rows `nonzero` and only the
  /// rows `wanted` of x are needed (no list: all rows). The forward sweep visits the supernodes of
  /// `nonzero` and their ancestors, the backward sweep those of `wanted` and their ancestors.
  /// Throws InputError if a row is out of range.
  SolveSubset subset(const std::optional<std::vector<int>>& nonzero,
                     const std::optional<std::vector<int>>& wanted) const;

  /// Partial solve restricted to `subset`. x must be zero outside of the rows `nonzero`; on return,
  /// rows outside of `wanted` are unspecified. Throws InputError if the subset belongs to another
  /// pattern.
  void solve(const SolveSubset& subset, Eigen::Ref<MatX> x) const;

  /// Entries of L that one sweep reads: the lower triangles and the rows below.
  long entries() const { return entries_; }
  /// Number of chunks into which the elimination tree is partitioned.
  int chunk_count() const { return isize(chunks_); }
  /// Number of threads for a solve whose sweeps read `entries` entries each. It is one if the work
  /// is too small or the tree has too few branches, and never more than the number of cores.
  int threads_for(long entries) const;

 private:
  // Part of the elimination tree: a connected block, or neighbouring subtrees. It consists of
  // consecutive supernodes, the columns that they own, and the rows of ancestors that they change
  // (the boundary), which are stored in the chunk's section of the work vector.
  struct Chunk {
    int first_supernode, end_supernode;
    int first_column, end_column;
    int first_boundary, end_boundary;
    int first_child, end_child;  // in children_
    int parent;                  // chunk, or -1
  };

  void partition_into_chunks();
  void link_chunks(const std::vector<long>& sizes);
  void find_boundaries(const int* rows);
  long block_entries(int s) const;
  void allocate_workspace(int lanes) const;
  void solve_subset(const SolveSubset* subset, Eigen::Ref<MatX> x) const;
  template <class Row>
  class GroupSolve;
  template <class Row>
  void solve_group(const SolveSubset* subset, double* x, long stride, int columns) const;

  int n_ = 0;
  long entries_ = 0, analysis_ = 0;
  std::vector<int> order_;  // unknown of each row of L
  std::vector<int> columns_, row_starts_, value_starts_;
  std::vector<long> packed_starts_;
  std::vector<int> parents_;  // parent of each supernode, or -1
  std::vector<int> targets_;  // position of each row of a supernode in the work vector
  std::vector<Chunk> chunks_;
  std::vector<int> children_;
  // Position of each boundary row in the parent chunk's section.
  std::vector<int> boundary_targets_;
  std::vector<int> schedule_;  // chunks, the deepest first
  bool splits_ = false;        // whether subtrees are worth several threads
  const double* values_ = nullptr;
  mutable std::unique_ptr<double[]> work_;  // one Row for each column and boundary row
  mutable int work_lanes_ = 0;
  // Unfinished chunks that each chunk waits for.
  mutable std::unique_ptr<std::atomic<int>[]> pending_;
};

// Partition of the elimination tree for several threads.

/// Consecutive supernodes that are processed by one thread: a connected block of the tree, or
/// neighbouring subtrees with the same parent block.
struct TreeBlock {
  int first, end;  ///< supernodes first … end-1
  long entries;    ///< entries of L in them
  bool subtree;    ///< true if no block is below it
};

/// Partitions the elimination tree into blocks, children before parents. `parents`: parent of each
/// supernode, or -1; `columns`: first column of each supernode, then n; `entries`: entries of L (or
/// another measure of work) in each supernode. There are three steps:
///
/// 1. Measure: compute the total work of the subtree below each supernode.
/// 2. Gather: a subtree that is small enough becomes one block. A supernode above such subtrees is
///    a block of its own, which absorbs the small blocks right before it. Along a spine (one large
///    child with small siblings), it also absorbs the block of that child.
/// 3. Merge neighbouring subtrees with the same parent block.
///
/// The result depends on the tree only, not on the number of threads. Cost: O(supernodes).
std::vector<TreeBlock> partition_elimination_tree(const std::vector<int>& parents,
                                                  const std::vector<int>& columns,
                                                  const std::vector<long>& entries);

}  // namespace batten
