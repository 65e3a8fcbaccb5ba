// What a curve fit is asked for, and what it gives.
#pragma once

#include <optional>
#include <vector>

#include "batten/fem/hermite_curve.h"

namespace batten {

/// Where an open curve begins or ends: exactly there, and in that direction.
struct CurveEnd {
  Vec3 position;
  Vec3 tangent;  ///< unit, along the curve
};

struct FitOptions {
  double tolerance = 0;  ///< model units, above 0
  /// A corner is a point where the direction turns by more than this, degrees in (0, 180]; see
  /// find_corners(). 180: none.
  double corner_angle = 50;
  std::optional<std::vector<int>> corners;  ///< corners given, not found: indices of points
  std::optional<bool> closed;               ///< not given: when the last point equals the first
  std::optional<CurveEnd> start, end;       ///< open curves; not given: the end points, any tangent
  /// Points keep their first parameters, chord or arc length: more segments, but u runs evenly.
  bool fixed_parameters = false;
  /// Nodes only by repeated halving of parameter intervals, none taken out again: for meshes whose
  /// sides are halved too.
  bool bisection_only = false;
  int max_segments = 1 << 14;
};

/// How far a curve and points given in an order lie apart.
struct Deviation {
  double max = 0, rms = 0;  ///< distances of the points from the curve
  /// Largest distance of the curve from the polyline through the points, beyond the bulge of a
  /// circle through neighbouring points: what the curve does between points is held by it.
  double between = 0;
};

struct CurveFit {
  HermiteCurve curve;
  std::vector<double> parameters;  ///< nearest parameter of each point, in their order
  Deviation deviation;
};

}  // namespace batten
