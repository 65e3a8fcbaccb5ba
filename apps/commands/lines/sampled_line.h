// A line as points in their order, whatever it was given as.
#pragma once

#include <optional>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/fem/curve.h"

namespace batten {

struct SampledLine {
  std::vector<Vec3> points;
  std::optional<std::vector<int>> corners;  ///< of a curve: its own
  std::optional<bool> closed;               ///< of a curve: whether it comes back
  std::vector<Vec3> between;                ///< of a curve: further points of it, to measure by

  bool has_length() const;
};

/// Points as they are. A curve is sampled evenly by arc length in each of its stretches between
/// corners (where it turns by more than `corner_angle` degrees): about 200 points, or eight for
/// each span of a spline. Throws InputError: a curve that is not finite.
SampledLine sampled(const SourceLine& line, double corner_angle);

/// Parameters of the nearest points of the curve, in the order of the points: each is looked for
/// around `guess` (ascending). O(points).
std::vector<double> nearest_in_order(const HermiteCurve& curve, const std::vector<Vec3>& points,
                                     const std::vector<double>& guess);

}  // namespace batten
