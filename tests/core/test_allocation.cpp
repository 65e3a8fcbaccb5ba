// SPDX-License-Identifier: MPL-2.0
// Drags do not allocate.
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/solver_matrices.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;

TEST_CASE("solves allocate nothing: one thread or more, one column or many, whole or in part",
          "[core][allocation]") {
  if (!counts_allocations()) return;
  const ThreadGuard two(2);
  for (const int vertices : {3300, 14600}) {
    const SparseMatrix A = holed_sheet(vertices).normal;
    SparseCholesky cholesky;
    cholesky.analyze(A);
    REQUIRE(cholesky.factorize(A));
    MatX x = random_columns(A.rows(), 9);
    Points points = x.leftCols(3);
    const SolveSubset subset = cholesky.subset(std::vector<int>{1, 2, 3}, std::nullopt);
    cholesky.solve_in_place(x);  // starts the threads, allocates space for eight columns
    {
      const ScopedOpCount work;
      for (int event = 0; event < 20; ++event) {
        cholesky.solve_in_place(points);
        cholesky.solve_in_place(x.leftCols(1));
        cholesky.solve_in_place(x);
        cholesky.solve_in_place(subset, points);
      }
      CHECK(work.of(OpCounter::Allocation) == 0);
    }
    const ScopedOpCount work;  // the counter works
    const MatX copy = cholesky.solve(points);
    CHECK(work.of(OpCounter::Allocation) > 0);
  }
}
