// SPDX-License-Identifier: MPL-2.0
// Regions bounded by embedded curves, built without the skinning module: a function over a trimmed
// grid.
#pragma once

#include <memory>

#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

/// A smooth sheet over the plane.
inline SurfaceJet sheet(const Vec2& p, double height = 0.15) {
  const double u = p.x(), v = p.y(), a = 2.5, b = 2.1;
  return {{u, v, height * std::sin(a * u) * std::cos(b * v)},
          {1, 0, height * a * std::cos(a * u) * std::cos(b * v)},
          {0, 1, -height * b * std::sin(a * u) * std::sin(b * v)},
          {},
          {},
          {}};
}

/// A curve in (u, v) and its image on the sheet.
inline EmbeddedLine line_on_sheet(const std::string& name, const HermiteCurve& pcurve,
                                  double height) {
  EmbeddedLine line;
  line.line.name = name;
  line.pcurve = pcurve;
  Points dofs = pcurve.dofs();
  const CurveMesh& mesh = pcurve.mesh();
  for (int i = 0; i < mesh.node_count(); ++i) {
    const SurfaceJet j = sheet(pcurve.position(i).head<2>(), height);
    const auto lifted = [&](const Vec3& d) { return Vec3(d.x() * j.x_u + d.y() * j.x_v); };
    dofs.row(mesh.position_dof(i)) = j.x;
    dofs.row(mesh.slope_in(i)) = lifted(pcurve.slope_in(i));
    dofs.row(mesh.slope_out(i)) = lifted(pcurve.slope_out(i));
  }
  line.fitted = HermiteCurve(mesh, dofs);
  return line;
}

/// The sheet inside closed curves: the first is the outline, the others are holes (in any
/// direction). `inner` curves follow them in SkinnedRegion::embedded.
inline SkinnedRegion sheet_region(const std::vector<HermiteCurve>& closed,
                                  const std::vector<HermiteCurve>& inner, double spacing,
                                  double height = 0.15) {
  std::vector<EmbeddedLine> lines;
  std::vector<std::vector<BoundarySegment>> boundary;
  std::vector<DomainLoops::Loop> loops;
  for (const HermiteCurve& curve : closed) {
    const bool counter_clockwise = DomainLoops({{curve}}).area() > 0;
    const bool reversed = counter_clockwise != lines.empty();
    boundary.push_back(
        {{BoundarySegment::Kind::Embedded, static_cast<int>(lines.size()), reversed}});
    loops.push_back({reversed ? curve.backwards() : curve});
    lines.push_back(line_on_sheet(lines.empty() ? "rim" : "hole", curve, height));
  }
  for (const HermiteCurve& curve : inner) lines.push_back(line_on_sheet("rib", curve, height));
  const DomainLoops domain(loops);
  const Vec2 extent = domain.high() - domain.low();
  const Vec2 low = domain.low() - Vec2(0.31, 0.17) * spacing;
  const EmbeddedGrid grid(squares(low, spacing, static_cast<int>(extent.x() / spacing) + 2,
                                  static_cast<int>(extent.y() / spacing) + 2),
                          domain);
  const Surface plain = interpolated(grid.mesh, TriangleElement::HCT,
                                     [&](const Vec2& p) { return sheet(p, height); });
  return {"disc", Surface(grid.mesh, plain.kind(), plain.dofs(), grid.trim),
          {},     extent.norm(),
          lines,  boundary};
}

struct WavyDisc {
  double spacing = 0.2, height = 0.15, hole = 0.25;
  bool rib = true;
};

/// A disc of radius 1 with an eccentric hole, and an arc from the boundary to the hole.
inline SkinnedRegion wavy_disc(const WavyDisc& how) {
  const Vec2 centre(0.3, 0.2);
  std::vector<HermiteCurve> inner;
  const HermiteCurve rim = circle({0, 0}, 1, 24), hole = circle(centre, how.hole, 8);
  const Vec3 from = rim.evaluate(3.9), to = hole.evaluate(3.3), direction = to - from;
  if (how.rib)
    inner.push_back(hermite(0, 1, 4, false, [=](double t, int order) {
      const Vec3 side = 0.2 * Vec3(-direction.y(), direction.x(), 0);
      if (order > 0) return Vec3(direction + (4 - 8 * t) * side);
      return Vec3(from + t * direction + 4 * t * (1 - t) * side);
    }));
  return sheet_region({rim, hole}, inner, how.spacing, how.height);
}

}  // namespace batten_test
