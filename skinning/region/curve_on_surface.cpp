#include "batten/skinning/region/curve_on_surface.h"

#include "batten/core/planar_geometry.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

HermiteCurve at_nodes(const Surface& surface, const TriangleLocator& locator,
                      const HermiteCurve& pcurve) {
  Points dofs(pcurve.mesh().dof_count(), 3);
  for (int i = 0; i < pcurve.node_count(); ++i) {
    const SurfaceJet jet = surface.jet(locator.locate(drop_z(pcurve.position(i))));
    const auto along = [&](const Vec3& c) -> Vec3 { return jet.x_u * c.x() + jet.x_v * c.y(); };
    dofs.row(pcurve.mesh().position_dof(i)) = jet.x;
    dofs.row(pcurve.mesh().slope_in(i)) = along(pcurve.slope_in(i));
    dofs.row(pcurve.mesh().slope_out(i)) = along(pcurve.slope_out(i));
  }
  return {pcurve.mesh(), std::move(dofs)};
}

}  // namespace

HermiteCurve curve_on_surface(const Surface& surface, HermiteCurve& pcurve, double tolerance) {
  constexpr int max_nodes = 4096;
  const TriangleLocator locator(surface.mesh());
  for (;;) {
    HermiteCurve curve = at_nodes(surface, locator, pcurve);
    if (2 * pcurve.node_count() > max_nodes) return curve;
    std::vector<double> further;
    for (int s = 0; s < pcurve.segment_count(); ++s)
      for (const double f : {0.25, 0.5, 0.75}) {
        const CurveMesh::SegmentPoint where{s, f};
        const Vec3 x = surface.position(locator.locate(drop_z(pcurve.evaluate(where))));
        if ((x - curve.evaluate(where)).norm() <= tolerance) continue;
        further.push_back(pcurve.parameters()[static_cast<size_t>(s)] +
                          pcurve.mesh().length(s) / 2);
        break;
      }
    if (further.empty()) return curve;
    pcurve = pcurve.with_nodes(further);
  }
}

}  // namespace batten
