#include "batten/skinning/search/local_search.h"

#include <algorithm>
#include <cmath>

namespace batten {
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
  // What an item adds, in ties, and the item; an advantage only falls while others are taken.
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

// Forces an item in or out and mends what is around it. Returns what that changes the value by.
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
    // Items that are in the way are taken out, that of least advantage first.
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
