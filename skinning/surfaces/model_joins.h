// SPDX-License-Identifier: MPL-2.0
// Smooth (G1) joins between regions: classification of edges, groups of joined regions, refinement.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/surfaces/region_maker.h"

namespace batten {

/// Marks the triangles along a side of a join line: those next to or crossed by it. `marks`: one
/// entry per triangle of the model.
void mark_along(const ModelLayout& layout, const JoinSide& side, std::vector<char>& marks);

/// A model layout with a shape on it.
struct JoinedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// Refines the mesh along smooth joins on embedded lines until the angle between the normals is
/// small.
///
/// The angle at such a join decreases with the size of its triangles. Each round halves the
/// triangles along lines above `max_deg_allowed` (degrees), plans the joins anew from the shape and
/// minimises the bending energy. Rounds continue while the angles decrease, at most three times,
/// and not above 20,000 triangles. Joins that stay above 0.5° become creases
/// (JoinPlan::rejection_reason). If a join exceeds `max_deg_allowed` only in the mesh edge next to
/// an end, that end becomes a crease (JoinEnd::creased): elements that are cut by a line near a
/// corner of their region cannot follow both. Groups of regions without any change (join_groups())
/// keep their shape and plans.
JoinedModel refine_embedded_joins(JoinedModel model, const SurfaceStiffness& material,
                                  double max_deg_allowed, const Progress& progress = {});

// Groups of regions that are connected by smooth joins and solved together.

/// A group of regions of a model, as a model of its own.
struct RegionGroup {
  std::vector<int> regions;  ///< region indices in the model, ascending
  std::vector<std::shared_ptr<const RegionLayout>> layouts;
  std::vector<size_t> joins;    ///< indices of the model's join plans within the group
  std::vector<JoinPlan> plans;  ///< these plans, with region indices relative to the group
};

/// Partitions the regions into groups connected by join plans that are not rejected, ordered by
/// their lowest region. A region without joins is a group of its own. Null regions belong to no
/// group. Cost: O(plans log regions).
std::vector<RegionGroup> join_groups(
    const std::vector<std::shared_ptr<const RegionLayout>>& layouts,
    const std::vector<JoinPlan>& plans);

/// True if both groups have the same layouts and plans, so that a solution of one is valid for the
/// other.
bool is_same_problem(const RegionGroup& a, const RegionGroup& b);

/// Copy of a plan with new region indices; `number` maps old to new indices.
JoinPlan renumbered(JoinPlan plan, const std::map<int, int>& number);

// Classification of network edges into creases and smooth joins, for skin_network().

/// Result of classify_joins().
struct JoinClassification {
  std::vector<ModelJoin> joins;  ///< one per network edge that has a region, in the order of edges
  std::vector<JoinLine> join_lines;  ///< smooth joins; region indices of the model
  std::vector<int> join_of;          ///< for each join line, its index in `joins`
};

/// Decides for every edge whether it is a crease or a smooth join.
///
/// User specifications take precedence. Otherwise the angle at which the initial shapes of the two
/// regions meet is compared with ModelOptions::crease_angle_deg (see ModelJoin::initial_deg).
/// Throws InputError if a specification names no existing edge.
JoinClassification classify_joins(const CurveNetwork& network, const RegionMaker& maker,
                                  const ModelOptions& options,
                                  const std::vector<ModelRegion>& regions);

/// The side of a join that is a given surface: the opposite side of the edge, seen from `side`.
JoinSide beside(JoinSide side, std::shared_ptr<const NeighbourEdge> neighbour);

/// Measures the angle between the current shapes of the two regions along a join line. `open`: ends
/// of the line that are creases.
JoinQuality angle_of(const std::vector<ModelRegion>& regions, JoinLine join_line,
                     const std::array<bool, 2>& open = {});

}  // namespace batten
