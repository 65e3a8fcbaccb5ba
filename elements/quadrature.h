// Quadrature rules on one segment and one triangle.
//
// Triangle rules give barycentric points L (one a row) and weights that sum to 1: multiply by the
// triangle's area. Segment rules live on [0, 1], weights sum to 1: multiply by the length.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

struct SegmentRule {
  VecX s;        ///< points in (0, 1)
  VecX weights;  ///< sum to 1
};

struct TriangleRule {
  Points L;      ///< barycentric coordinates, one point a row
  VecX weights;  ///< sum to 1
};

/// The Gauss-Legendre rule with n points, exact to degree 2n-1. n ≥ 1; cost O(n²), computed by
/// Newton's method on the Legendre recurrence to the last bits.
SegmentRule gauss_legendre(int n);

/// Symmetric rule with positive weights, exact to `degree` = 1, 2, 4, 5, 6 or 8 (1, 3, 6, 7, 12, 16
/// points; other degrees up to 8 give the next one). Throws InputError above 8.
/// For polynomials only: on the rational functions of the Z12 triangle these rules converge
/// algebraically at best (12 % error in the bending stiffness at degree 6).
TriangleRule symmetric_triangle_rule(int degree);

/// The symmetric rule of `degree` on each of the three sub-triangles (V_j, V_k, centroid): exact
/// for the piecewise polynomials of the HCT triangle. Points are ordered by sub-triangle.
TriangleRule split_triangle_rule(int degree);

/// Six-Duffy rule with 6 m² points for the Z12 triangle, whose functions are singular at the
/// vertices only. The triangle is split into the six triangles (V_i, midpoint of an edge at V_i,
/// centroid); on each, m×m Gauss points (r, t) of the unit square are mapped to barycentric
/// (1-r, r(1-t), rt), which collapses an edge into V_i and makes the integrand smooth there.
/// Error of the bending stiffness of a well-shaped triangle: m = 3: 6e-4, 5: 8e-7, 7: 5e-10,
/// 10: 8e-15.
TriangleRule six_duffy_rule(int m);

}  // namespace batten
