// The numbers of a supernodal Cholesky factor, on several cores. Internal.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/supernodal_solve.h"

namespace batten {

// The steps of a numeric factorization, for several threads. Internal.

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


/// P A Pᵀ = L Lᵀ for a pattern that is known. Supernode by supernode, from the leaves of the
/// elimination tree to its roots (left-looking):
///
///     L_s := entries of A;  L_s -= L_d(rows of s and below) L_d(rows of s)ᵀ for each d below s
///     L_s's triangle = its Cholesky factor;  L_s's rows below := rows · triangle⁻ᵀ
///
/// Which d reach s, and where each entry of A belongs, is found once for a pattern: factorize()
/// makes nothing but numbers, and allocates nothing but for more threads than before. Large
/// supernodes are shared among the threads by rows. Every entry takes its updates in ascending
/// order of d, each the sum over d's columns in their order: the same bits on one thread as on many.
///
/// Cost: Σ (rows of a column of L)² operations. Memory: 8 bytes an entry of L, 8 an entry of A.
/// Source: Ng, Peyton 1993; tasks: Hogg, Reid, Scott 2010.
class SupernodalFactorization {
 public:
  SupernodalFactorization() = default;

  /// `pattern` outlives this. `order`: the unknown behind each row of L. Of `A` the lower triangle
  /// is read, and only its pattern. O(entries of A and rows of the pattern).
  SupernodalFactorization(const SupernodalPattern& pattern, const int* order,
                          const SparseMatrix& A);

  /// Returns the first column whose pivot is not positive (or not a number), or -1.
  int factorize(const SparseMatrix& A);

  double* values() { return values_.get(); }
  const double* values() const { return values_.get(); }

 private:
  // Rows first … end-1 of a supernode below are columns of this one.
  struct Update {
    int from, first, end;
  };
  struct Workspace {
    std::vector<int> local_row;   // of a row of L in the supernode at hand
    std::vector<int> local_rows;  // of a supernode's rows in another
    std::vector<double> scratch;
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

  SupernodalPattern pattern_;
  std::vector<int> entry_starts_, entries_,
      targets_;  // A's entries of each supernode, their places
  std::vector<int> update_starts_;
  std::vector<Update> updates_;
  std::vector<FactorTask> tasks_;
  long flops_ = 0;
  int max_rows_ = 0, max_columns_ = 0;
  std::unique_ptr<double[]> values_;
  std::vector<Workspace> work_;                  // of each thread
  std::unique_ptr<std::atomic<int>[]> pending_;  // of each task: what it waits for
  std::unique_ptr<std::atomic<int>> failed_;     // the first column known to fail
};

}  // namespace batten
