// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/loop_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

// Local search for select_loops(): improves a selection item by item.

/// Local search over selections. chosen[i] is 1 if item i is selected. Keeps a reference to the
/// problem.
class LocalSearch {
 public:
  static constexpr double kTieTolerance = 1e-9;  ///< gains that differ by less are equal

  explicit LocalSearch(const LoopSelectionProblem& problem);

  std::vector<signed char> fixed;  ///< for each item: 1 selected, 0 excluded, -1 free

  /// Objective value of a selection (see LoopSelectionProblem).
  double value(const std::vector<char>& chosen) const;
  /// Greedily adds the items with the largest advantage, ties by index. `never` is not added. Cost:
  /// O(n log n) for n items with bounded neighbourhoods.
  void fill(std::vector<char>& chosen, const std::vector<int>& from, int never = -1) const;
  /// Forces an item in or out and re-selects the items of its neighbourhood(). Returns the change
  /// of the objective value; minus infinity if fixed items leave no capacity for the item.
  double forced(std::vector<char>& chosen, int item, bool in,
                const std::vector<int>& neighbourhood) const;
  /// Forces single items in or out as long as the objective increases.
  void improve(std::vector<char>& chosen) const;
  /// Items that share an edge with this one, ascending.
  const std::vector<int>& neighbours(int item) const { return neighbours_[item]; }
  /// The item, its neighbours and their neighbours, ascending.
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
  std::vector<std::vector<Use>> uses_;                     // by edge
  std::vector<std::vector<std::pair<int, double>>> near_;  // for each item: (other item, pair cost)
  std::vector<std::vector<int>> neighbours_;
};

namespace {

// The use of one edge by an item.
struct ItemOnEdge {
  int item, uses;
  double gain;  // part of the item's gain that is assigned to this edge
};

class Solver {
 public:
  explicit Solver(const LoopSelectionProblem& problem)
      : problem_(problem),
        edge_items_(problem.capacity.size()),
        costs_(problem.capacity.size()),
        local_(problem),
        fixed_(local_.fixed) {
    for (size_t i = 0; i < problem.items.size(); ++i) {
      const auto& item = problem.items[i];
      for (size_t k = 0; k < item.edges.size(); ++k) {
        slot_.push_back(static_cast<int>(edge_items_[item.edges[k]].size()));
        edge_items_[item.edges[k]].push_back({static_cast<int>(i), item.uses[k],
                                              item.gain / static_cast<double>(item.edges.size())});
      }
      first_slot_.push_back(static_cast<int>(slot_.size() - item.edges.size()));
    }
    for (size_t a = 0; a < edge_items_.size(); ++a)
      costs_[a].assign(edge_items_[a].size() * edge_items_[a].size(), 0.0);
    for (const auto& p : problem.pairs) {
      const int i = slot_of(p.edge, p.a), j = slot_of(p.edge, p.b);
      const size_t m = edge_items_[p.edge].size();
      costs_[p.edge][i * m + j] += p.pair_cost;
      costs_[p.edge][j * m + i] += p.pair_cost;
    }
  }

