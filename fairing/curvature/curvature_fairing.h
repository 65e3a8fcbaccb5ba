// SPDX-License-Identifier: MPL-2.0
// Fairing of curves by minimising the curvature integral or its variation (minimum-energy and
// minimum-variation curves), without the smoothing springs of fair_points().
#pragma once

#include <optional>
#include <vector>

#include "batten/fairing/curvature/quintic_curve.h"

namespace batten {

/// Options of fair_curvature() and minimum_curvature_curve().
struct CurvatureFairingOptions {
  CurveFunctional functional = CurveFunctional::Variation;
  /// Maximum distance of the returned cubics from the minimising quintics; model units, above 0.
  double tolerance = 0;
  /// Number of quintic segments; at least one between adjacent fixed points. The error of the
  /// minimising curve falls with about the sixth power of this number.
  int segments = 16;
  /// Weight of the curve length, ≥ 0: length_weight · length is added to the minimised functional,
  /// for the curve scaled to size 1.
  double length_weight = 0;
  /// Weight of ∫ (d ln|X'| / du)² du for the curve X(u) scaled to size 1, above 0. The functionals
  /// do not depend on the parametrisation; this term keeps the speed uniform. Every shape has a
  /// parametrisation of uniform speed, so the term hardly affects the shape:
  /// docs/theory/curvature-fairing.md.
  double parametrization_weight = 1e-3;
  /// Maximum number of outer rounds. Each round reparametrises the curve, and then recomputes the
  /// foot points: the points of the curve closest to the data points, to which springs pull it.
  int max_rounds = 12;
  int max_iterations = 500;  ///< maximum number of Ceres iterations per round
};

/// A point of the starting curve at which the position or the tangent direction is fixed.
struct FixedCurvePoint {
  /// Parameter of the point on the starting curve.
  double u = 0;
  bool position = true;  ///< true: the position is fixed
  bool tangent = false;  ///< true: the tangent direction is fixed; the speed is free and positive
};

/// A spring that pulls the closest point of the curve towards `point`. It adds stiffness ·
/// distance² to the functional; both refer to the curve scaled to size 1. If the closest point is
/// an end of an open curve, the spring pulls that end.
struct CurveSpring {
  Vec3 point;
  double stiffness = 1;  ///< spring stiffness, dimensionless, above 0
};

/// Result of fair_curvature(): the faired curve and the course of the iteration.
struct CurvatureFairingResult {
  HermiteCurve curve;              ///< faired curve, C1 cubics; u is arc length to a few digits
  QuinticCurve quintic;            ///< the minimising C2 curve; same parameter u as `curve`
  std::vector<double> parameters;  ///< parameter of each fixed point on `curve`, in input order
  /// Maximum distance between `curve` and `quintic`, measured at samples; model units.
  double deviation = 0;
  /// Value of the minimised functional for `quintic`; unit 1/length (Energy) or 1/length³
  /// (Variation).
  double functional = 0;
  double start_functional = 0;  ///< value of the minimised functional for the initial curve
  /// Largest violation at a fixed point: distance divided by the size of the curve, or sine of the
  /// angle between the tangents.
  double max_residual = 0;
  int iterations = 0;  ///< number of Ceres iterations in all rounds
  int rounds = 0;
  /// True if the last round converged and moved neither parameters nor foot points of springs.
  bool converged = false;
};

/// True if this build includes the Ceres solver. Without Ceres, fair_curvature() and
/// minimum_curvature_curve() throw InputError.
bool have_curvature_fairing();

/// Computes a curvature functional of a curve with `points` Gauss points per segment. With 8 points
/// the relative error is 1e-9 if each segment turns by less than 45°.
double curvature_functional(const QuinticCurve& curve, CurveFunctional functional, int points = 10);

/// Fairs a curve: minimises options.functional, plus the terms of springs and
/// options.length_weight, over quintic C2 curves.
///
/// The curve gets a node at each fixed point and evenly spaced nodes between them. The minimisation
/// starts from `start` and uses Levenberg-Marquardt and then BFGS (Ceres). The result is a local
/// minimum.
///
/// C1 cubics would not suffice: the functional does not measure their curvature jumps at the nodes,
/// and refinement makes this worse. Between rounds, the curve is reparametrised by arc length and
/// the springs move to the closest points of the curve. The rounds end when neither changes any
/// more. Internally the curve is translated to the origin and scaled to size 1 (diagonal of its
/// bounding box).
///
/// Throws InputError if Ceres is missing, the tolerance is not above 0, the curve has a corner, a
/// fixed point is outside the curve or given twice, or there are fewer segments than the fixed
/// points need. It also throws InputError if there are neither two fixed positions nor two springs,
/// or a spring is not finite. Throws NoSolutionError if the curve grows without bound. Cost: about
/// O(segments · iterations), 20 µs each; fifty to a few hundred iterations.
CurvatureFairingResult fair_curvature(const HermiteCurve& start,
                                      const std::vector<FixedCurvePoint>& fixed_points,
                                      const std::vector<CurveSpring>& springs,
                                      const CurvatureFairingOptions& options);

/// A point that the curve interpolates exactly, and optionally its tangent direction there.
struct CurveThroughPoint {
  Vec3 position;
  std::optional<Vec3> tangent = {};  ///< tangent vector along the curve, of any length except zero
};

/// Computes the curve through points in the given order that minimises options.functional.
///
/// `closed`: the curve returns to the first point. The initial curve consists of cubics with the
/// given tangents; missing tangents are those of the circle through neighbouring points. Throws
/// InputError under the conditions of fair_curvature(). It also throws InputError for fewer than
/// two points (closed: three), for a point that equals the previous one, for a tangent of length
/// zero, and for a number that is not finite.
CurvatureFairingResult minimum_curvature_curve(const std::vector<CurveThroughPoint>& points,
                                               bool closed, const CurvatureFairingOptions& options);

}  // namespace batten
