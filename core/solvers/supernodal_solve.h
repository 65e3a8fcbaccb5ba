// Triangular solves with a supernodal Cholesky factor at the speed of memory.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"
#include "batten/core/solvers/symbolic_analysis.h"

namespace batten {

/// Where the numbers of a factor L are. A supernode is a run of columns with the same rows below
/// them, stored as one dense block, column by column: its own columns (a lower triangle, what is
/// above the diagonal is not read) and then the rows below.
struct SupernodalPattern {
  int count = 0;                      // of supernodes
  const int* columns = nullptr;       // count+1: the first column of each, and n
  const int* row_starts = nullptr;    // count+1: where its rows start in `rows`
  const int* rows = nullptr;          // ascending in each supernode; its own columns come first
  const int* value_starts = nullptr;  // count+1: where its block starts in the values
};

/// x with L Lᵀ x = b, in place, for any number of right-hand sides; P the order of the unknowns:
/// what is solved is A x = b with Pᵀ-permuted rows, A = Pᵀ L Lᵀ P.
///
/// The solve reads every entry of L twice and does next to nothing with it, so it is as fast as
/// memory is read. Four things bring it there (docs/theory/solver.md has the measurements):
///
/// - each row of x holds 4 (or 8) right-hand sides side by side, one vector register;
/// - blocks are repacked in panels of 8 rows, column by column, and moved together: in both sweeps
///   eight registers take a panel's rows and L is one stream without gaps;
/// - the backward sweep walks that stream strictly from its end to its start, because a processor
///   reads ahead only of a walk that keeps one direction;
/// - the elimination tree is cut in chunks. A chunk adds to its own unknowns and, for the unknowns
///   of its ancestors, to a small vector of its own, which the chunk above collects in a fixed
///   order: chunks of different subtrees go to different threads, and the bits are the same on one
///   thread as on many.
///
/// Not for several threads at once: it owns the vectors of one solve.
/// Source of supernodes and tree: Ng, Peyton 1993; Davis, Direct Methods for Sparse Linear Systems,
/// 2006, chapter 4. Collecting in the parent: the multifrontal method, Duff, Reid 1983.
class SupernodalSolve {
 public:
  SupernodalSolve() = default;

  /// `order`: the unknown behind each row of L. Supernodes must be in a postorder of their tree.
  /// O(rows of the pattern). Allocates what solve() needs for 4 right-hand sides.
  SupernodalSolve(const SupernodalPattern& pattern, const int* order);

  /// Repacks the blocks in place: the values are no longer the factor's own layout. The values have
  /// the pattern of the constructor; they must outlive the solves. One read and one write of the
  /// factor.
  void pack(double* values);

  /// x = b on entry, the solution on return. Right-hand sides go through in groups of 8 and 4.
  /// Allocates nothing, except for the first solve of more than 4.
  void solve(Eigen::Ref<MatX> x) const;

  /// What a solve needs when b is zero outside the rows `nonzero` and only the rows `wanted` of x
  /// are of interest (nothing given: all rows). Forward: the supernodes of `nonzero` and their
  /// ancestors; backward: those of `wanted` and their ancestors. InputError: no such row.
  SolveSubset subset(const std::optional<std::vector<int>>& nonzero,
                     const std::optional<std::vector<int>>& wanted) const;

  /// The same solve, through that part only. x must be zero outside of the part's `nonzero`; what
  /// it holds outside of `wanted` afterwards is unspecified. InputError: a part of another pattern.
  void solve(const SolveSubset& subset, Eigen::Ref<MatX> x) const;

  /// Entries of L that a sweep reads: the lower triangles and the rows below.
  long entries() const { return entries_; }
  int chunk_count() const { return isize(chunks_); }
  /// Threads that a solve uses which reads so many entries in each sweep: one unless they and the
  /// tree are worth more, never more than cores.
  int threads_for(long entries) const;

 private:
  // A connected piece of the tree, or neighbours in it: consecutive supernodes, the columns they
  // own, and the rows of ancestors that they change, kept in the chunk's stretch of the work
  // vector.
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
  std::vector<int> order_;  // unknown of each row
  std::vector<int> columns_, row_starts_, value_starts_;
  std::vector<long> packed_starts_;
  std::vector<int> parents_;  // supernode above each, or -1
  std::vector<int> targets_;  // place of each row of a supernode in the work vector
  std::vector<Chunk> chunks_;
  std::vector<int> children_;
  std::vector<int> boundary_targets_;  // place of each boundary row in the parent chunk's part
  std::vector<int> schedule_;          // chunks, the deepest first
  bool splits_ = false;                // are there subtrees for two threads?
  const double* values_ = nullptr;
  mutable std::unique_ptr<double[]> work_;  // a row of lanes for each column and boundary row
  mutable int work_lanes_ = 0;
  mutable std::unique_ptr<std::atomic<int>[]> pending_;  // of each chunk: what it waits for
};


// Cuts the elimination tree of a factor in pieces for several threads. Internal.

/// Consecutive supernodes that one thread takes: a connected piece of the tree, or neighbouring
/// subtrees under the same piece.
struct TreeBlock {
  int first, end;  ///< supernodes
  long entries;    ///< of L, in its blocks
  bool subtree;    ///< no piece is below it
};

/// The pieces, children before parents. `parents`: supernode above each, or -1; `columns`: first
/// column of each, and n; `entries`: of each block. In three steps:
///
///     1. measure: what hangs below each supernode
///     2. gather: a subtree that is small enough becomes one piece. A supernode above such subtrees
///        is a piece of its own, which takes in the little pieces right before it, and along a
///        spine (one large child, little ones beside it) also the piece of that child
///     3. join neighbouring subtrees under the same piece
///
/// Depends on the tree alone, not on the number of threads. O(supernodes).
std::vector<TreeBlock> partition_elimination_tree(const std::vector<int>& parents,
                                                  const std::vector<int>& columns,
                                                  const std::vector<long>& entries);

}  // namespace batten
