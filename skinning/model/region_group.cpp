#include "batten/skinning/model/region_group.h"

#include <algorithm>
#include <tuple>

#include "batten/core/disjoint_sets.h"

namespace batten {
namespace {

// Calls `use` with each region that the rows of a join act on, which it may change.
template <class Plan, class Use>
void for_regions(Plan& plan, const Use& use) {
  for (auto& side : plan.join_line.sides) use(side.region);
  for (auto& end : plan.ends)
    for (auto& neighbours : end.set)
      for (auto& other : neighbours) use(other.side.region);
}

template <class Items, class Same>
bool all_same(const Items& a, const Items& b, const Same& same) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

auto numbers_of(const JoinSide& side) {
  return std::tie(side.region, side.embedded, side.line, side.left);
}

bool same_end(const JoinEnd& a, const JoinEnd& b) {
  const auto numbers = [](const JoinEnd& e) {
    return std::tie(e.gamma, e.delta, e.plane_angle_deg, e.open, e.undetermined);
  };
  using Neighbour = JoinEnd::Neighbour;
  const auto same = [](const Neighbour& p, const Neighbour& q) {
    return numbers_of(p.side) == numbers_of(q.side) && p.end == q.end;
  };
  return numbers(a) == numbers(b) && all_same(a.set[0], b.set[0], same) &&
         all_same(a.set[1], b.set[1], same);
}

bool same_plan(const JoinPlan& a, const JoinPlan& b) {
  const auto numbers = [](const JoinPlan& p) {
    return std::tie(p.join_line.name, p.at, p.gamma, p.delta, p.closed, p.end_conditions,
                    p.rejection_reason);
  };
  const auto same_side = [](const JoinSide& p, const JoinSide& q) {
    return numbers_of(p) == numbers_of(q);
  };
  return numbers(a) == numbers(b) && all_same(a.join_line.sides, b.join_line.sides, same_side) &&
         all_same(a.ends, b.ends, same_end);
}

}  // namespace

bool is_same_problem(const RegionGroup& a, const RegionGroup& b) {
  return a.layouts == b.layouts && all_same(a.plans, b.plans, same_plan);
}

JoinPlan renumbered(JoinPlan plan, const std::map<int, int>& number) {
  for_regions(plan, [&](int& region) { region = number.at(region); });
  return plan;
}

std::vector<RegionGroup> join_groups(
    const std::vector<std::shared_ptr<const RegionLayout>>& layouts,
    const std::vector<JoinPlan>& plans) {
  DisjointSets groups(layouts.size());
  for (const JoinPlan& plan : plans)
    if (!plan.rejected())
      for_regions(plan, [&](int r) { groups.unite(plan.join_line.sides[0].region, r); });
  std::map<int, RegionGroup> by_lowest;
  std::map<int, int> number;  // of each region in its group
  for (int r = 0; r < isize(layouts); ++r) {
    if (!layouts[r]) continue;
    RegionGroup& group = by_lowest[groups.find(r)];
    number[r] = isize(group.regions);
    group.regions.push_back(r);
    group.layouts.push_back(layouts[r]);
  }
  for (size_t s = 0; s < plans.size(); ++s) {
    if (plans[s].rejected()) continue;
    RegionGroup& group = by_lowest.at(groups.find(plans[s].join_line.sides[0].region));
    group.joins.push_back(s);
    group.plans.push_back(renumbered(plans[s], number));
  }
  std::vector<RegionGroup> all;
  for (auto& [lowest, group] : by_lowest) all.push_back(std::move(group));
  return all;
}

}  // namespace batten
