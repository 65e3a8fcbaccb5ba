// SPDX-License-Identifier: MPL-2.0
// Numeric supernodal Cholesky factorization on several cores.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/supernodal_solve.h"

namespace batten {

// Tasks of a parallel numeric factorization.

/// Unit of work of one thread: several whole supernodes one after the other, or one step of a large
/// supernode. Row and column indices are relative to the supernode.
struct FactorTask {
  enum class Step { factor_supernode, assemble, update, triangle, rows, done };
  Step step;
  int supernode, end_supernode;
  int first_row = 0, end_row = 0;        // for update and rows
  int first_column = 0, end_column = 0;  // for triangle and rows
  int pending_count = 0;                 // number of tasks that must finish first
  std::vector<int> next = {};            // tasks that wait for this one
};

/// Creates the tasks of a factorization in an order in which each task comes after those that it
/// waits for. Threads that take tasks in this order never wait for a task that no thread has taken.
///
/// Work is split by partition_elimination_tree(), weighted by `flops` of each supernode. A block
/// that is one large supernode is split further, into tasks of 96 rows for its updates and for each
/// 96 columns. `parents`: parent of each supernode in the elimination tree, or -1. The result
/// depends on the pattern only. Cost: O(supernodes), plus a small amount per task.
std::vector<FactorTask> plan_factorization(const SupernodalPattern& pattern,
                                           const std::vector<int>& parents,
                                           const std::vector<long>& flops);

/// Numeric factorization P A Pᵀ = L Lᵀ for a known pattern. It is left-looking and proceeds
/// supernode by supernode, from the leaves of the elimination tree to its roots:
///
///     L_s := entries of A;  L_s -= L_d(rows of s and below) L_d(rows of s)ᵀ for each d below s
///     L_s's triangle = its Cholesky factor;  L_s's rows below := rows · triangle⁻ᵀ
///
/// The supernodes d that update s, and the position of each entry of A, are computed once per
/// pattern. factorize() computes values only and allocates memory only if it uses more threads than
/// before. The rows of large supernodes are distributed over the threads. Every entry receives its
/// updates in ascending order of d, each summed over the columns of d in their order: results are
/// bit-identical for any number of threads.
///
/// Polls the current ProgressScope after some milliseconds of work, on each thread, and reports the
/// fraction of the operations to it.
///
/// Cost: Σ (rows of a column of L)² operations. Memory: 8 bytes per entry of L and 8 per entry of
/// A. Reference: [NgPeyton1993]; tasks: [Hogg2010].
class SupernodalFactorization {
 public:
  SupernodalFactorization() = default;

  /// Prepares the factorization. `pattern` must outlive this object. `order`: the unknown of each
  /// row of L. Only the pattern of the lower triangle of A is read. Cost: O(entries of A and rows
  /// of the pattern).
  SupernodalFactorization(const SupernodalPattern& pattern, const int* order,
                          const SparseMatrix& A);

  /// Computes the values for A. Returns the first column whose pivot is not positive (or NaN), or
  /// -1 on success. Throws CancelledError; the values are then undefined.
  int factorize(const SparseMatrix& A);

  /// Values of L, in the layout of the pattern.
  double* values() { return values_.get(); }
  const double* values() const { return values_.get(); }

 private:
  // Rows first … end-1 of the descendant `from`, which are columns of this supernode.
  struct Update {
    int from, first, end;
  };
  struct Workspace {
    std::vector<int> local_row;   // index of a row of L in the current supernode
    std::vector<int> local_rows;  // rows of one supernode as indices in another
    std::vector<double> scratch;
    long unpolled = 0;  // operations since the last poll
    int percent = 0;    // last progress reported
  };

  void find_entries(const int* order, const SparseMatrix& A);
  void find_updates();
  std::vector<int> parents() const;
  std::vector<long> flops() const;
  int width(int s) const { return pattern_.columns[s + 1] - pattern_.columns[s]; }
  int rows(int s) const { return pattern_.row_starts[s + 1] - pattern_.row_starts[s]; }
  double* block(int s) const { return values_.get() + pattern_.value_starts[s]; }

  void allocate_workspace(int threads);
  void factor_in_parallel(const double* a, int threads);
  void execute(const FactorTask& task, const double* a, Workspace& work);
  void factor_supernode(int s, const double* a, Workspace& work);
  void assemble(int s, const double* a);
  void update(int s, int first_row, int end_row, Workspace& work);
  void triangle(int s, int first_column, int end_column, Workspace& work);
  void solve_rows_of(int s, int first_row, int end_row, int first_column, int end_column,
                     Workspace& work);
  // Whether the computation of supernode s is of no use, because of a failed pivot or because the
  // computation was cancelled.
  bool is_useless(int s) const;
  // Polls if the operations since the last poll, with the given ones, are enough.
  void poll_after(long operations, Workspace& work);

  SupernodalPattern pattern_;
  // Entries of A that belong to each supernode, and their positions in its block.
  std::vector<int> entry_starts_, entries_, targets_;
  std::vector<int> update_starts_;
  std::vector<Update> updates_;
  std::vector<FactorTask> tasks_;
  long flops_ = 0;
  int max_rows_ = 0, max_columns_ = 0;
  std::unique_ptr<double[]> values_;
  std::vector<Workspace> work_;                  // one per thread
  std::unique_ptr<std::atomic<int>[]> pending_;  // unfinished predecessors of each task
  std::unique_ptr<std::atomic<int>> failed_;     // lowest column known to fail; -1: cancelled
  std::unique_ptr<std::atomic<long>> done_;      // operations done, for reports
};

}  // namespace batten
