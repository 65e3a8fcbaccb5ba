// Disjoint sets of numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace batten {

/// Disjoint sets of the numbers 0 … count - 1: at first each number is a group of its own. A group
/// is known by its lowest number, whatever the order in which it was joined.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  /// Lowest number in the group of i. Nearly O(1).
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The groups of i and j become one.
  void unite(int i, int j) {
    const int p = find(i), q = find(j);
    parent_[std::max(p, q)] = std::min(p, q);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace batten
