#include "batten/skinning/region/surface_line.h"

#include "batten/core/plane.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

HermiteCurve at_nodes(const Surface& surface, const TriangleLocator& locator,
                      const HermiteCurve& image) {
  Points dofs(image.mesh().dof_count(), 3);
  for (int i = 0; i < image.node_count(); ++i) {
    const SurfaceJet jet = surface.jet(locator.locate(flat(image.position(i))));
    const auto along = [&](const Vec3& c) -> Vec3 { return jet.x_u * c.x() + jet.x_v * c.y(); };
    dofs.row(image.mesh().position_dof(i)) = jet.x;
    dofs.row(image.mesh().slope_in(i)) = along(image.slope_in(i));
    dofs.row(image.mesh().slope_out(i)) = along(image.slope_out(i));
  }
  return {image.mesh(), std::move(dofs)};
}

}  // namespace

HermiteCurve curve_on(const Surface& surface, HermiteCurve& image, double tolerance) {
  constexpr int most_nodes = 4096;
  const TriangleLocator locator(surface.mesh());
  for (;;) {
    HermiteCurve curve = at_nodes(surface, locator, image);
    if (2 * image.node_count() > most_nodes) return curve;
    std::vector<double> further;
    for (int s = 0; s < image.segment_count(); ++s)
      for (const double f : {0.25, 0.5, 0.75}) {
        const CurveMesh::Where where{s, f};
        const Vec3 x = surface.position(locator.locate(flat(image.evaluate(where))));
        if ((x - curve.evaluate(where)).norm() <= tolerance) continue;
        further.push_back(image.parameters()[static_cast<size_t>(s)] + image.mesh().length(s) / 2);
        break;
      }
    if (further.empty()) return curve;
    image = image.with_nodes(further);
  }
}

}  // namespace batten
