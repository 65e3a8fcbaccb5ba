// SPDX-License-Identifier: MPL-2.0
// Geometric constraints on curves, on surfaces, and along curves embedded in surfaces, as linear
// equations in the dofs.
//
// Equations of the constraints on curves:
//
//   constraint                        equations
//   point at parameter u              H(u) q = p                              uncoupled
//   derivative at u                   H'(u) q = X'                            uncoupled
//   direction at u                    r · H'(u) q = 0 for two r ⟂ tau         2 coupled
//   zero curvature at u               H''(u) q = 0                            uncoupled
//   in a plane                        n · q = d, n · q_u = 0 at all nodes     coupled
//   mirror-symmetric                  q_i = R q_j + 2 d n, q_u,i = -R q_u,j   coupled
//
// with R = I - 2 n nᵀ. A direction is constrained up to its sign; zero curvature means that the
// second derivative vanishes. Reference: [Celniker1991], section 6.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// Adds geometric constraints on one curve to a constraint set. Keeps references to mesh and set.
class CurveConstraints {
 public:
  /// Throws InputError if the constraint set does not have as many dofs as the mesh.
  CurveConstraints(const CurveMesh& mesh, ConstraintSet& set);

  /// The curve passes through `position` at parameter u.
  void point(const std::string& name, double u, const Vec3& position);
  /// The derivative dX/du of the curve at parameter u equals `derivative`.
  void derivative(const std::string& name, double u, const Vec3& derivative);
  /// The tangent of the curve at parameter u is parallel to tau, up to sign. At a corner, the
  /// tangent of the segment that begins there is constrained. Throws InputError if tau is zero.
  void direction(const std::string& name, double u, const Vec3& tau);
  /// The second derivative of the curve at parameter u vanishes.
  void zero_curvature(const std::string& name, double u);
  /// The curve lies in a plane. `n`: normal, of any length; `through`: any point of the plane.
  /// Throws InputError if n is zero.
  void in_plane(const std::string& name, const Vec3& through, const Vec3& n);
  /// The curve X(u) is mirror-symmetric about the plane through `through` with the normal n:
  /// X(start + s) is the mirror image of X(end - s). The mesh must be symmetric: node parameters to
  /// 1e-9 of the total length, corners exactly. On a closed curve, node 0 and the opposite node lie
  /// in the plane. Throws InputError if the mesh is not symmetric or n is zero.
  void symmetric(const std::string& name, const Vec3& through, const Vec3& n);

 private:
  void uncoupled(const std::string& name, double u, int order, const Vec3& value);
  const CurveMesh& mesh_;
  ConstraintSet& set_;
};

// Constraints on surfaces, as linear equations in the dofs.
//
//   constraint                     equations                            kind         exact
//   point at a location            N(where) q = p                       uncoupled    at that point
//   tangent direction at a vertex  r·(s_u q_u + s_v q_v) = 0, r ⟂ τ     2 coupled    at that vertex
//   normal direction at a vertex   n·q_u = n·q_v = 0                    2 coupled    at that vertex
//   cubic curve along edges        q and tangential slope at the nodes  uncoupled    everywhere
//   constant normal along edges    see constant_normal()                coupled      everywhere
//   varying normal along edges     see varying_normal()                 coupled      to O(h³)
//
// q are the dofs of the surface, q_u and q_v those of the derivatives at a vertex, N(where) the
// shape functions at a location. p is the prescribed position, n the prescribed normal. The tangent
// in the direction (s_u, s_v) of the domain shall be parallel to τ; r stands for two vectors
// perpendicular to τ. Uncoupled equations hold for x, y and z separately; coupled ones mix them.
//
// Directions are constrained up to their sign; a normal is constrained only if x_u × x_v ≠ 0.
// Reference: [Celniker1991], section 6; verified forms in docs/theory/elements.md.

/// Adds geometric constraints on a surface to a constraint set. Keeps references to mesh and set.
class SurfaceConstraints {
 public:
  /// Throws InputError if the constraint set does not have as many dofs as the mesh.
  SurfaceConstraints(const ParametricMesh& mesh, TriangleElement kind, ConstraintSet& set);

  /// The surface passes through `position` at a location or at a vertex: one uncoupled constraint.
  void point(const std::string& name, const Location& where, const Vec3& position);
  void point(const std::string& name, int vertex, const Vec3& position);

  /// The derivative of the surface in the direction s of (u, v) at a vertex is parallel to tau; the
  /// length and sign of the derivative are free. Two coupled equations. Throws InputError if s or
  /// tau is zero.
  void tangent(const std::string& name, int vertex, const Vec2& s, const Vec3& tau);

  /// The surface normal at a vertex is parallel to n. Two coupled equations. Throws InputError if n
  /// is zero.
  void normal(const std::string& name, int vertex, const Vec3& n);

  /// At any location of the surface, constrains the derivative in the direction s of (u, v) to be
  /// parallel to tau, or the surface normal to be parallel to n.
  void tangent(const std::string& name, const Location& where, const Vec2& s, const Vec3& tau);
  void normal(const std::string& name, const Location& where, const Vec3& n);

  /// The surface contains the given curve along a straight chain of mesh edges: prescribes the
  /// position at each vertex and the derivative along the chain, one uncoupled constraint each.
  ///
  /// `vertices`: the chain; if it runs once around a periodic mesh, the first vertex is repeated at
  /// the end. `parameters[i]`: parameter of the curve at vertices[i]. It must be proportional to
  /// the length in the domain, so that the derivative along the chain is continuous at the
  /// vertices. Between two vertices, the curve must be a single cubic. The surface then contains
  /// the curve exactly. `direction`: unit vector of the chain in (u, v). Throws InputError if the
  /// numbers of vertices and parameters differ.
  void curve(const std::string& name, const std::vector<int>& vertices,
             const std::vector<double>& parameters, const HermiteCurve& curve,
             const Vec2& direction);

