// SPDX-License-Identifier: MPL-2.0
// Quadrature rules on a segment and on a triangle.
//
// Triangle rules consist of barycentric points L and weights that sum to 1; multiply by the area of
// the triangle. Segment rules are defined on [0, 1] with weights that sum to 1; multiply by the
// length. Rules have no state: if a rule is used often, compute it once (static const).
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Quadrature rule on the segment [0, 1].
struct SegmentRule {
  VecX s;        ///< quadrature points in (0, 1), ascending
  VecX weights;  ///< one weight per point, above 0; the sum of the weights is 1
};

/// Quadrature rule on a triangle.
struct TriangleRule {
  Points L;      ///< barycentric coordinates of the n quadrature points, n×3
  VecX weights;  ///< one weight per point, above 0; the sum is 1 (multiply by the area)
};

/// Gauss-Legendre rule on [0, 1] with n ≥ 1 points, exact for polynomials up to degree 2n-1. Throws
/// InputError if n < 1. The points are computed to rounding by Newton's method on the Legendre
/// recurrence. Cost: O(n²).
SegmentRule gauss_legendre(int n);

/// Symmetric triangle rule with positive weights, exact for polynomials up to `degree`.
///
/// There are rules of degree 1, 2, 4, 5, 6 and 8, with 1, 3, 6, 7, 12 and 16 points; for other
/// degrees up to 8 the next higher rule is returned [Dunavant1985]. Throws InputError for a degree
/// below 0 or above 8. Do not use these rules for the rational functions of the Z12 triangle, for
/// which they converge algebraically at best (12 % error of the bending stiffness at degree 6).
TriangleRule symmetric_triangle_rule(int degree);

/// Applies symmetric_triangle_rule() to each of the three sub-triangles between the centroid and
/// the edges of a triangle. The rule is exact for piecewise polynomials up to `degree`, such as the
/// functions of the HCT triangle. It has three times as many points as symmetric_triangle_rule(),
/// ordered by sub-triangle. Throws InputError for a degree below 0 or above 8.
TriangleRule split_triangle_rule(int degree);

/// Six-Duffy rule with 6 m² points for the Z12 triangle, whose functions are singular only at the
/// vertices.
///
/// The triangle is split into six triangles, each of which joins a vertex V, the midpoint of an
/// edge at V, and the centroid. On each of them, m×m Gauss points (r, t) of the unit square are
/// mapped to the barycentric coordinates (1-r, r(1-t), rt). This Duffy transformation collapses an
/// edge into V and makes the integrand smooth there ([Duffy1982]). Relative error of the bending
/// stiffness of a well-shaped triangle: 6e-4 for m = 3, 8e-7 for m = 5, 5e-10 for m = 7, 8e-15 for
/// m = 10. Throws InputError for m < 1. Cost: O(m²).
TriangleRule six_duffy_rule(int m);

}  // namespace batten
