// Dofs that interpolate a given surface. Internal.
#pragma once

#include <functional>

#include "batten/fem/surface.h"

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

}  // namespace batten
