// Cuts the elimination tree of a factor in pieces for several threads. Internal.
#pragma once

#include <vector>

namespace batten {

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
