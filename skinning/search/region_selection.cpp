#include "batten/skinning/search/region_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/index.h"
#include "batten/skinning/search/local_choice.h"

namespace batten {
namespace {

// An item on one arc.
struct Share {
  int item, uses;
  double gain;  // its part of the item's gain
};

class Solver {
 public:
  explicit Solver(const Selection& problem)
      : problem_(problem),
        shares_(problem.room.size()),
        prices_(problem.room.size()),
        local_(problem),
        fixed_(local_.fixed) {
    for (size_t i = 0; i < problem.items.size(); ++i) {
      const auto& item = problem.items[i];
      for (size_t k = 0; k < item.arcs.size(); ++k) {
        slot_.push_back(static_cast<int>(shares_[item.arcs[k]].size()));
        shares_[item.arcs[k]].push_back(
            {static_cast<int>(i), item.uses[k], item.gain / static_cast<double>(item.arcs.size())});
      }
      first_slot_.push_back(static_cast<int>(slot_.size() - item.arcs.size()));
    }
    for (size_t a = 0; a < shares_.size(); ++a)
      prices_[a].assign(shares_[a].size() * shares_[a].size(), 0.0);
    for (const auto& p : problem.pairs) {
      const int i = place(p.arc, p.a), j = place(p.arc, p.b);
      const size_t m = shares_[p.arc].size();
      prices_[p.arc][i * m + j] += p.price;
      prices_[p.arc][j * m + i] += p.price;
    }
  }

  // The best set of one arc, with one share taken or left out by force (-1: none).
  double best(int arc, int taken, int left, std::vector<int>* set = nullptr) {
    const auto& shares = shares_[arc];
    stack_.clear();
    double value = 0;
    int room = problem_.room[arc];
    candidates_.clear();
    for (int s = 0; s < count_of(shares); ++s) {
      const int fixed = fixed_[shares[s].item];
      if (s == left || (fixed == 0 && s != taken)) continue;
      if (s == taken || fixed == 1) {
        room -= shares[s].uses;
        value += shares[s].gain;
        for (const int t : stack_) value -= prices_[arc][s * shares.size() + t];
        stack_.push_back(s);
      } else if (shares[s].gain > 0) {
        candidates_.push_back(s);
      }
    }
    if (room < 0) {
      if (set) set->clear();
      return -HUGE_VAL;
    }
    const size_t forced = stack_.size();
    found_ = stack_;
    double top = value;
    // The largest first: then most others cannot make a better set, whatever joins them.
    const auto less = [&](int a, int b) { return shares[a].gain < shares[b].gain; };
    const auto largest = std::max_element(candidates_.begin(), candidates_.end(), less);
    double most = 0;
    if (largest != candidates_.end()) {
      most = shares[*largest].gain;
      std::iter_swap(candidates_.begin(), largest);
    }
    const auto extend = [&](auto& self, size_t from, double sum, int left_room) -> void {
      for (size_t k = from; k < candidates_.size(); ++k) {
        const int s = candidates_[k];
        if (shares[s].uses > left_room) continue;
        double next = sum + shares[s].gain;
        if (next + most * (left_room - shares[s].uses) <= top + 1e-12) continue;
        for (const int t : stack_) next -= prices_[arc][s * shares.size() + t];
        stack_.push_back(s);
        if (next > top + 1e-12) top = next, found_ = stack_;
        if (left_room > shares[s].uses) self(self, k + 1, next, left_room - shares[s].uses);
        stack_.pop_back();
      }
    };
    extend(extend, 0, value, room);
    stack_.resize(forced);
    if (set) *set = found_;
    return top;
  }

