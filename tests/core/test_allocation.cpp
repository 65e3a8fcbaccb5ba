// The drag loop allocates nothing.
#include "batten/core/sparse_cholesky.h"
#include "batten/tests/allocations.h"
#include "batten/tests/catch.h"
#include "batten/tests/solver_matrices.h"
#include "batten/tests/threads.h"

using namespace batten_test;

TEST_CASE("solves allocate nothing: one thread or more, one column or many, whole or in part") {
  if (!counts_allocations()) return;
  const ThreadGuard two(2);
  for (const int vertices : {3300, 14600}) {
    const SparseMatrix A = holed_sheet(vertices).normal;
    SparseCholesky cholesky;
    cholesky.analyze(A);
    REQUIRE(cholesky.factorize(A));
    MatX x = random_columns(A.rows(), 9);
    Points points = x.leftCols(3);
    const SolvePart part = cholesky.part(std::vector<int>{1, 2, 3}, std::nullopt);
    cholesky.solve_in_place(x);  // starts the threads, makes room for eight columns
    {
      const WorkCount work;
      for (int event = 0; event < 20; ++event) {
        cholesky.solve_in_place(points);
        cholesky.solve_in_place(x.leftCols(1));
        cholesky.solve_in_place(x);
        cholesky.solve_in_place(part, points);
      }
      CHECK(work.of(Work::Allocation) == 0);
    }
    const WorkCount work;  // it does count
    const MatX copy = cholesky.solve(points);
    CHECK(work.of(Work::Allocation) > 0);
  }
}
