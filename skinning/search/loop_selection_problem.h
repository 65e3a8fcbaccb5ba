// The problem of choosing loops: each has a gain, takes room on arcs, and pays for pairs on one
// arc.
#pragma once

#include <vector>

namespace batten {

/// Choose a set of items, each of which takes room on some arcs:
///
///   maximise Σ gain(i) - Σ pair_cost(i, j, a)   over chosen items i, and pairs that meet on an arc a
///   with at most room[a] uses on each arc.
struct LoopSelectionProblem {
  struct Item {
    double gain = 0;
    std::vector<int> edges;  ///< distinct
    std::vector<int> uses;   ///< how often it is used on each of these
  };
  struct Pair {
    int edge, a, b;    ///< a < b
    double pair_cost;  ///< 0 or more
  };
  std::vector<Item> items;
  std::vector<Pair> pairs;
  std::vector<int> capacity;  ///< uses that each arc has room for
};

}  // namespace batten
