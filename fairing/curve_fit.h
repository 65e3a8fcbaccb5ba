// From points and input curves to few C1 cubic segments: the one curve fit of the kernel.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/input_curve.h"
#include "batten/fem/curve.h"

namespace batten {

/// Where an open curve begins or ends: exactly there, and in that direction.
struct LineEnd {
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
  std::optional<LineEnd> start, end;        ///< open curves; not given: the end points, any tangent
  /// Points keep their first parameters, chord or arc length: more segments, but u runs evenly.
  bool even = false;
  /// Nodes only by repeated halving of parameter intervals, none taken out again: for meshes whose
  /// sides are halved too.
  bool halved = false;
  int most_segments = 1 << 14;
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

/// Fits a curve that is C1 between corners, through the first and the last point and the corners
/// exactly, not farther than the tolerance from the points, both ways (Deviation::max and
/// ::between). Segments get a node more where they miss the tolerance, points move to the nearest
/// parameter after every solve, nodes that are not needed are taken out again. u is close to arc
/// length.
///
/// Two points or more; points that repeat the one before them are passed over. Cost: about
/// O(points · rounds), microseconds for a stroke of ten points.
/// Throws InputError: fewer than two distinct points, a number that is not finite, a tolerance that
/// is not above 0, a corner that is not a point, `most_segments` reached. `name` is used in
/// messages.
CurveFit fit_points(const std::string& name, const std::vector<Vec3>& points,
                    const FitOptions& options);

/// The input itself when it is piecewise cubic: corners where its direction turns by more than
/// `corner_angle`, C1 elsewhere (the parameter of each segment is scaled so that the speed goes on,
/// and u to the length of the curve). None when it is not, or has a kink below the angle.
std::optional<HermiteCurve> exact_curve(const InputCurve& curve, double corner_angle);

/// exact_curve() where there is one; otherwise, or when ends are given, nodes halved, u is to run
/// evenly or the curve to be open though it comes back, a fit to samples of the input, evenly by
/// arc length, so dense that the tolerance holds between them too. u is roughly arc length; with
/// options.even, it is so within the tolerance. Throws InputError when the tolerance cannot be
/// reached.
HermiteCurve fit_curve(const std::string& name, std::shared_ptr<const InputCurve> curve,
                       const FitOptions& options);

/// Points at which the direction turns by more than `angle` degrees, ascending, the ends of an open
/// list not among them. The direction on either side is that of the line through the neighbours
/// within reach, which is longer where the points are noisy (the noise is estimated from third
/// differences), so that noise makes no corners; of several such points side by side the sharpest
/// counts. In lists of ten points or fewer a corner has to stand alone and turn by half as much
/// again.
std::vector<int> find_corners(const std::vector<Vec3>& points, bool closed, double angle);

}  // namespace batten