  /// The surface has the normal n along whole mesh edges, exactly: the chord of each edge, the
  /// derivatives along u and v at its two ends and the normal derivative at its midpoint are
  /// perpendicular to n.
  void constant_normal(const std::string& name, const std::vector<int>& edges, const Vec3& n);

  /// The surface has the normal n(s) along mesh edges; s in [0, 1] runs from the lower-numbered end
  /// of each edge to the higher one.
  ///
  /// The derivatives across the edge and the tangent of the edge are constrained at both ends and
  /// at the midpoint, so the shape of the edge must be compatible with n. Set `edge_curve_is_fixed`
  /// if the shape of the edges is already constrained; their tangents are then not constrained
  /// again. The normal is exact at three points of each edge; in between, its error is O(h³) for
  /// edges of length h.
  void varying_normal(const std::string& name, const std::vector<int>& edges,
                      const std::function<Vec3(int edge, double s)>& n, bool edge_curve_is_fixed);

 private:
  // Constrains the derivative of the surface in the direction s of (u, v) to be perpendicular to r.
  void add_slope_constraint(const std::string& name, const Location& where, const Vec2& s,
                            const Vec3& r);

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  ConstraintSet& set_;
  DofMap dofs_;
};

// Constraints along curves that run across elements (embedded, non-conforming).
//
// The mesh does not follow the curve. The surface interpolates the curve at parameters t_k; in
// between, the gap decreases approximately as h³. Each equation has twelve coefficients, the same
// for x, y and z. The surface stays C1 across the curve, and its Jacobian stays regular where c(t)
// bends. Constraining bent chains of element edges to a smooth curve would make it singular
// (docs/theory/domains.md).
//
//   points              Σ_m N_m(c(t_k)) q_m = X(t_k)                       uncoupled
//   slopes              ∫ φ_k (∂x/∂ν - g) ds = 0                           uncoupled
//   normals             ∫ φ_k ∂x/∂ν · n ds = 0                             coupled
//
// ν is the unit normal of c (to its left), φ_k are hat functions along c over neighbouring points.
// Slopes prescribed at points instead of averages would cause stress errors of O(h); these averages
// cause errors of O(h³).

/// Density of the constraint points along an embedded curve.
struct PointSpacing {
  /// Largest step between constraint points along the curve in (u, v), relative to the local
  /// element size h. h is √(2 area of the triangle), or the length of the element edge that the
  /// curve runs along if that is longer. Below 0.35, the constraints are so dense that the surface
  /// oscillates; above 1, the surface dimples between constraint points.
  double step = 0.7;
  /// Number of additional constraint points at half steps at each end of an open curve, where the
  /// distance between surface and curve is largest.
  int extra_end_points = 0;
};

/// Parameters of the constraint points of one embedded curve, ascending. They are spaced evenly in
/// ∫ ds/h along the curve (h: local element size, see PointSpacing), and include both ends (for a
/// closed curve, the start) and all `required` parameters. `pcurve`: the curve c(t) in (u, v).
std::vector<double> embedded_point_parameters(const ParametricMesh& mesh,
                                              const TriangleLocator& locator,
                                              const HermiteCurve& pcurve,
                                              const PointSpacing& spacing = {},
                                              std::vector<double> required = {});

/// Adds constraints along embedded curves to a constraint set. Keeps references to the mesh, the
/// locator and the set.
class EmbeddedLineConstraints {
 public:
  /// Throws InputError if the constraint set does not have as many dofs as the mesh.
  EmbeddedLineConstraints(const ParametricMesh& mesh, TriangleElement kind,
                          const TriangleLocator& locator, ConstraintSet& set);

  /// The surface x interpolates a curve at the given parameters t: x(c(t)) = X(t). `pcurve`: c(t)
  /// in (u, v); `curve`: X(t) in space. Throws InputError if c(t) is not on the mesh.
  void points(const std::string& name, const HermiteCurve& pcurve, const HermiteCurve& curve,
              const std::vector<double>& parameters);
  /// The derivative of the surface across the curve `pcurve` equals g(t) on average, weighted by
  /// each of the hat functions (piecewise linear) over `parameters`. On a closed curve, the last
  /// hat function extends across the start.
  void slope(const std::string& name, const HermiteCurve& pcurve,
             const std::vector<double>& parameters, const std::function<Vec3(double t)>& g);
  /// The surface normal along the curve `pcurve` is n(t) on weighted average, as in slope(). Only
  /// the derivative across the curve is constrained, so n(t) should be perpendicular to the tangent
  /// of the curve.
  void normal(const std::string& name, const HermiteCurve& pcurve,
              const std::vector<double>& parameters, const std::function<Vec3(double t)>& n);

 private:
  using Visit = std::function<void(double t, double weight, const Vec2& nu, const Location& where)>;
  // Visits the Gauss points of each hat function φ_k; their weights φ_k ds are divided by ∫ φ_k ds.
  void integrate_hats(const HermiteCurve& pcurve, const std::vector<double>& parameters,
                      const std::function<void(size_t hat)>& begin, const Visit& visit,
                      const std::function<void()>& end) const;
  Location on_mesh(const std::string& name, const Vec2& uv) const;

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  const TriangleLocator& locator_;
  ConstraintSet& set_;
  DofMap dofs_;
};

}  // namespace batten
