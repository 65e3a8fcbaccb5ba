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
#pragma once

#include <functional>
#include <string>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/hermite_curve.h"
#include "batten/fem/surface.h"

namespace batten {

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

}  // namespace batten
