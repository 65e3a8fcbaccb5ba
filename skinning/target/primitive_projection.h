// SPDX-License-Identifier: MPL-2.0
// Closest points on planes, cylinders, cones, spheres and tori, with derivatives.
#pragma once

#include <memory>
#include <vector>

#include "batten/skinning/surfaces/fitted_primitive.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// The closest point P(x) of a primitive to a point x.
struct PrimitiveProjection {
  Vec3 at, normal;  ///< P(x), and the outward unit normal of the primitive there
  /// Derivative of P: dP/dx = I - n nᵀ - d H. d is the signed distance of x, n its gradient, and H
  /// its Hessian, whose eigenvalues are the principal curvatures of the parallel surface through x.
  Mat3 slope;
};

/// Projects a point onto a primitive of any kind but Free. The result is arbitrary, but finite, on
/// the axis of a cylinder, cone or torus and at the centre of a sphere or of the tube of a torus,
/// where the closest point is not unique. At the apex of a cone, `slope` is the identity. O(1).
PrimitiveProjection project_onto(const FittedPrimitive& primitive, const Vec3& x);

/// Interpolates the projection of a shape: the surface on the mesh of `layout` that has the
/// positions and derivatives of P(S(u, v)) at the vertices, and its normal derivatives at the
/// midpoints of edges. S is the surface of `dofs`, and P projects each face onto the primitive of
/// its target. With elements of size h, the result is within O(h⁴) of the primitives. `targets`:
/// target of each face; all have a primitive(). O(vertices).
Points primitive_dofs(const ModelLayout& layout, const Points& dofs,
                      const std::vector<const TargetSurface*>& targets);

}  // namespace batten
