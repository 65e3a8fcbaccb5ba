// Chooses which of many loops are taken together: each arc has room for so many, and pairs on one
// arc have a price.
#pragma once

#include <vector>

namespace batten {

// The problem of choosing loops: each has a gain, takes room on arcs, and pays for pairs on one
// arc.

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


/// A choice, and what is known of it.
struct LoopSelection {
  std::vector<char> chosen;
  double value = 0;  ///< value of what was chosen
  double bound = 0;  ///< no choice has more
  bool optimal = false;
};

/// Chooses a set of items of large value, the largest where `optimal`. The gains are shared out
/// among arcs so that the best sets of single arcs agree on as many items as possible (dual
/// coordinate ascent: each item's advantage is made the same on all its arcs); the sum of the
/// values of these sets bounds every choice from above. Where all agree the choice is proved to be
/// the best one. Otherwise branch and bound goes on over the items in doubt, each cluster by
/// itself, from what local search found, until the best sets of `max_work` arcs have been computed
/// again. Ties go to the item that comes first. It is deterministic and uses one thread.
LoopSelection select_loops(const LoopSelectionProblem& problem, long max_work = 50000);

/// What changes when one item is forced the other way.
struct Alternative {
  double loss = 0;  ///< of value, at most: only the neighbourhood of the item was rearranged
  std::vector<int> out, in;  ///< items that left, and that came instead
};
/// Returns for each item what it costs to have it the other way than in `selected`. The loss is
/// infinite where items that are fixed leave no room for it.
std::vector<Alternative> find_alternatives(const LoopSelectionProblem& problem,
                                           const LoopSelection& selected);

}  // namespace batten
