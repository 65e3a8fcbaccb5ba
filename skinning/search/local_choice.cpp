#include "batten/skinning/search/local_choice.h"

#include <algorithm>
#include <cmath>

namespace batten {

LocalChoice::LocalChoice(const Selection& problem)
    : fixed(problem.items.size(), -1),
      problem_(problem),
      uses_(problem.room.size()),
      near_(problem.items.size()) {
  for (size_t i = 0; i < problem.items.size(); ++i)
    for (size_t k = 0; k < problem.items[i].arcs.size(); ++k)
      uses_[problem.items[i].arcs[k]].push_back({static_cast<int>(i), problem.items[i].uses[k]});
  for (const auto& p : problem.pairs) {
    near_[p.a].push_back({p.b, p.price});
    near_[p.b].push_back({p.a, p.price});
  }
  find_neighbours();
}

bool LocalChoice::fits(const std::vector<char>& chosen, int item) const {
  for (size_t k = 0; k < problem_.items[item].arcs.size(); ++k) {
    const int a = problem_.items[item].arcs[k];
    int used = problem_.items[item].uses[k];
    for (const Use& s : uses_[a])
      if (chosen[s.item] && s.item != item) used += s.uses;
    if (used > problem_.room[a]) return false;
  }
  return true;
}

double LocalChoice::advantage(const std::vector<char>& chosen, int item) const {
  double gain = problem_.items[item].gain;
  for (const auto& [other, price] : near_[item])
    if (chosen[other]) gain -= price;
  return gain;
}

double LocalChoice::value(const std::vector<char>& chosen) const {
  double sum = 0;
  for (size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) sum += problem_.items[i].gain;
  for (const auto& p : problem_.pairs)
    if (chosen[p.a] && chosen[p.b]) sum -= p.price;
  return sum;
}

// Items that share an arc with each item, and these with their neighbours too: ascending.
void LocalChoice::find_neighbours() {
  const auto tidy = [](std::vector<int>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  around_.resize(problem_.items.size());
  wide_.resize(problem_.items.size());
  for (size_t i = 0; i < around_.size(); ++i) {
    for (const int a : problem_.items[i].arcs)
      for (const Use& s : uses_[a])
        if (s.item != static_cast<int>(i)) around_[i].push_back(s.item);
    tidy(around_[i]);
  }
  for (size_t i = 0; i < around_.size(); ++i) {
    wide_[i] = around_[i];
    wide_[i].push_back(static_cast<int>(i));
    for (const int k : around_[i])
      wide_[i].insert(wide_[i].end(), around_[k].begin(), around_[k].end());
    tidy(wide_[i]);
  }
}

// Takes the items that add most, one after another.
void LocalChoice::fill(std::vector<char>& chosen, const std::vector<int>& from, int never) const {
  for (;;) {
    int best = -1;
    double most = kTie;
    for (const int i : from) {
      if (chosen[i] || i == never || fixed[i] == 0) continue;
      const double gain = advantage(chosen, i);
      if (gain > most + kTie && fits(chosen, i)) best = i, most = gain;
    }
    if (best < 0) return;
    chosen[best] = 1;
  }
}

// Forces an item in or out and mends what is around it. Returns what that changes the value by.
double LocalChoice::forced(std::vector<char>& chosen, int item, bool in, int rounds) const {
  const std::vector<int>&around = around_[item], &wide = wide_[item];
  const auto local = [&] {
    double sum = 0;
    for (const int i : wide)
      if (chosen[i]) {
        sum += problem_.items[i].gain;
        for (const auto& [other, price] : near_[i])
          if (chosen[other])
            sum -= std::binary_search(wide.begin(), wide.end(), other) ? price / 2 : price;
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
      for (const int i : around) {
        if (!chosen[i] || fixed[i] == 1) continue;
        const double gain = advantage(chosen, i);
        if ((tight ? in_the_way(chosen, i, item) : gain < 0) && gain < least)
          worst = i, least = gain;
      }
      if (worst < 0) break;
      chosen[worst] = 0;
    }
    if (!fits(chosen, item)) {
      return -HUGE_VAL;
    }
  }
  for (int r = 0; r < rounds; ++r) fill(chosen, wide, in ? -1 : item);
  return local() - before;
}

bool LocalChoice::in_the_way(const std::vector<char>& chosen, int i, int item) const {
  for (size_t k = 0; k < problem_.items[item].arcs.size(); ++k) {
    const int a = problem_.items[item].arcs[k];
    int used = problem_.items[item].uses[k];
    bool there = false;
    for (const Use& s : uses_[a])
      if (chosen[s.item] && s.item != item) used += s.uses, there |= s.item == i;
    if (there && used > problem_.room[a]) return true;
  }
  return false;
}

void LocalChoice::improve(std::vector<char>& chosen) const {
  for (bool better = true; better;) {
    better = false;
    for (size_t i = 0; i < chosen.size(); ++i) {
      if (fixed[i] >= 0) continue;
      std::vector<char> other = chosen;
      if (forced(other, static_cast<int>(i), !chosen[i]) > kTie) chosen = other, better = true;
    }
  }
}

}  // namespace batten
