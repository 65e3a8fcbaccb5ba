// Finite-element dofs that interpolate a given surface.
#pragma once

#include <functional>

#include "batten/fem/surface.h"
#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Position of a surface and its derivatives with respect to u and v (two columns).
struct FirstOrderJet {
  Vec3 x = Vec3::Zero();
  Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();
};

/// Interpolates a surface over (u, v) on a mesh. The dofs are positions and slopes at vertices, and
/// normal slopes at edge midpoints. `edge_midpoints`, unless null, receives the surface's positions
/// at edge midpoints, one row per edge; compare them with the result to see how well the mesh
/// resolves the surface. Calls `surface` once per vertex and per edge, in parallel.
Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints = nullptr);

// Annular surfaces through sections, on which the inner sections are embedded.

/// Builds a surface on the mesh of an annulus, through its boundary circles and the closed curves
/// between them, in their order.
///
/// On each line u = const it is the cubic spline through the sections. Each section lies at one v,
/// proportional to its mean distance from the section before. Its points are evenly spaced in arc
/// length over u, with the start point and direction that make it nearest to the section before.
/// O(vertices · sections).
Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element);

}  // namespace batten
