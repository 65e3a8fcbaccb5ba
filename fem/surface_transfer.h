// A surface carried over to another mesh of the same domain.
#pragma once

#include "batten/fem/surface.h"

namespace batten {

struct SurfaceTransfer {
  Points dofs;                  ///< dofs of the new mesh, dofs × 3
  double max_displacement = 0;  ///< largest |new - old| at the same (u, v), model units
};

/// The dofs of `to` that interpolate the surface: value and gradient at the vertices, slope across
/// the edges at their midpoints. `to` lies in the same domain and covers no more of it (a mesh
/// after bisected(), with or without part_of()); points outside take the nearest triangle.
///
/// Vertices, edges and triangles that both meshes have keep their dofs to the last bit. Where edges
/// are halves of old ones, shape and slope across stay exactly as they were; a cubic stays as it
/// was everywhere. Elsewhere, an old element and its children are different piecewise cubics:
/// positions move by O(h³) of the jumps of curvature inside the old element, O(h⁴) on smooth
/// shapes. `max_displacement` is taken at six points inside of each new triangle. O(triangles log
/// triangles); some ten microseconds for each that is new, on several threads.
SurfaceTransfer interpolate_onto(const Surface& from, const ParametricMesh& to);

}  // namespace batten
