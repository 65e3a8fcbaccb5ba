// The drag loop allocates nothing. Counted, where malloc can be replaced.
#include "batten/core/sparse_cholesky.h"
#include "batten/tests/catch.h"
#include "batten/tests/solver_matrices.h"
#include "batten/tests/threads.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<bool> counting{false};
std::atomic<long> allocations{0};
void count() {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
}
}  // namespace

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(size_t number, size_t size) {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* old, size_t size) {
  count();
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
}

using namespace batten_test;

TEST_CASE("solves allocate nothing: one thread or more, one column or many, whole or in part") {
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
    allocations = 0;
    counting = true;
    for (int event = 0; event < 20; ++event) {
      cholesky.solve_in_place(points);
      cholesky.solve_in_place(x.leftCols(1));
      cholesky.solve_in_place(x);
      cholesky.solve_in_place(part, points);
    }
    counting = false;
    CHECK(allocations == 0);

    counting = true;  // the counter works
    const MatX copy = cholesky.solve(points);
    counting = false;
    CHECK(allocations > 0);
  }
}

#endif
