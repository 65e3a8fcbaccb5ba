// SPDX-License-Identifier: MPL-2.0
// Piecewise quintic Hermite curves in space (C2, continuous curvature), and the curvature
// functionals that they minimise.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Evaluates the six basis functions of a quintic Hermite segment, or their derivatives.
///
/// `h`: parametric length of the segment. `s`: local coordinate in [0, 1], u = s h. `order`: order
/// of the derivative with respect to u, 0 to 3. The functions are the coefficients of X, X', X'' at
/// the start of the segment, followed by those at its end.
Eigen::Matrix<double, 6, 1> quintic_functions(double h, double s, int order = 0);

/// A C2 curve of quintic Hermite segments between nodes u_0 < … < u_m, with X, dX/du and d²X/du² as
/// dofs of each node. A closed curve returns to node 0 at u_m. Immutable value type.
class QuinticCurve {
 public:
  QuinticCurve() = default;
  /// `dofs`: three rows per node, X, X', X''. Throws InputError if an open curve has no segment or
  /// a closed one fewer than two, if the parameters do not increase, or if the dofs are not finite
  /// or not three rows per node.
  QuinticCurve(std::vector<double> parameters, Points dofs, bool closed = false);

  int segment_count() const { return mesh_.segment_count(); }
  int node_count() const { return mesh_.node_count(); }
  bool closed() const { return mesh_.closed(); }
  const std::vector<double>& parameters() const { return mesh_.parameters(); }
  const Points& dofs() const { return dofs_; }
  double length(int segment) const { return mesh_.length(segment); }
  /// Index of the node at the end of a segment; 0 for the last segment of a closed curve.
  int node_after(int segment) const { return segment + 1 == node_count() ? 0 : segment + 1; }
  /// Segment that contains a parameter. The parameter is clamped to the range of an open curve and
  /// wrapped on a closed one.
  CurveMesh::SegmentPoint locate(double u) const { return mesh_.locate(u); }

  /// Point of the curve (order 0) or its derivative of order 1 to 3 by the curve parameter u.
  Vec3 evaluate(CurveMesh::SegmentPoint at, int order = 0) const;
  Vec3 evaluate(double u, int order = 0) const { return evaluate(locate(u), order); }
  /// Arc length of one segment, accurate to 1e-12 if the segment turns by less than a quarter of a
  /// circle.
  double arc_length(int segment) const;

  /// Approximates the curve by C1 cubics over the same parameter.
  ///
  /// Each segment is divided into equal pieces, as many as needed for the cubic Hermite interpolant
  /// of each piece to be within `tolerance` (model units) of the curve, measured at the same u. The
  /// error of a piece of length h is h⁴ |X''''| / 384. Throws InputError if a segment would need
  /// more than 10,000 pieces.
  HermiteCurve cubics(double tolerance) const;

 private:
  CurveMesh mesh_;  // only its parameters are used, not its dof numbering
  Points dofs_;
};

// Functionals of curvature fairing.

/// Functional that a faired curve minimises; independent of the parametrisation of the curve.
enum class CurveFunctional {
  /// ∫ κ² ds of the curvature κ over the arc length s, unit 1/length: the minimum-energy curve, a
  /// thin elastic rod of free length that can slide through its points. If the curve has to turn
  /// back between its ends (a U-turn, a loop), the functional decreases as the curve grows, without
  /// bound. Then there is no minimum, and fair_curvature() throws NoSolutionError; a
  /// `length_weight` restores a minimum.
  Energy,
  /// ∫ κ'² + κ²τ² ds, unit 1/length³: the minimum-variation curve [MoretonSequin1992]. κ is the
  /// curvature, κ' its derivative by the arc length s, τ the torsion. The integrand is the squared
  /// component of d(κN)/ds normal to the curve (N: principal normal). It is (dκ/ds)² for a plane
  /// curve, vanishes only for circles and straight lines, and is smooth through inflections, where
  /// κ and N alone are not. (The full d(κN)/ds would cost κ⁴ more, also on circles.)
  Variation
};

}  // namespace batten
