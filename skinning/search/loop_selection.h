// SPDX-License-Identifier: MPL-2.0
// Selects the best compatible subset of candidate loops (a set-packing problem with pairwise
// costs).
#pragma once

#include <vector>

namespace batten {

// The selection problem.

/// Selection problem: select a subset of items (loops), each of which uses some edges:
///
///     maximise Σ gain(i) - Σ pair_cost(i, j, a)  over selected items i, pairs (i, j) on edge a
///     subject to at most capacity[a] uses of each edge a.
struct LoopSelectionProblem {
  /// A candidate loop.
  struct Item {
    double gain = 0;
    std::vector<int> edges;  ///< edges used, distinct
    std::vector<int> uses;   ///< number of uses of each of these edges
  };
  /// The cost of selecting items a and b together, because both use an edge.
  struct Pair {
    int edge, a, b;    ///< a < b: items
    double pair_cost;  ///< ≥ 0
  };
  std::vector<Item> items;
  std::vector<Pair> pairs;
  std::vector<int> capacity;  ///< largest number of uses of each edge
};

/// A solution of a LoopSelectionProblem, with an upper bound on the optimum.
struct LoopSelection {
  /// For each item: 1 if it is selected, otherwise 0.
  std::vector<char> chosen;
  double value = 0;  ///< objective value of the selection
  double bound = 0;  ///< upper bound on the objective value of every selection
  /// True if `value` is proved to be the maximum.
  bool optimal = false;
};

/// Selects items of large total value; the optimum if `optimal` is set in the result.
///
/// Dual coordinate ascent distributes the gain of each item over its edges, so that the best sets
/// of the single edges agree on as many items as possible: an item gets the same advantage on all
/// its edges. The sum of the values of these sets is an upper bound. If all sets agree, the
/// selection is optimal. Otherwise branch and bound runs over the undecided items, separately for
/// each cluster, starting from the result of a local search. It stops after `max_work`
/// re-computations of single-edge sets. Ties go to the first item. Deterministic and
/// single-threaded.
LoopSelection select_loops(const LoopSelectionProblem& problem, long max_work = 50000);

/// The effect of forcing one item to the opposite of its selected state.
struct Alternative {
  /// Decrease of the objective; an upper bound, as only neighbours are re-selected.
  double loss = 0;
  std::vector<int> out, in;  ///< items deselected, and items selected instead
};
/// Computes the alternative for each item: its state in `selected` is flipped. The loss is infinite
/// if no capacity is left for the item.
std::vector<Alternative> find_alternatives(const LoopSelectionProblem& problem,
                                           const LoopSelection& selected);

}  // namespace batten
