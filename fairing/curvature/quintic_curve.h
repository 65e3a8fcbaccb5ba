// A piecewise quintic Hermite curve in space: C2, so that its curvature is continuous.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// The six functions of a quintic segment of parametric length h, or their derivative of `order` 0
/// to 3 with respect to u = s h, s in [0, 1]. They belong to X, X', X'' at the start, then at the
/// end.
Eigen::Matrix<double, 6, 1> quintic_functions(double h, double s, int order = 0);

/// Nodes u_0 < … < u_m with X, dX/du and d²X/du², quintic between, C2 everywhere. A closed curve
/// comes back at u_m to node 0. A value.
class QuinticCurve {
 public:
  QuinticCurve() = default;
  /// dofs: three rows a node, X, X', X''. Throws InputError: fewer than two segments of a closed
  /// curve or one of an open one, parameters that do not increase, dofs that are not finite or not
  /// three rows a node.
  QuinticCurve(std::vector<double> parameters, Points dofs, bool closed = false);

  int segment_count() const { return mesh_.segment_count(); }
  int node_count() const { return mesh_.node_count(); }
  bool closed() const { return mesh_.closed(); }
  const std::vector<double>& parameters() const { return mesh_.parameters(); }
  const Points& dofs() const { return dofs_; }
  double length(int segment) const { return mesh_.length(segment); }
  /// Node at the end of a segment.
  int node_after(int segment) const { return segment + 1 == node_count() ? 0 : segment + 1; }
  /// The segment of a parameter, clamped to an open curve, come around on a closed one.
  CurveMesh::SegmentPoint locate(double u) const { return mesh_.locate(u); }

  /// Position (order 0) or derivative of order 1 to 3 with respect to u.
  Vec3 evaluate(CurveMesh::SegmentPoint at, int order = 0) const;
  Vec3 evaluate(double u, int order = 0) const { return evaluate(locate(u), order); }
  /// Length of one segment, to 1e-12 when it turns by less than a quarter of a circle.
  double arc_length(int segment) const;

  /// C1 cubics over the same parameter: each segment is cut in as many equal pieces as it takes to
  /// bring the cubic with the same ends and end derivatives within `tolerance` of it, measured at
  /// the same u. Error of a piece of length h: h⁴ |X''''| / 384. Throws InputError when a segment
  /// would need more than 10,000.
  HermiteCurve cubics(double tolerance) const;

 private:
  CurveMesh mesh_;  // of its dofs nothing is used
  Points dofs_;
};


// What curves of least curvature minimise.

/// What a curve minimises. Both depend on the shape alone, not on its parameter.
enum class CurveFunctional {
  /// ∫ κ² ds, unit 1/length: the minimum energy curve, a thin elastic rod that may slide through
  /// its points. Its length is free, and where the ends have to turn back (a U-turn, a loop) ever
  /// larger curves cost ever less: then there is no minimum, and fair_curvature() says so. A
  /// `length_weight` gives it one.
  Energy,
  /// ∫ κ'² + κ²τ² ds, unit 1/length³: the minimum variation curve (Moreton, Séquin 1992), κ' the
  /// change of curvature along the curve, τ its torsion. That is the part of d(κN)/ds normal to the
  /// curve: (dκ/ds)² of a plane curve, 0 for circles and lines only, and smooth through inflections
  /// where κ and N alone are not. (All of d(κN)/ds would cost κ⁴ more, also on circles.)
  Variation
};

}  // namespace batten
