// SPDX-License-Identifier: MPL-2.0
// Small utilities for containers: signed size, sorted unique lists, and disjoint sets (union-find).
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace batten {

/// Size of a container as a signed int, the index type used throughout Batten.
///
/// Meshes, dof sets and curves have fewer than 2³¹ elements; anything larger is rejected when it is
/// created.
template <class Container>
constexpr int isize(const Container& container) {
  return static_cast<int>(container.size());
}

// Sorted lists of integers.

/// Sorts `values` in ascending order and removes duplicates.
inline std::vector<int> sorted_unique(std::vector<int> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

// Disjoint sets of integers.

/// Disjoint sets (union-find) of the integers 0 … count - 1; initially each integer is a set of its
/// own.
///
/// The representative of a set is its lowest element, whatever the order of the unions.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  /// Lowest element of the set that contains i. O(log n) amortised (path halving), close to O(1)
  /// in practice.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Merges the sets of i and j.
  void unite(int i, int j) {
    const int p = find(i), q = find(j);
    parent_[std::max(p, q)] = std::min(p, q);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace batten