  // Value of the best set on one edge, with one slot forced in (`taken`) or out (`left`); -1: none.
  double best(int edge, int taken, int left, std::vector<int>* set = nullptr) {
    const auto& edge_items = edge_items_[edge];
    stack_.clear();
    double value = 0;
    int capacity = problem_.capacity[edge];
    candidates_.clear();
    for (int s = 0; s < isize(edge_items); ++s) {
      const signed char fixed = fixed_[edge_items[s].item];
      if (s == left || (fixed == 0 && s != taken)) continue;
      if (s == taken || fixed == 1) {
        capacity -= edge_items[s].uses;
        value += edge_items[s].gain;
        for (const int t : stack_) value -= costs_[edge][s * edge_items.size() + t];
        stack_.push_back(s);
      } else if (edge_items[s].gain > 0) {
        candidates_.push_back(s);
      }
    }
    if (capacity < 0) {
      if (set) set->clear();
      return -HUGE_VAL;
    }
    const size_t forced = stack_.size();
    found_ = stack_;
    double top = value;
    // The largest gain first: then most other items can be pruned, whatever is combined with them.
    const auto less = [&](int a, int b) { return edge_items[a].gain < edge_items[b].gain; };
    const auto largest = std::max_element(candidates_.begin(), candidates_.end(), less);
    double most = 0;
    if (largest != candidates_.end()) {
      most = edge_items[*largest].gain;
      std::iter_swap(candidates_.begin(), largest);
    }
    const auto extend = [&](auto& self, size_t from, double sum, int left_capacity) -> void {
      for (size_t k = from; k < candidates_.size(); ++k) {
        const int s = candidates_[k];
        if (edge_items[s].uses > left_capacity) continue;
        double next = sum + edge_items[s].gain;
        if (next + most * (left_capacity - edge_items[s].uses) <= top + 1e-12) continue;
        for (const int t : stack_) next -= costs_[edge][s * edge_items.size() + t];
        stack_.push_back(s);
        if (next > top + 1e-12) top = next, found_ = stack_;
        if (left_capacity > edge_items[s].uses)
          self(self, k + 1, next, left_capacity - edge_items[s].uses);
        stack_.pop_back();
      }
    };
    extend(extend, 0, value, capacity);
    stack_.resize(forced);
    if (set) *set = found_;
    return top;
  }

  // Redistributes the gain of each item so that its advantage is equal on all its edges (dual
  // coordinate ascent). Never increases the bound.
  void distribute_gains(int sweeps) {
    double before = HUGE_VAL;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (size_t i = 0; i < problem_.items.size(); ++i) {
        if (fixed_[i] >= 0) continue;
        const auto& edges = problem_.items[i].edges;
        advantages_.clear();
        for (size_t k = 0; k < edges.size(); ++k) {
          const int s = slot_[first_slot_[i] + k];
          advantages_.push_back(best(edges[k], s, -1) - best(edges[k], -1, s));
        }
        const double mean = std::accumulate(advantages_.begin(), advantages_.end(), 0.0) /
                            static_cast<double>(edges.size());
        if (!std::isfinite(mean)) continue;
        for (size_t k = 0; k < edges.size(); ++k)
          edge_items_[edges[k]][slot_[first_slot_[i] + k]].gain += mean - advantages_[k];
      }
      const double now = bound();
      if (before - now < 1e-3) break;
      before = now;
    }
  }

  double bound() {
    double sum = 0;
    for (size_t a = 0; a < edge_items_.size(); ++a) sum += best(static_cast<int>(a), -1, -1);
    return sum;
  }

  // Best sets of all edges, updated incrementally while items are fixed and freed.
  struct BestSets {
    std::vector<double> value;
    std::vector<std::vector<int>> set;  // items
    std::vector<int> votes;             // number of edges whose best set contains the item
    double sum = 0;                     // of the finite values
    int impossible = 0;                 // edges with more fixed uses than capacity

    double top() const { return impossible > 0 ? -HUGE_VAL : sum; }
    void count(double of_edge, int times) {
      if (std::isfinite(of_edge))
        sum += times * of_edge;
      else
        impossible += times;
    }
  };

  void update(BestSets& best_sets, int edge) {
    for (const int i : best_sets.set[edge]) --best_sets.votes[i];
    std::vector<int>& set = best_sets.set[edge];
    best_sets.count(best_sets.value[edge], -1);
    best_sets.value[edge] = best(edge, -1, -1, &set);
    best_sets.count(best_sets.value[edge], 1);
    for (int& s : set) {
      s = edge_items_[edge][s].item;
      ++best_sets.votes[s];
    }
  }

  BestSets all_best_sets() {
    BestSets best_sets{std::vector<double>(edge_items_.size()),
                       std::vector<std::vector<int>>(edge_items_.size()),
                       std::vector<int>(problem_.items.size(), 0)};
    for (size_t a = 0; a < edge_items_.size(); ++a) update(best_sets, static_cast<int>(a));
    return best_sets;
  }

