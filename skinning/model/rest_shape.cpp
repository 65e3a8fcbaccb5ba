#include "batten/skinning/model/rest_shape.h"

#include "batten/core/parallel.h"
#include "batten/skinning/model/boundary_sweep.h"
#include "batten/skinning/model/section_surface.h"

namespace batten {

Points rest_dofs(const RegionLayout& region) {
  if (!region.uses_rest_shape()) return {};
  if (is_annulus(region)) return SectionSurface(region, 0).dofs();
  const auto sweep = BoundarySweep::of(region);
  return sweep ? sweep->dofs().value_or(Points()) : Points();
}

bool has_many_sides(const RegionLayout& region) { return BoundarySweep::has_many_sides(region); }

Points rest_dofs(const ModelLayout& layout) {
  if (!layout.has_rest()) return {};
  std::vector<Points> rests(static_cast<size_t>(layout.region_count()));
  parallel_for(layout.region_count(), [&](int r) { rests[r] = rest_dofs(layout.region(r)); });
  std::vector<const Points*> of_regions;
  for (const Points& rest : rests) of_regions.push_back(&rest);
  return rest_dofs(layout, of_regions);
}

Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions) {
  Points all;
  for (int r = 0; r < layout.region_count(); ++r) {
    const Points& rest = *of_regions[static_cast<size_t>(r)];
    if (rest.rows() == 0) continue;
    if (all.rows() == 0) all = Points::Zero(layout.position_dofs().size(), 3);
    for (int d = 0; d < rest.rows(); ++d) all.row(layout.dof_offsets(r)(d)) = rest.row(d);
  }
  return all;
}

}  // namespace batten
