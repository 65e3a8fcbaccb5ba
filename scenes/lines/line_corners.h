// SPDX-License-Identifier: MPL-2.0
// Corners of polylines in drawings and CAD files, and of curves whose corners are given.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// The vertices of a curve of straight segments (a CAD curve of degree 1); empty if the curve has a
/// curved segment, or only one segment. `curve`: collinear within 1e-12 of its size.
std::vector<Vec3> polyline_vertices(const InputCurve& curve);

/// Decides whether a polyline of a drawing or CAD file samples a smooth curve, as exporters write
/// airfoils and splines, or is a polyline for its own sake, as the outline of a hexagon.
///
/// It samples a curve if it has 15 segments or more, and the curve through its vertices, with
/// corners detected by find_corners(), is within 2e-3 of the size of the polyline. Polylines of
/// corners only are no samples. Returns the largest distance between segments and curve, measured
/// at the middle of each segment, or nothing. `points`: two or more; the first is repeated at the
/// end of closed polylines. Cost: that of curve_through_points().
std::optional<double> sampled_curve_deviation(const std::vector<Vec3>& points);

/// True if the last point of more than three is the first one, within 1e-9 of the size.
bool is_closed_polyline(const std::vector<Vec3>& points);

/// All inner vertices of a polyline, and for closed ones also the first: indices of its corners.
std::vector<int> all_corners(const std::vector<Vec3>& points);

/// A curve with other corners: at the given numbers of its breaks(), counted from 0, at all breaks
/// where its direction changes (`all`), or nowhere (an empty list: the curve is then rounded at its
/// kinks within the fitting tolerance). Throws InputError for a number above that of the breaks.
std::shared_ptr<const InputCurve> with_corners(std::shared_ptr<const InputCurve> curve, bool all,
                                               const std::vector<int>& numbers);

/// A closed curve that also has a corner where it starts and ends.
std::shared_ptr<const InputCurve> with_corner_at_seam(std::shared_ptr<const InputCurve> curve);

}  // namespace batten