  // Branch and bound over the free items.
  void search(BestSets& best_sets, const std::vector<int>& items, std::vector<char>& lead,
              double& lead_value) {
    if (work_left_ < 0) {
      cut_ = true;
      return;
    }
    const double top = best_sets.top();
    if (top <= lead_value + LocalSearch::kTieTolerance) return;
    int undecided = -1, widest = 0;
    for (const int i : items) {
      const int all = isize(problem_.items[i].edges);
      const int split = std::min(best_sets.votes[i], all - best_sets.votes[i]);
      if (fixed_[i] < 0 && split > widest) undecided = i, widest = split;
    }
    if (undecided < 0) {
      lead_value = top;
      for (const int i : items) lead[i] = best_sets.votes[i] > 0;
      return;
    }
    for (const int in : {1, 0}) {
      fixed_[undecided] = static_cast<signed char>(in);
      work_left_ -= static_cast<long>(problem_.items[undecided].edges.size());
      for (const int a : problem_.items[undecided].edges) update(best_sets, a);
      search(best_sets, items, lead, lead_value);
    }
    fixed_[undecided] = -1;
    for (const int a : problem_.items[undecided].edges) update(best_sets, a);
  }

  // Fixes items whose opposite state cannot occur in any selection better than `value`.
  void fix_decided(double value) {
    const double gap = bound() - value + 1e-7;
    for (size_t i = 0; i < problem_.items.size(); ++i) {
      if (fixed_[i] >= 0) continue;
      const auto& edges = problem_.items[i].edges;
      double with = 0, without = 0;
      for (size_t k = 0; k < edges.size(); ++k) {
        const int s = slot_[first_slot_[i] + k];
        const double top = best(edges[k], -1, -1);
        with += top - best(edges[k], s, -1);
        without += top - best(edges[k], -1, s);
      }
      if (with > gap) fixed_[i] = 0;
      if (without > gap && with <= gap) fixed_[i] = 1;
    }
  }

  // Connected clusters of free items that share edges.
  std::vector<std::vector<int>> clusters() const {
    std::vector<std::vector<int>> all;
    std::vector<char> seen(problem_.items.size(), 0);
    for (size_t first = 0; first < seen.size(); ++first) {
      if (seen[first] || fixed_[first] >= 0) continue;
      std::vector<int> cluster{static_cast<int>(first)};
      seen[first] = 1;
      for (size_t k = 0; k < cluster.size(); ++k)
        for (const int i : local_.neighbours(cluster[k]))
          if (!seen[i] && fixed_[i] < 0) seen[i] = 1, cluster.push_back(i);
      std::sort(cluster.begin(), cluster.end());
      all.push_back(std::move(cluster));
    }
    return all;
  }

  LoopSelection solve(long max_work) {
    distribute_gains(20);
    LoopSelection result;
    const BestSets first = all_best_sets();
    result.chosen.assign(problem_.items.size(), 0);
    std::vector<int> agreed, rest;
    for (size_t i = 0; i < problem_.items.size(); ++i)
      (first.votes[i] == isize(problem_.items[i].edges) ? agreed : rest)
          .push_back(static_cast<int>(i));
    local_.fill(result.chosen, agreed);
    local_.fill(result.chosen, rest);
    local_.improve(result.chosen);
    result.value = local_.value(result.chosen);
    for (int round = 0; round < 3; ++round) {
      result.bound = bound();
      if (result.bound - result.value <= 1e-7) break;
      fix_decided(result.value);
      distribute_gains(5);
    }
    result.bound = bound();
    if (result.bound - result.value > 1e-7) {
      const auto parts = clusters();
      for (const auto& part : parts)
        for (const int i : part) fixed_[i] = static_cast<signed char>(result.chosen[i]);
      bool all = true;
      BestSets best_sets = all_best_sets();
      const auto update_around = [&](const std::vector<int>& part) {
        for (const int i : part)
          for (const int a : problem_.items[i].edges) update(best_sets, a);
      };
      double lead = local_.value(result.chosen);
      for (const auto& part : parts) {
        for (const int i : part) fixed_[i] = -1;
        update_around(part);
        work_left_ = max_work / static_cast<long>(parts.size());
        cut_ = false;
        search(best_sets, part, result.chosen, lead);
        all = all && !cut_;
        for (const int i : part) fixed_[i] = static_cast<signed char>(result.chosen[i]);
        update_around(part);
      }
      result.value = local_.value(result.chosen);
      if (all) result.bound = result.value;
    }
    result.optimal = result.bound - result.value <= 1e-6;
    return result;
  }

