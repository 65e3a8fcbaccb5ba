#include "batten/tests/allocations.h"

#include <cstdlib>  // says which libc this is

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)

#include <atomic>

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

namespace batten_test {
bool counts_allocations() { return true; }
AllocationCount::AllocationCount() {
  allocations = 0;
  counting = true;
}
AllocationCount::~AllocationCount() { counting = false; }
long AllocationCount::so_far() const { return allocations; }
}  // namespace batten_test

#else

namespace batten_test {
bool counts_allocations() { return false; }
AllocationCount::AllocationCount() = default;
AllocationCount::~AllocationCount() = default;
long AllocationCount::so_far() const { return 0; }
}  // namespace batten_test

#endif
