// A piecewise cubic Hermite curve in space.
#pragma once

#include <vector>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "batten/core/eigen.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

// The point of a curve that is nearest to another point.

struct CurvePoint {
  double u = 0;
  double distance = 0;
};

/// The nearest point of a curve. It is looked for from each parameter of `u` (ascending; the curve
/// is smooth between neighbours) at which the distance is a local minimum: by Newton's method on
/// (X - p)·X' = 0, by bisection where it leaves the two neighbours. `evaluate(u, order)` takes
/// orders 0 to 2. A minimum narrower than the samples is missed. `at_u`: the points there, for
/// many calls.
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
      // Rounding may put the last steps a hair outside of the bracket: those end the search.
      const bool done = slope > 0 && std::abs(next - x) <= 1e-14 * (u.back() - u.front());
      if (!(slope > 0) || !(next >= low) || !(next <= high)) next = 0.5 * (low + high);
      if (done || next == x) break;
      x = next;
    }
  }
  return best;
}
template <class Evaluate>
CurvePoint closest_on_curve(const Evaluate& evaluate, const std::vector<double>& u, const Vec3& p) {
  std::vector<Vec3> at_u;
  at_u.reserve(u.size());
  for (const double t : u) at_u.push_back(evaluate(t, 0));
  return closest_on_curve(evaluate, u, at_u, p);
}


/// A mesh and its dofs (CurveMesh, n×3): position and derivative dX/du at the nodes, cubic between,
/// C1 but for corners. u is in model units when the curve was fitted by arc length. A value.
class HermiteCurve {
 public:
  HermiteCurve() = default;
  /// Throws InputError when the dofs are not finite or not as many as the mesh has.
  HermiteCurve(CurveMesh mesh, Points dofs);
  /// Open and without corners. Throws InputError: fewer than two nodes, parameters not strictly
  /// increasing, numbers not finite, counts that differ.
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
  /// dX/du just before and just after a node; they differ at corners only.
  Vec3 slope_in(int node) const { return dofs_.row(mesh_.slope_in(node)); }
  Vec3 slope_out(int node) const { return dofs_.row(mesh_.slope_out(node)); }

  /// Position (order 0) or derivative of order 1 to 3 with respect to u. u is clamped to an open
  /// curve and comes around on a closed one; at a node, the segment that begins there answers.
  Vec3 evaluate(double u, int order = 0) const;
  /// Position or derivative at s in [0, 1] of a segment.
  Vec3 evaluate(CurveMesh::SegmentPoint at, int order = 0) const;
  /// Curvature, unit 1/length; 0 on a straight piece.
  double curvature(double u) const;
  double length() const;
  /// The nearest point of the curve: of all zeros of (X - p)·X', found by subdivision, so that none
  /// is missed. O(segments), exact to rounding.
  CurvePoint closest_point(const Vec3& p) const;

  /// The same curve with further nodes at the given parameters (those that are nodes, or outside,
  /// are passed over). Segments without a new node keep their bits.
  HermiteCurve with_nodes(std::vector<double> parameters) const;
  /// The same curve run from its end to its start, over the same parameter interval.
  HermiteCurve backwards() const;
  /// The same shape with `factor` times the parameter, slopes over it. factor > 0.
  HermiteCurve with_scaled_parameter(double factor) const;

 private:
  CurveMesh mesh_;
  Points dofs_;
};


// Hermite curves as B-splines, without a change of shape.

/// A clamped cubic B-spline: `knots` increase, the first and the last four times, an inner one
/// twice where the curve is C1 only, once where it is C2 to rounding (1e-13 of its size).
struct CubicSpline {
  std::string name;
  std::vector<double> knots;  ///< the curve's own u
  std::vector<int> multiplicities;
  std::vector<Vec3> poles;
  bool closed = false;  ///< comes back to its first pole, smoothly
  double size = 0;      ///< diagonal of the box around its poles
};

/// Each stretch between corners, in their order along the curve; named `name`, or name.1, name.2,
/// … when there are several. A closed curve with corners begins at its first corner. O(segments).
std::vector<CubicSpline> cubic_splines(const std::string& name, const HermiteCurve& curve);

}  // namespace batten