 private:
  int slot_of(int edge, int item) const {
    const auto& edges = problem_.items[item].edges;
    return slot_[first_slot_[item] +
                 static_cast<int>(std::find(edges.begin(), edges.end(), edge) - edges.begin())];
  }

  const LoopSelectionProblem& problem_;
  std::vector<std::vector<ItemOnEdge>> edge_items_;  // by edge
  std::vector<std::vector<double>> costs_;           // pair costs by edge, m × m
  std::vector<int> slot_, first_slot_;               // slot of each item on each of its edges
  LocalSearch local_;
  std::vector<signed char>& fixed_;
  std::vector<int> stack_, candidates_, found_;
  std::vector<double> advantages_;
  long work_left_ = 0;
  bool cut_ = false;
};

}  // namespace

LoopSelection select_loops(const LoopSelectionProblem& problem, long max_work) {
  return Solver(problem).solve(max_work);
}

std::vector<Alternative> find_alternatives(const LoopSelectionProblem& problem,
                                           const LoopSelection& selected) {
  const LocalSearch local(problem);
  std::vector<Alternative> all(problem.items.size());
  std::vector<char> other = selected.chosen;
  for (size_t i = 0; i < all.size(); ++i) {
    const std::vector<int> near = local.neighbourhood(static_cast<int>(i));
    all[i].loss = -local.forced(other, static_cast<int>(i), !selected.chosen[i], near);
    for (const int k : near)
      if (other[k] != selected.chosen[k]) {
        (other[k] ? all[i].in : all[i].out).push_back(k);
        other[k] = selected.chosen[k];
      }
  }
  return all;
}

namespace {

void sort_unique(std::vector<int>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

LocalSearch::LocalSearch(const LoopSelectionProblem& problem)
    : fixed(problem.items.size(), -1),
      problem_(problem),
      uses_(problem.capacity.size()),
      near_(problem.items.size()) {
  for (size_t i = 0; i < problem.items.size(); ++i)
    for (size_t k = 0; k < problem.items[i].edges.size(); ++k)
      uses_[problem.items[i].edges[k]].push_back({static_cast<int>(i), problem.items[i].uses[k]});
  for (const auto& p : problem.pairs) {
    near_[p.a].push_back({p.b, p.pair_cost});
    near_[p.b].push_back({p.a, p.pair_cost});
  }
  find_neighbours();
}

bool LocalSearch::fits(const std::vector<char>& chosen, int item) const {
  for (size_t k = 0; k < problem_.items[item].edges.size(); ++k) {
    const int a = problem_.items[item].edges[k];
    int used = problem_.items[item].uses[k];
    for (const Use& s : uses_[a])
      if (chosen[s.item] && s.item != item) used += s.uses;
    if (used > problem_.capacity[a]) return false;
  }
  return true;
}

double LocalSearch::advantage(const std::vector<char>& chosen, int item) const {
  double gain = problem_.items[item].gain;
  for (const auto& [other, pair_cost] : near_[item])
    if (chosen[other]) gain -= pair_cost;
  return gain;
}

double LocalSearch::value(const std::vector<char>& chosen) const {
  double sum = 0;
  for (size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) sum += problem_.items[i].gain;
  for (const auto& p : problem_.pairs)
    if (chosen[p.a] && chosen[p.b]) sum -= p.pair_cost;
  return sum;
}

void LocalSearch::find_neighbours() {
  neighbours_.resize(problem_.items.size());
  for (size_t i = 0; i < neighbours_.size(); ++i) {
    for (const int a : problem_.items[i].edges)
      for (const Use& s : uses_[a])
        if (s.item != static_cast<int>(i)) neighbours_[i].push_back(s.item);
    sort_unique(neighbours_[i]);
  }
}

std::vector<int> LocalSearch::neighbourhood(int item) const {
  std::vector<int> all = neighbours_[item];
  all.push_back(item);
  for (const int k : neighbours_[item])
    all.insert(all.end(), neighbours_[k].begin(), neighbours_[k].end());
  sort_unique(all);
  return all;
}

void LocalSearch::fill(std::vector<char>& chosen, const std::vector<int>& from, int never) const {
  // Priority: advantage in units of the tie tolerance, then index. An advantage only decreases
  // while other items are added.
  using Bid = std::pair<long long, int>;
  std::vector<Bid> heap;
  const auto bid = [&](int i) -> Bid {
    return {std::llround(advantage(chosen, i) / kTieTolerance), -i};
  };
  for (const int i : from)
    if (!chosen[i] && i != never && fixed[i] != 0)
      if (const Bid b = bid(i); b.first > 1) heap.push_back(b);
  std::make_heap(heap.begin(), heap.end());
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end());
    const int i = -heap.back().second;
    if (const Bid now = bid(i); now != heap.back() && now.first > 1) {
      heap.back() = now;
      std::push_heap(heap.begin(), heap.end());
      continue;
    } else if (now.first > 1 && fits(chosen, i)) {
      chosen[i] = 1;
    }
    heap.pop_back();
  }
}

