// Curves of least curvature, and of least change of curvature: fairing without springs to bend
// against.
#pragma once

#include <optional>
#include <vector>

#include "batten/fairing/curvature/quintic_curve.h"

namespace batten {

struct CurvatureFairingOptions {
  CurveFunctional functional = CurveFunctional::Variation;
  /// Largest distance of the returned cubics from the quintic curve; model units, above 0.
  double tolerance = 0;
  /// Quintic segments, at least one between held points. The error of the minimising curve falls
  /// with the sixth power (Energy: about the same).
  int segments = 16;
  /// Adds length_weight · length, both of the curve scaled to size 1; ≥ 0.
  double length_weight = 0;
  /// Weight of ∫ (d ln|X'| / du)² du on the curve scaled to size 1, above 0. The functionals leave
  /// the parameter free; this keeps the speed even. Every shape has a parameter of even speed, so
  /// it hardly acts on the shape: docs/theory/curvature-fairing.md.
  double parametrization_weight = 1e-3;
  int max_rounds = 12;       ///< parameters made even and springs moved, see below
  int max_iterations = 500;  ///< iterations of Ceres in a round
};

/// A parameter of the starting curve at which it is held.
struct FixedCurvePoint {
  double u = 0;
  bool position = true;  ///< stays where it is
  bool tangent = false;  ///< keeps its direction; its speed is free and positive
};

/// Draws the nearest point of the curve to `point`: adds stiffness · distance², both of the curve
/// scaled to size 1. Near an open end the end is drawn.
struct CurveSpring {
  Vec3 point;
  double stiffness = 1;  ///< pure number, above 0
};

struct CurvatureFairingResult {
  HermiteCurve curve;              ///< C1 cubics, u arc length to a few digits
  QuinticCurve quintic;            ///< what was minimised, C2, same u
  std::vector<double> parameters;  ///< parameter of each hold, in their order
  double deviation = 0;            ///< distance of the cubics from the quintic curve, measured
  double functional = 0;           ///< functional of the quintic curve: 1/length or 1/length³
  double start_functional = 0;     ///< functional of the quintic curve it began with
  double max_residual = 0;         ///< largest violation of a hold: distance / size, sine of angle
  int iterations = 0;              ///< iterations of Ceres in all rounds
  int rounds = 0;
  bool converged = false;  ///< the last round, and the parameters stood still
};

/// Whether this build has Ceres. Without it the two functions below throw InputError.
bool have_curvature_fairing();

/// The functional of a curve, by `points` Gauss points in each segment: 8 give it to 1e-9 of itself
/// where segments turn by less than 45°.
double curvature_functional(const QuinticCurve& curve, CurveFunctional functional, int points = 10);

/// Fairs a curve: minimises the functional (and what springs and length_weight add) over quintic
/// C2 curves with a node at each hold and even nodes between, starting from the given curve, by
/// Levenberg and Marquardt's method and then BFGS (Ceres). A local minimum, one downhill from the
/// start.
/// Cubics would not do: they are C1, jumps of their curvature at nodes cost nothing, and refinement
/// makes that worse. Between rounds, parametric lengths become arc lengths and springs move to the
/// nearest points, until both stand still. Works on the curve moved to the origin and scaled to
/// size 1 (the diagonal of its box).
///
/// Throws InputError: no Ceres, tolerance not above 0, a corner in the curve, a hold outside it or
/// twice at one place, fewer segments than the holds need, neither two held points nor two springs,
/// a spring that is not finite. NoSolutionError: the curve grows without bound. Cost: about
/// O(segments · iterations), 20 µs each; fifty to a few hundred iterations.
CurvatureFairingResult fair_curvature(const HermiteCurve& start,
                                      const std::vector<FixedCurvePoint>& fixed_points,
                                      const std::vector<CurveSpring>& springs,
                                      const CurvatureFairingOptions& options);

/// A point that the curve passes through exactly, and its direction there if that is given.
struct CurveThroughPoint {
  Vec3 position;
  std::optional<Vec3> tangent = {};  ///< along the curve; its length does not matter
};

/// The curve of least functional through points in their order (closed: back to the first). Starts
/// from cubics with the given tangents, others those of the circle through neighbouring points.
/// Throws InputError as above, and: fewer than two points (closed: three), points that equal the
/// one before, a tangent of length zero, a number that is not finite.
CurvatureFairingResult minimum_curvature_curve(const std::vector<CurveThroughPoint>& points,
                                               bool closed, const CurvatureFairingOptions& options);

}  // namespace batten