  // Shares each item's gain so that its advantage is the same on all its arcs. Never raises the
  // bound.
  void share_out(int sweeps) {
    double before = HUGE_VAL;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (size_t i = 0; i < problem_.items.size(); ++i) {
        if (fixed_[i] >= 0) continue;
        const auto& arcs = problem_.items[i].arcs;
        advantages_.clear();
        for (size_t k = 0; k < arcs.size(); ++k) {
          const int s = slot_[first_slot_[i] + k];
          advantages_.push_back(best(arcs[k], s, -1) - best(arcs[k], -1, s));
        }
        const double mean = std::accumulate(advantages_.begin(), advantages_.end(), 0.0) /
                            static_cast<double>(arcs.size());
        if (!std::isfinite(mean)) continue;
        for (size_t k = 0; k < arcs.size(); ++k)
          shares_[arcs[k]][slot_[first_slot_[i] + k]].gain += mean - advantages_[k];
      }
      const double now = bound();
      if (before - now < 1e-3) break;
      before = now;
    }
  }

  double bound() {
    double sum = 0;
    for (size_t a = 0; a < shares_.size(); ++a) sum += best(static_cast<int>(a), -1, -1);
    return sum;
  }

  // The best sets of all arcs, kept while items are fixed and set free.
  struct Bests {
    std::vector<double> value;
    std::vector<std::vector<int>> set;  // items
    std::vector<int> votes;             // arcs that want each item
    double sum = 0;                     // of those values that are finite
    int impossible = 0;                 // arcs with more fixed uses than room

    double top() const { return impossible > 0 ? -HUGE_VAL : sum; }
    void count(double of_arc, int times) {
      if (std::isfinite(of_arc))
        sum += times * of_arc;
      else
        impossible += times;
    }
  };

  void renew(Bests& bests, int arc) {
    for (const int i : bests.set[arc]) --bests.votes[i];
    std::vector<int>& set = bests.set[arc];
    bests.count(bests.value[arc], -1);
    bests.value[arc] = best(arc, -1, -1, &set);
    bests.count(bests.value[arc], 1);
    for (int& s : set) {
      s = shares_[arc][s].item;
      ++bests.votes[s];
    }
  }

  Bests all_bests() {
    Bests bests{std::vector<double>(shares_.size()), std::vector<std::vector<int>>(shares_.size()),
                std::vector<int>(problem_.items.size(), 0)};
    for (size_t a = 0; a < shares_.size(); ++a) renew(bests, static_cast<int>(a));
    return bests;
  }

  // Branch and bound over the items that are free.
  void search(Bests& bests, const std::vector<int>& items, std::vector<char>& lead,
              double& lead_value) {
    if (work_left_ < 0) {
      cut_ = true;
      return;
    }
    const double top = bests.top();
    if (top <= lead_value + LocalChoice::kTie) return;
    int doubt = -1, widest = 0;
    for (const int i : items) {
      const int all = count_of(problem_.items[i].arcs);
      const int split = std::min(bests.votes[i], all - bests.votes[i]);
      if (fixed_[i] < 0 && split > widest) doubt = i, widest = split;
    }
    if (doubt < 0) {
      lead_value = top;
      for (const int i : items) lead[i] = bests.votes[i] > 0;
      return;
    }
    for (const int in : {1, 0}) {
      fixed_[doubt] = static_cast<signed char>(in);
      work_left_ -= static_cast<long>(problem_.items[doubt].arcs.size());
      for (const int a : problem_.items[doubt].arcs) renew(bests, a);
      search(bests, items, lead, lead_value);
    }
    fixed_[doubt] = -1;
    for (const int a : problem_.items[doubt].arcs) renew(bests, a);
  }

  // Settles the items that no choice better than `value` can have the other way.
  void settle(double value) {
    const double gap = bound() - value + 1e-7;
    for (size_t i = 0; i < problem_.items.size(); ++i) {
      if (fixed_[i] >= 0) continue;
      const auto& arcs = problem_.items[i].arcs;
      double with = 0, without = 0;
      for (size_t k = 0; k < arcs.size(); ++k) {
        const int s = slot_[first_slot_[i] + k];
        const double top = best(arcs[k], -1, -1);
        with += top - best(arcs[k], s, -1);
        without += top - best(arcs[k], -1, s);
      }
      if (with > gap) fixed_[i] = 0;
      if (without > gap && with <= gap) fixed_[i] = 1;
    }
  }

