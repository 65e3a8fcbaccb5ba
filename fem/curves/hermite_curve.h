// SPDX-License-Identifier: MPL-2.0
// Piecewise cubic Hermite curve in space.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/cubic.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

// Closest point of a curve.

/// Parameter u of a point of a curve, and the distance of this point from a given one.
struct CurvePoint {
  double u = 0;
  double distance = 0;
};

/// Finds the closest point of any curve to p, starting from samples.
///
/// Newton's method on (X - p)·X' = 0, safeguarded by bisection, starts at each sample whose
/// distance from p is a local minimum. A minimum narrower than the spacing of the samples is
/// missed. `evaluate(u, order)`: position X(u) of the curve (order 0) and derivatives (order 1 and
/// 2). `u`: parameters of the samples, ascending; the curve must be smooth between successive
/// samples. `at_u`: points of the curve at `u`, precomputed for many calls.
template <class Evaluate>
CurvePoint closest_on_curve(const Evaluate& evaluate, const std::vector<double>& u,
                            const std::vector<Vec3>& at_u, const Vec3& p) {
  std::vector<double> distance(u.size());
  for (size_t i = 0; i < u.size(); ++i) distance[i] = (at_u[i] - p).norm();
  CurvePoint best{u.front(), std::numeric_limits<double>::infinity()};
  const size_t last = u.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    const size_t below = i == 0 ? 0 : i - 1, above = std::min(i + 1, last);
    if (distance[i] < best.distance) best = {u[i], distance[i]};
    if (distance[i] > distance[below] || distance[i] > distance[above]) continue;
    double low = u[below], high = u[above], x = u[i];
    for (int step = 0; step < 60; ++step) {
      const Vec3 d = evaluate(x, 0) - p, d1 = evaluate(x, 1);
      const double g = d.dot(d1), slope = d1.squaredNorm() + d.dot(evaluate(x, 2));
      (g > 0 ? high : low) = x;
      if (const double reached = d.norm(); reached < best.distance) best = {x, reached};
      double next = x - g / slope;
      // Rounding may put the last steps slightly outside of the bracket; they end the search.
      const bool done = slope > 0 && std::abs(next - x) <= 1e-14 * (u.back() - u.front());
      if (!(slope > 0) || !(next >= low) || !(next <= high)) next = 0.5 * (low + high);
      if (done || next == x) break;
      x = next;
    }
  }
  return best;
}
/// Finds the closest point of a curve to p as the overload with `at_u` does, but evaluates the
/// samples at the parameters `u` itself. For single calls.
template <class Evaluate>
CurvePoint closest_on_curve(const Evaluate& evaluate, const std::vector<double>& u, const Vec3& p) {
  std::vector<Vec3> at_u;
  at_u.reserve(u.size());
  for (const double t : u) at_u.push_back(evaluate(t, 0));
  return closest_on_curve(evaluate, u, at_u, p);
}

/// Piecewise cubic curve, given by a mesh and its dofs (CurveMesh, n×3): positions and derivatives
/// dX/du at the nodes. It is C1 except at corners. If the curve was fitted by arc length, its
/// parameter u is in model units.
class HermiteCurve {
 public:
  HermiteCurve() = default;
  /// `dofs`: one row per dof of the mesh, columns x, y, z. Throws InputError if the dofs are not
  /// finite or do not match the mesh.
  HermiteCurve(CurveMesh mesh, Points dofs);
  /// Constructs an open curve without corners from the parameters, positions and derivatives dX/du
  /// of its nodes. Throws InputError if there are fewer than two nodes, parameters are not strictly
  /// increasing, numbers are not finite, or counts differ.
  HermiteCurve(std::vector<double> parameters, const Points& positions, const Points& derivatives);

  const CurveMesh& mesh() const { return mesh_; }
  const Points& dofs() const { return dofs_; }
  int node_count() const { return mesh_.node_count(); }
  int segment_count() const { return mesh_.segment_count(); }
  bool closed() const { return mesh_.closed(); }
  const std::vector<double>& parameters() const { return mesh_.parameters(); }
  double start() const { return mesh_.start(); }
  double end() const { return mesh_.end(); }

  Vec3 position(int node) const { return dofs_.row(mesh_.position_dof(node)); }
  /// Derivative dX/du of the curve just before a node. slope_out(): the derivative just after the
  /// node. The two derivatives differ only at corners.
  Vec3 slope_in(int node) const { return dofs_.row(mesh_.slope_in(node)); }
  Vec3 slope_out(int node) const { return dofs_.row(mesh_.slope_out(node)); }

  /// Position (order 0) or derivative (order 1 to 3) at the curve parameter u, with respect to u. u
  /// is clamped on an open curve and wrapped on a closed one. At a node, the segment that begins
  /// there is evaluated.
  Vec3 evaluate(double u, int order = 0) const;
  /// Position (order 0) or derivative with respect to the curve parameter u (order 1 to 3), at a
  /// point given by segment and local coordinate in [0, 1].
  Vec3 evaluate(CurveMesh::SegmentPoint at, int order = 0) const;
  /// Bézier form of a segment, over its local coordinate s.
  BezierCubic<Vec3> bezier(int segment) const;
  /// Curvature at parameter u, 1/length; 0 on straight pieces.
  double curvature(double u) const;
  /// Arc length of the whole curve.
  double length() const;
  /// Point of the curve X(u) closest to p. All zeros of (X - p)·dX/du are found by subdivision, so
  /// no local minimum of the distance is missed. Cost: O(segments); exact to rounding.
  CurvePoint closest_point(const Vec3& p) const;

  /// The same curve with additional nodes at the given parameters. Parameters that are nodes
  /// already, or outside of the curve, are ignored. Segments without a new node are bit-identical.
  HermiteCurve with_nodes(std::vector<double> parameters) const;
  /// The same curve traversed in the opposite direction, over the same parameter interval.
  HermiteCurve backwards() const;
  /// The same shape with all parameters multiplied by `factor` > 0; derivatives dX/du are divided
  /// by `factor`.
  HermiteCurve with_scaled_parameter(double factor) const;

 private:
  CurveMesh mesh_;
  Points dofs_;
};

}  // namespace batten
