// Smooth joins on embedded lines: meshes that are fine enough for them.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/surface_stiffness.h"
#include "batten/skinning/model/model_layout.h"

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

}  // namespace batten
