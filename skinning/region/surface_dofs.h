// Dofs that interpolate a given surface. Internal.
#pragma once

#include <functional>

#include "batten/fem/surface.h"

namespace batten {

/// A place of a surface and its derivatives by u and v.
struct SurfaceSlope {
  Vec3 x = Vec3::Zero();
  Eigen::Matrix<double, 3, 2> by_uv = Eigen::Matrix<double, 3, 2>::Zero();
};

/// Dofs on a mesh that interpolate a surface over (u, v): values and slopes at vertices, normal slopes
/// in the middle of edges. `middles`, where it is not null, gets the places of the surface at these,
/// one row an edge: they tell how well the mesh resolves it. O(vertices + edges) calls, on all threads.
Points interpolated(const ParametricMesh& mesh,
                    const std::function<SurfaceSlope(const Vec2& uv)>& surface,
                    Points* middles = nullptr);

}  // namespace batten
