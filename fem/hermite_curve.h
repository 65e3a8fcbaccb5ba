// A piecewise cubic Hermite curve in space.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/closest_on_curve.h"
#include "batten/fem/curve_mesh.h"

namespace batten {

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

}  // namespace batten
