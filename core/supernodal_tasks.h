// The steps of a numeric factorization, for several threads. Internal.
#pragma once

#include <vector>

#include "batten/core/supernodal_solve.h"

namespace batten {

/// What one thread does at a time: whole supernodes one after the other, or a step of one large
/// supernode. Rows and columns are counted within the supernode.
struct FactorTask {
  enum class Step { factor_supernode, assemble, update, triangle, rows, done };
  Step step;
  int supernode, end_supernode;
  int first_row = 0, end_row = 0;        // update, rows
  int first_column = 0, end_column = 0;  // triangle, rows
  int pending_count = 0;                 // for so many other tasks
  std::vector<int> next = {};            // tasks that wait for this one
};

/// The tasks in an order in which each comes after those that it waits for, so that threads which
/// take them one after the other never wait for a task that nobody has. Work is cut where
/// partition_elimination_tree cuts the elimination tree, by `flops` of each supernode; a piece of one large
/// supernode becomes a task for each 96 rows, of its updates and of each 96 columns. Depends on the
/// pattern alone. O(supernodes) and a little for each task.
std::vector<FactorTask> plan_factorization(const SupernodalPattern& pattern,
                                           const std::vector<int>& parents,
                                           const std::vector<long>& flops);

}  // namespace batten
