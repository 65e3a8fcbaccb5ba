// Inside of select_loops(): makes a choice better item by item.
#pragma once

#include <utility>
#include <vector>

#include "batten/skinning/search/loop_selection_problem.h"

namespace batten {

/// Local search over choices: chosen[i] says whether item i is taken. Keeps a reference to the
/// problem.
class LocalSearch {
 public:
  static constexpr double kTieTolerance = 1e-9;  ///< gains that differ by less are equal

  explicit LocalSearch(const LoopSelectionProblem& problem);

  std::vector<signed char> fixed;  ///< of each item: 1 taken, 0 left out, -1 open

  /// Returns the value of a choice, the sum that Selection maximises.
  double value(const std::vector<char>& chosen) const;
  /// Takes the items that add most, one after another, of equal ones the first; `never` is not
  /// taken. O(n log n) for n items of bounded neighbourhoods.
  void fill(std::vector<char>& chosen, const std::vector<int>& from, int never = -1) const;
  /// Forces an item in or out and chooses the items around it, neighbourhood(item), anew. Returns the change
  /// of the value, or minus infinity when fixed items leave no room for the item.
  double forced(std::vector<char>& chosen, int item, bool in,
                const std::vector<int>& neighbourhood) const;
  /// Forces single items in or out as long as that makes the choice better.
  void improve(std::vector<char>& chosen) const;
  /// Returns the other items that share an arc with this one, ascending.
  const std::vector<int>& neighbours(int item) const { return neighbours_[item]; }
  /// Returns these and their neighbours too, with the item: ascending.
  std::vector<int> neighbourhood(int item) const;

 private:
  struct Use {
    int item, uses;
  };
  bool fits(const std::vector<char>& chosen, int item) const;
  double advantage(const std::vector<char>& chosen, int item) const;
  bool blocks(const std::vector<char>& chosen, int i, int item) const;
  void find_neighbours();

  const LoopSelectionProblem& problem_;
  std::vector<std::vector<Use>> uses_;                     // of each arc
  std::vector<std::vector<std::pair<int, double>>> near_;  // items that have a price with each item
  std::vector<std::vector<int>> neighbours_;
};

}  // namespace batten
