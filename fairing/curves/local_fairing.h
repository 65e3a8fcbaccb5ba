// SPDX-License-Identifier: MPL-2.0
// Local fairing: replaces a part of a curve by a fairer one that joins with continuous curvature.
#pragma once

#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Part of a curve between two of its parameters, from < to. On a closed curve, `to` may exceed
/// end(); the part then crosses the seam.
struct CurvePart {
  double from = 0, to = 0;
};

/// Arc length of a part of a curve.
double part_length(const HermiteCurve& curve, const CurvePart& part);

/// The parts of a curve inside a sphere, ascending. On a closed curve, a part may cross the seam.
///
/// A part that enters and leaves the sphere between two of 32 samples per segment is missed, unless
/// it contains the point closest to the centre. Empty if the curve does not meet the sphere.
/// O(segments).
std::vector<CurvePart> parts_inside(const HermiteCurve& curve, const Vec3& centre, double radius);

/// Fairs one part of a curve. The other segments stay bit-identical; a segment that a border of the
/// part cuts keeps its shape up to rounding.
///
/// The faired part X minimises
///
///     ∫ |X - X⁰|² + a⁶ |X_uuu|² + c (3a² |X_u - Q_u|² + 3a⁴ |X_uu - Q_uu|²) du
///
/// over the cubic splines with continuous second derivative, with the given curve X⁰ and arc length
/// u. At both borders of the part, position, first and second derivative are those of the curve
/// outside, so that the curvature is continuous there. Ends of an open curve and corners keep their
/// position only. If the part is a whole closed curve without corners, X is periodic.
///
/// With c = 0, a = wavelength/2π: away from the borders, a wave of length v keeps 1 / (1 +
/// (wavelength/v)⁶) of its height. Such a sharp filter may surround a single bump with ripples. If
/// the curve would get more curvature extrema than before, c is increased in steps up to 1, with a
/// such that a wave of length `wavelength` still keeps half of its height. With c = 1, the transfer
/// function 1 / (1 + a²ω²)³ has real poles only, so that the filter is variation diminishing
/// [Schoenberg1951]: away from the borders, it adds no extrema. Q is the fairest curve in place of
/// the part (wavelength → ∞), so that the terms with c do not pull the shape straight. If no c is
/// large enough, the wavelength is reduced, to a quarter at most. If that does not help either, the
/// result is the given curve. Extrema are counted by fairness(), with the largest curvature before
/// as scale.
///
/// Waves longer than the part cannot be removed: above four times the length of the part, the
/// wavelength has no effect. The knots are at most wavelength/24 and 1/72 of the length of the part
/// apart, but at most 4000 in number.
///
/// Throws InputError unless from < to and 0 < wavelength < ∞. O(knots + segments).
HermiteCurve fair_part(const HermiteCurve& curve, CurvePart part, double wavelength);

}  // namespace batten
