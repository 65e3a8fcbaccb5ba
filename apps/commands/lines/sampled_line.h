// Samples a line: any line becomes points in their order.
#pragma once

#include <optional>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/fem/curve.h"

namespace batten {

/// The points of a line; the rest is known of a line that is given as a curve.
struct SampledLine {
  std::vector<Vec3> points;
  std::optional<std::vector<int>> corners;  ///< indices of the points at the curve's corners
  std::optional<bool> closed;               ///< whether the curve is closed
  std::vector<Vec3> between;                ///< further points, to measure deviations

  bool has_length() const;
};

/// Samples a line. Points are kept as they are. A curve is sampled evenly by arc length in each of
/// its stretches between corners (where it turns by more than `corner_angle` degrees): about 200
/// points, or eight for each span of a spline. Throws InputError: a curve that is not finite.
SampledLine sampled(const SourceLine& line, double corner_angle);

/// The parameters of the curve's nearest points, ascending in the order of `points`. Each is looked
/// for around its `guess` (ascending). O(points).
std::vector<double> nearest_in_order(const HermiteCurve& curve, const std::vector<Vec3>& points,
                                     const std::vector<double>& guess);

}  // namespace batten