double LocalSearch::forced(std::vector<char>& chosen, int item, bool in,
                           const std::vector<int>& neighbourhood) const {
  const std::vector<int>& neighbours = neighbours_[item];
  const auto local = [&] {
    double sum = 0;
    for (const int i : neighbourhood)
      if (chosen[i]) {
        sum += problem_.items[i].gain;
        for (const auto& [other, pair_cost] : near_[i])
          if (chosen[other])
            sum -= std::binary_search(neighbourhood.begin(), neighbourhood.end(), other)
                       ? pair_cost / 2
                       : pair_cost;
      }
    return sum;
  };
  const double before = local();
  chosen[item] = in;
  if (in) {
    // Remove items that conflict, the one with the smallest advantage first.
    for (;;) {
      int worst = -1;
      double least = HUGE_VAL;
      const bool tight = !fits(chosen, item);
      for (const int i : neighbours) {
        if (!chosen[i] || fixed[i] == 1) continue;
        const double gain = advantage(chosen, i);
        if ((tight ? blocks(chosen, i, item) : gain < 0) && gain < least) worst = i, least = gain;
      }
      if (worst < 0) break;
      chosen[worst] = 0;
    }
    if (!fits(chosen, item)) {
      return -HUGE_VAL;
    }
  }
  fill(chosen, neighbourhood, in ? -1 : item);
  return local() - before;
}

bool LocalSearch::blocks(const std::vector<char>& chosen, int i, int item) const {
  for (size_t k = 0; k < problem_.items[item].edges.size(); ++k) {
    const int a = problem_.items[item].edges[k];
    int used = problem_.items[item].uses[k];
    bool there = false;
    for (const Use& s : uses_[a])
      if (chosen[s.item] && s.item != item) used += s.uses, there |= s.item == i;
    if (there && used > problem_.capacity[a]) return true;
  }
  return false;
}

void LocalSearch::improve(std::vector<char>& chosen) const {
  for (bool better = true; better;) {
    better = false;
    for (size_t i = 0; i < chosen.size(); ++i) {
      if (fixed[i] >= 0) continue;
      const std::vector<int> near = neighbourhood(static_cast<int>(i));
      std::vector<char> before;
      for (const int k : near) before.push_back(chosen[k]);
      if (forced(chosen, static_cast<int>(i), !chosen[i], near) > kTieTolerance)
        better = true;
      else
        for (size_t k = 0; k < near.size(); ++k) chosen[near[k]] = before[k];
    }
  }
}

}  // namespace batten
