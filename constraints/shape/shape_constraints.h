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
#include <functional>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

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


// Geometric constraints as rows on the dofs of a surface.
//
//   constraint                     rows                                 kind         holds
//   point at a location            N(where) q = p                       uncoupled    at that point
//   tangent direction at a vertex  r·(s_u q_u + s_v q_v) = 0, r ⟂ τ     2 coupled    at that vertex
//   normal direction at a vertex   n·q_u = n·q_v = 0                    2 coupled    at that vertex
//   cubic curve along edges        q and tangential slope at the nodes  uncoupled    everywhere
//   constant normal along edges    see constant_normal()                coupled      everywhere
//   varying normal along edges     see varying_normal()                 coupled      to O(h³)
//
// A direction is held up to its sign, and a normal only where x_u × x_v ≠ 0.
// Source: Celniker and Gossard 1991, section 6; verified forms in docs/theory/elements.md.

/// Adds geometric constraints of one surface mesh to a set. Keeps references to both.
class SurfaceConstraints {
 public:
  /// The set's dof count must be the mesh's. Throws InputError otherwise.
  SurfaceConstraints(const ParametricMesh& mesh, TriangleElement kind, ConstraintSet& set);

  /// Position of one point of the surface: one uncoupled row.
  void point(const std::string& name, const Location& where, const Vec3& position);
  void point(const std::string& name, int vertex, const Vec3& position);

  /// The derivative in parametric direction s at a vertex is parallel to tau (length and sign
  /// free): two coupled rows. Throws InputError when s or tau is zero.
  void tangent(const std::string& name, int vertex, const Vec2& s, const Vec3& tau);

  /// The normal at a vertex is parallel to n: two coupled rows. Throws InputError when n is zero.
  void normal(const std::string& name, int vertex, const Vec3& n);

  /// Tangent and normal at any point of the surface, by rows of N_u and N_v there.
  void tangent(const std::string& name, const Location& where, const Vec2& s, const Vec3& tau);
  void normal(const std::string& name, const Location& where, const Vec3& n);

  /// The surface is the given curve along a straight run of edges: at each vertex its position, and
  /// its derivative along the run. `parameters[i]` is the curve's parameter at vertices[i]; it must
  /// run evenly with length in the domain (the parameter speed |X'|/|e| is then continuous), and
  /// between two vertices the curve must be one cubic. Exact on the whole run. `direction`: unit
  /// vector of the run in (u, v). A run once around a periodic mesh names its first vertex again at
  /// the end. One uncoupled row each. Throws InputError on counts that differ.
  void curve(const std::string& name, const std::vector<int>& vertices,
             const std::vector<double>& parameters, const HermiteCurve& curve,
             const Vec2& direction);

  /// Normal n on whole edges: (q_b - q_a)·n = 0, q_u·n = q_v·n = 0 at both ends, q_n·n = 0 at the
  /// middle. Exact.
  void constant_normal(const std::string& name, const std::vector<int>& edges, const Vec3& n);

  /// Normal n(s) along edges, s in [0, 1] from the lower-numbered end of each edge to the higher.
  /// Cross slopes are held at both ends and the middle, the edge's own tangent too, so its shape
  /// must allow it; set `edge_curve_is_fixed` when the edge's curve is held already. Exact at three
  /// points of each edge, O(h³) between.
  void varying_normal(const std::string& name, const std::vector<int>& edges,
                      const std::function<Vec3(int edge, double s)>& n, bool edge_curve_is_fixed);

 private:
  // (s · grad x) · r = 0 at a point.
  void add_slope_constraint(const std::string& name, const Location& where, const Vec2& s,
                            const Vec3& r);

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  ConstraintSet& set_;
  DofMap dofs_;
};


// Rows that hold a surface on curves that run across its elements.
//
// The grid ignores the line. At parameters t_k the surface goes through the curve, in between it
// nearly does: the gap falls with about h³. Twelve coefficients a row, the same for x, y and z; the
// surface stays C1 across the line, its Jacobian regular wherever c(t) bends (pinning a smooth line
// to bent element edges makes it singular, docs/theory/domains.md).
//
//   point rows          Σ_m N_m(c(t_k)) q_m = X(t_k)                       uncoupled
//   slope rows          ∫ φ_k (∂x/∂ν - g) ds = 0                           uncoupled
//   normal rows         ∫ φ_k ∂x/∂ν · n ds = 0                             coupled
//
// with ν the unit normal of c (to its left), φ_k hat functions along c over neighbouring points.
// Slopes at points instead of averages would be wrong for stress by h, these by h³.

struct PointSpacing {
  /// Largest step over the local size h = √(2 area of the triangle), or the edge that the line runs
  /// along where that is longer, measured along c. Below 0.35 the rows hold the surface so tightly
  /// that it waves, above 1 it dimples.
  double step = 0.7;
  /// A line's open ends are where the gap is largest: this many further points at half steps.
  int extra_end_points = 0;
};

/// Parameters of the points of one line: evenly in ∫ ds/h(c(t)) between its ends, both among them
/// (of a closed line the start), and between the parameters of `required`, which are among them too.
/// They ascend. `pcurve`: c.
std::vector<double> embedded_point_parameters(const ParametricMesh& mesh,
                                              const TriangleLocator& locator,
                                              const HermiteCurve& pcurve,
                                              const PointSpacing& spacing = {},
                                              std::vector<double> required = {});

/// Adds rows of embedded lines to a set. Keeps references to all three.
class EmbeddedLineConstraints {
 public:
  /// The set's dof count must be the mesh's. Throws InputError otherwise.
  EmbeddedLineConstraints(const ParametricMesh& mesh, TriangleElement kind,
                          const TriangleLocator& locator, ConstraintSet& set);

  /// x(c(t)) = X(t) at the parameters. Throws InputError where c(t) is not on the mesh.
  void points(const std::string& name, const HermiteCurve& pcurve, const HermiteCurve& curve,
              const std::vector<double>& parameters);
  /// The slope across the line is g(t) on the average of each hat over `parameters` (of a closed
  /// line, the last hat reaches over the start).
  void slope(const std::string& name, const HermiteCurve& pcurve,
             const std::vector<double>& parameters, const std::function<Vec3(double t)>& g);
  /// The normal is n(t) on the same averages, as far as the line itself lets it: the line's own
  /// tangent should be at right angles to n.
  void normal(const std::string& name, const HermiteCurve& pcurve,
              const std::vector<double>& parameters, const std::function<Vec3(double t)>& n);

 private:
  using Visit = std::function<void(double t, double weight, const Vec2& nu, const Location& where)>;
  // Gauss points under each hat: weight = φ_k ds over the hat's length.
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
