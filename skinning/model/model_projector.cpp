// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/model_projector.h"

#include <optional>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"

namespace batten {

ModelProjector::ModelProjector(const ModelLayout& layout, const Points& dofs)
    : projectors_made_(static_cast<size_t>(layout.region_count())) {
  regions_.reserve(static_cast<size_t>(layout.region_count()));
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& of = layout.region(r);
    Region region{
        Surface(of.mesh(), of.element(), layout.region_dofs(r, dofs), of.trim()), Box3(), {}};
    long next = 0;
    for (const auto& corners : of.mesh()->triangles()) {
      poll_every<16384>(next++);
      Box3 box;
      for (const int v : corners)
        box.extend(region.surface.dofs().row(region.surface.dof_map().vertex(v)).transpose());
      // A curved triangle may extend beyond the bounding box of its corners.
      constexpr double kBulge = 0.5;
      const Vec3 margin = Vec3::Constant(kBulge * box.diagonal().norm());
      region.box.extend(box.min() - margin);
      region.box.extend(box.max() + margin);
    }
    regions_.push_back(std::move(region));
  }
}

double ModelProjector::Region::distance_to_box(const Vec3& p) const {
  return (box.min() - p).cwiseMax(p - box.max()).cwiseMax(0).norm();
}

ModelProjector::Nearest ModelProjector::in_region(int r, const Vec3& p) const {
  const Region& region = regions_[r];
  std::call_once(projectors_made_[r],
                 [&] { region.projector = std::make_unique<SurfaceProjector>(region.surface); });
  const auto closest = region.projector->nearest(p);
  const ParametricMesh& mesh = region.surface.mesh();
  const Vec2 uv = mesh.shape(closest.where.triangle).point(closest.where.L);
  const Trim* trim = region.surface.trim().get();
  return {{r, mesh.wrapped(uv)},
          closest.where,
          closest.distance,
          !trim || trim->loops().contains(mesh.wrapped(uv))};
}

ModelProjector::Nearest ModelProjector::nearest(const Vec3& p) const {
  std::optional<Nearest> best;
  for (int r = 0; r < isize(regions_); ++r) {
    if (best && best->inside && regions_[r].distance_to_box(p) > best->distance) continue;
    const Nearest found = in_region(r, p);
    if (!best || (found.inside && !best->inside) ||
        (found.inside == best->inside && found.distance < best->distance))
      best = found;
  }
  return *best;
}

ModelProjector::Nearest ModelProjector::nearest_inside(const Vec3& p) const {
  std::optional<Nearest> best;
  for (int r = 0; r < isize(regions_); ++r) {
    const Region& region = regions_[r];
    if (best && region.distance_to_box(p) > best->distance) continue;
    Nearest found = in_region(r, p);
    if (!found.inside) {
      const auto closest = region.surface.closest_point(p);
      const ParametricMesh& mesh = region.surface.mesh();
      found = {{r, mesh.wrapped(mesh.shape(closest.where.triangle).point(closest.where.L))},
               closest.where,
               closest.distance,
               true};
    }
    if (!best || found.distance < best->distance) best = found;
  }
  return *best;
}

}  // namespace batten
