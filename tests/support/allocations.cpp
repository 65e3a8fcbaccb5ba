// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/allocations.h"

#include <cstdlib>  // defines the macro of the libc

#include "batten/core/op_counter.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) {
  batten::count(batten::OpCounter::Allocation);
  return __libc_malloc(size);
}
void* calloc(size_t number, size_t size) {
  batten::count(batten::OpCounter::Allocation);
  return __libc_calloc(number, size);
}
void* realloc(void* old, size_t size) {
  batten::count(batten::OpCounter::Allocation);
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  batten::count(batten::OpCounter::Allocation);
  return __libc_memalign(alignment, size);
}
}

namespace batten_test {
bool counts_allocations() { return true; }
}  // namespace batten_test

#else

namespace batten_test {
bool counts_allocations() { return false; }
}  // namespace batten_test

#endif
