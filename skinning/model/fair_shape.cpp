#include "batten/skinning/model/fair_shape.h"

#include <algorithm>

#include "batten/skinning/model/curvature_continuity.h"
#include "batten/skinning/model/loft_shape.h"
#include "batten/skinning/model/section_surface.h"

namespace batten {
namespace {

// Sides of the outlines that are no smooth join, in the vertices of the model.
std::vector<std::vector<int>> boundary_sides(const ModelLayout& layout) {
  std::vector<std::vector<int>> sides;
  for (const ModelLine& line : layout.lines()) {
    if (layout.join_plan(line.name)) continue;
    for (const LineSide& side : line.sides) {
      if (side.embedded) continue;
      const EdgeAlignedLine& aligned_line =
          layout.region(side.region).edge_aligned()[static_cast<size_t>(side.index)];
      if (aligned_line.line.role == CharacterLine::Role::Inner) continue;
      std::vector<int>& vertices = sides.emplace_back();
      for (const int v : aligned_line.vertices)
        vertices.push_back(layout.dof_offsets(side.region).vertices / 3 + v);
    }
  }
  return sides;
}

}  // namespace

MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options, const Progress& progress) {
  bool corners = false, inner_lines = false, rings = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& region = layout.region(r);
    corners = corners || !region.corners().empty();
    rings = rings || is_annulus(region);
    // The rims of a can's lids are embedded, and say nothing about its side.
    for (const EmbeddedLine& line : region.embedded())
      inner_lines = inner_lines || line.line.role != CharacterLine::Role::Outline;
  }
  if (corners)
    options.sides = boundary_sides(layout);
  else if (!inner_lines)
    options.gauss = 100;
  options.joins = curvature_join_points(layout);
  // Near the origin, where coordinates keep their digits.
  const VecX ones = layout.position_dofs();
  const Points origin = ones * layout.origin().transpose();
  if (rings && options.starts.empty()) options.starts = {start, loft_shape(layout, {})};
  for (Points& dofs : options.starts) dofs -= origin;
  MinimumVariationSurface result = minimize_curvature_variation(
      layout.surface(start - origin), constraints.translated(ones, layout.origin()), options,
      progress);
  result.dofs += origin;
  return result;
}

}  // namespace batten
