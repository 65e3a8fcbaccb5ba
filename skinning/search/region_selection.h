// Which of many loops are taken together: arcs bear so many, and neighbours cost something.
#pragma once

#include <vector>

#include "batten/skinning/search/selection.h"

namespace batten {

struct Selected {
  std::vector<char> chosen;
  double value = 0;  ///< value of what was chosen
  double bound = 0;  ///< no choice has more
  bool optimal = false;
};

/// The gains are shared out among arcs so that the best sets of single arcs agree on as many items
/// as possible (dual coordinate ascent: each item's advantage is made the same on all its arcs);
/// the sum of these bests bounds every choice from above. Where all agree the choice is proved the
/// best one. Otherwise branch and bound goes on over the items in doubt, each cluster by itself,
/// starting from what local search found, until the best sets of `most_work` arcs have been
/// looked for anew. Ties go to
/// the item that comes first. Deterministic, single-threaded.
Selected select(const Selection& problem, long most_work = 50000);

/// A choice with one item the other way.
struct Otherwise {
  double loss = 0;  ///< of value, at most: only the neighbourhood of the item was rearranged
  std::vector<int> out, in;  ///< items that left, and that came instead
};
/// For each item: what it costs to take it, or to leave it out, against `selected`. An infinite
/// loss: what is fixed stands against it.
std::vector<Otherwise> otherwise(const Selection& problem, const Selected& selected);

}  // namespace batten
