// Disjoint sets of numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace batten {

/// Disjoint sets of the numbers 0 … count - 1: at first each number is a group of its own. A group
/// is known by its lowest number, whatever the order in which it was joined.
class Groups {
 public:
  explicit Groups(size_t count) : lower_(count) { std::iota(lower_.begin(), lower_.end(), 0); }

  /// Lowest number in the group of i. Nearly O(1).
  int of(int i) {
    while (lower_[i] != i) i = lower_[i] = lower_[lower_[i]];
    return i;
  }
  /// The groups of i and j become one.
  void join(int i, int j) {
    const int p = of(i), q = of(j);
    lower_[std::max(p, q)] = std::min(p, q);
  }

 private:
  std::vector<int> lower_;
};

}  // namespace batten
