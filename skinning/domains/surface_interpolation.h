// Dofs that interpolate a given surface. Internal.
#pragma once

#include <functional>

#include "batten/fem/surface.h"
#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// A place of a surface and its derivatives by u and v.
struct FirstOrderJet {
  Vec3 x = Vec3::Zero();
  Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();
};

/// Dofs on a mesh that interpolate a surface over (u, v): values and slopes at vertices, normal slopes
/// in the middle of edges. `edge_midpoints`, where it is not null, gets the places of the surface at these,
/// one row an edge: they tell how well the mesh resolves it. O(vertices + edges) calls, on all threads.
Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints = nullptr);


// Rings that run through sections: the surface on which their inner sections are laid. Internal.

/// A surface on the mesh of a ring through its rims and closed curves between them, in their order:
/// on each line u = const the cubic spline through the sections. Each section lies at one v, by the mean
/// distance from the one before, and runs evenly over u from the phase and in the direction in which
/// it is nearest to the section before. O(vertices · sections).
Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element);

}  // namespace batten
