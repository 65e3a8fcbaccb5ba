// How many things a container holds, as a number that indices are compared with.
#pragma once

#include <algorithm>
#include <vector>
#include <cstddef>
#include <numeric>

namespace batten {

/// The size of a container as int, as everything in the kernel is numbered: meshes, dofs and lines
/// stay below 2³¹, and what could exceed it is refused where it is made.
template <class Container>
constexpr int isize(const Container& container) {
  return static_cast<int>(container.size());
}


// Lists of numbers in order.

/// The numbers ascending, each once.
inline std::vector<int> sorted_unique(std::vector<int> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}


// Disjoint sets of numbers.

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
