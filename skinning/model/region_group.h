// Regions that smooth joins connect, and that are solved together.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Some regions of a model, as a model of their own.
struct RegionGroup {
  std::vector<int> regions;  ///< their numbers in the model, ascending
  std::vector<std::shared_ptr<const RegionLayout>> layouts;
  std::vector<size_t> joins;    ///< which plans of the model connect them
  std::vector<JoinPlan> plans;  ///< these, with the numbers that the regions have in the group
};

/// The groups of regions that plans connect that are not given up, by their lowest region. A region
/// by itself is a group without plans; regions that are null are in none. O(plans log regions).
std::vector<RegionGroup> join_groups(
    const std::vector<std::shared_ptr<const RegionLayout>>& layouts,
    const std::vector<JoinPlan>& plans);

/// Whether both have the same layouts and plans, so that one shape serves both.
bool is_same_problem(const RegionGroup& a, const RegionGroup& b);

/// The plan with other numbers for its regions: `number` has the new one of each.
JoinPlan renumbered(JoinPlan plan, const std::map<int, int>& number);

}  // namespace batten