  // Free items that share arcs with each other.
  std::vector<std::vector<int>> clusters() const {
    std::vector<std::vector<int>> all;
    std::vector<char> seen(problem_.items.size(), 0);
    for (size_t first = 0; first < seen.size(); ++first) {
      if (seen[first] || fixed_[first] >= 0) continue;
      std::vector<int> cluster{static_cast<int>(first)};
      seen[first] = 1;
      for (size_t k = 0; k < cluster.size(); ++k)
        for (const int i : local_.around(cluster[k]))
          if (!seen[i] && fixed_[i] < 0) seen[i] = 1, cluster.push_back(i);
      std::sort(cluster.begin(), cluster.end());
      all.push_back(std::move(cluster));
    }
    return all;
  }

  Selected solve(long most_work) {
    share_out(20);
    Selected result;
    const Bests first = all_bests();
    result.chosen.assign(problem_.items.size(), 0);
    std::vector<int> agreed, rest;
    for (size_t i = 0; i < problem_.items.size(); ++i)
      (first.votes[i] == count_of(problem_.items[i].arcs) ? agreed : rest)
          .push_back(static_cast<int>(i));
    local_.fill(result.chosen, agreed);
    local_.fill(result.chosen, rest);
    local_.improve(result.chosen);
    result.value = local_.value(result.chosen);
    for (int round = 0; round < 3; ++round) {
      result.bound = bound();
      if (result.bound - result.value <= 1e-7) break;
      settle(result.value);
      share_out(5);
    }
    result.bound = bound();
    if (result.bound - result.value > 1e-7) {
      const auto parts = clusters();
      for (const auto& part : parts)
        for (const int i : part) fixed_[i] = static_cast<signed char>(result.chosen[i]);
      bool all = true;
      Bests bests = all_bests();
      const auto renew_around = [&](const std::vector<int>& part) {
        for (const int i : part)
          for (const int a : problem_.items[i].arcs) renew(bests, a);
      };
      double lead = local_.value(result.chosen);
      for (const auto& part : parts) {
        for (const int i : part) fixed_[i] = -1;
        renew_around(part);
        work_left_ = most_work / static_cast<long>(parts.size());
        cut_ = false;
        search(bests, part, result.chosen, lead);
        all = all && !cut_;
        for (const int i : part) fixed_[i] = static_cast<signed char>(result.chosen[i]);
        renew_around(part);
      }
      result.value = local_.value(result.chosen);
      if (all) result.bound = result.value;
    }
    result.optimal = result.bound - result.value <= 1e-6;
    return result;
  }

 private:
  int place(int arc, int item) const {
    const auto& arcs = problem_.items[item].arcs;
    return slot_[first_slot_[item] +
                 static_cast<int>(std::find(arcs.begin(), arcs.end(), arc) - arcs.begin())];
  }

  const Selection& problem_;
  std::vector<std::vector<Share>> shares_;   // of each arc
  std::vector<std::vector<double>> prices_;  // of each arc, m × m
  std::vector<int> slot_, first_slot_;       // where an item stands on each of its arcs
  LocalChoice local_;
  std::vector<signed char>& fixed_;
  std::vector<int> stack_, candidates_, found_;
  std::vector<double> advantages_;
  long work_left_ = 0;
  bool cut_ = false;
};

}  // namespace

Selected select(const Selection& problem, long most_work) {
  return Solver(problem).solve(most_work);
}

std::vector<Otherwise> otherwise(const Selection& problem, const Selected& selected) {
  const LocalChoice local(problem);
  std::vector<Otherwise> all(problem.items.size());
  std::vector<char> other = selected.chosen;
  for (size_t i = 0; i < all.size(); ++i) {
    const std::vector<int> near = local.wide(static_cast<int>(i));
    all[i].loss = -local.forced(other, static_cast<int>(i), !selected.chosen[i], near);
    for (const int k : near)
      if (other[k] != selected.chosen[k]) {
        (other[k] ? all[i].in : all[i].out).push_back(k);
        other[k] = selected.chosen[k];
      }
  }
  return all;
}

}  // namespace batten
