// Geometric constraints as rows on the dofs of a curve.
//
//   constraint                        rows
//   point at parameter u              H(u) q = p                              uncoupled
//   derivative at u                   H'(u) q = X'                            uncoupled
//   direction at u                    r · H'(u) q = 0 for two r ⟂ tau         2 coupled
//   no curvature at u                 H''(u) q = 0                            uncoupled
//   in a plane                        n · q = d, n · q_u = 0 at all nodes     coupled
//   mirror image of itself            q_i = R q_j + 2 d n, q_u,i = -R q_u,j   coupled
//
// with R = I - 2 n nᵀ. A direction is held up to its sign; no curvature means no second derivative.
// Source: Celniker and Gossard 1991, section 6.
#pragma once

#include <string>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/curve_mesh.h"

namespace batten {

/// Adds geometric constraints of one curve to a set. Keeps references to both.
class CurveConstraints {
 public:
  /// The set's dof count must be the mesh's. Throws InputError otherwise.
  CurveConstraints(const CurveMesh& mesh, ConstraintSet& set);

  void point(const std::string& name, double u, const Vec3& position);
  /// dX/du has this length and direction.
  void derivative(const std::string& name, double u, const Vec3& derivative);
  /// The curve runs along tau; at a corner, the side that begins there does. Throws InputError when
  /// tau is zero.
  void direction(const std::string& name, double u, const Vec3& tau);
  void zero_curvature(const std::string& name, double u);
  /// n: unit normal, through: any point of the plane. Throws InputError when n is zero.
  void in_plane(const std::string& name, const Vec3& through, const Vec3& n);
  /// X(start + s) is the mirror image of X(end - s). The mesh has to be symmetric: parameters to
  /// 1e-9 of its length, corners exactly; on a closed one nodes 0 and half way lie in the plane.
  /// Throws InputError otherwise, and when n is zero.
  void symmetric(const std::string& name, const Vec3& through, const Vec3& n);

 private:
  void uncoupled(const std::string& name, double u, int order, const Vec3& value);
  const CurveMesh& mesh_;
  ConstraintSet& set_;
};

}  // namespace batten
