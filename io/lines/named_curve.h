// A curve with a name and points.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/hermite_curve.h"

namespace batten {

/// A line by its name: a curve or, where none could be made (of a single point, for example), its
/// points only.
struct NamedCurve {
  std::string name;
  HermiteCurve curve;              ///< the curve; without segments: none
  std::vector<double> parameters;  ///< u of the points that .curves, .csv and .obj files get
  std::vector<Vec3> points;        ///< points of a line without a curve

  bool has_curve() const { return curve.segment_count() > 0; }
  /// The points of the curve at `parameters`, those that follow each other in one place once (no
  /// reader takes them twice); without a curve, `points`.
  std::vector<Vec3> written_points() const;
};

}  // namespace batten
