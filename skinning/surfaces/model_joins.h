// Smooth joins on embedded lines: meshes that are fine enough for them.
#pragma once

#include <memory>
#include <vector>
#include <map>
#include <array>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/surfaces/region_maker.h"

namespace batten {

/// Marks the triangles that a side of a join line runs through, or along.
void mark_along(const ModelLayout& layout, const JoinSide& side, std::vector<char>& marks);

/// Carries a shape over to a finer layout of the same regions.
Points interpolate_onto(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer);

struct JoinedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// The angle at joins on embedded lines falls with the size of their triangles. This halves those
/// along lines whose angle is above `max_deg_allowed`, plans joins anew from the shape, and solves for least
/// bending, as long as the angles fall; at most three times, and no more above 20,000 triangles.
/// Joins that stay above half a degree become creases (JoinPlan::rejection_reason). Where a join stays above
/// `max_deg_allowed` in the edge beside an end only, that end becomes one (JoinEnd::creased): elements that a line
/// cuts beside a corner of their region cannot follow both. Groups of regions in which nothing
/// changes (join_groups()) keep their shape and plans.
JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double max_deg_allowed, const Progress& progress = {});


// Regions that smooth joins connect, and that are solved together.

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


// Inside of skin_network(): chooses which lines become creases and which are to be smooth.

/// What was chosen.
struct JoinClassification {
  std::vector<ModelJoin> joins;      ///< a join for every arc that has a region, by arc
  std::vector<JoinLine> join_lines;  ///< what is to be smooth; regions as the model counts them
  std::vector<int> join_of;          ///< index into `joins` of each join line
};

/// Chooses for every arc: by the user's words, or else by the angle at which the first shapes of
/// the two regions meet (ModelJoin::initial_deg). Throws InputError for words that fit no line.
JoinClassification classify_joins(const CurveNetwork& network, const RegionMaker& maker,
                                  const ModelOptions& options,
                                  const std::vector<ModelRegion>& regions);

/// Returns the angle between the present shapes of the two regions of a join line. `open`: ends
/// that are creases.
JoinQuality angle_of(const std::vector<ModelRegion>& regions, JoinLine join_line,
                     const std::array<bool, 2>& open = {});

}  // namespace batten
