// A curve with a name and points.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/curve.h"

namespace batten {

/// A curve under its name. A line that has none (a single point, say) is its points only.
struct NamedCurve {
  std::string name;
  HermiteCurve curve;              ///< default-made: none
  std::vector<double> parameters;  ///< u of the points that .curves, .csv and .obj hold
  std::vector<Vec3> points;        ///< of a line without a curve

  bool has_curve() const { return curve.segment_count() > 0; }
  /// The curve at `parameters`, or `points`.
  std::vector<Vec3> written_points() const;
};

}  // namespace batten
