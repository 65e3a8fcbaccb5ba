// How often the program asks for memory. Counted where malloc can be replaced: with glibc, without
// sanitizers.
#pragma once

namespace batten_test {

/// Whether allocations can be counted here.
bool counts_allocations();

/// Calls of malloc and its kin, on all threads, since this object was made.
class AllocationCount {
 public:
  AllocationCount();
  ~AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  long so_far() const;
};

}  // namespace batten_test
