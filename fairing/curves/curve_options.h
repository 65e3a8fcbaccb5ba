// SPDX-License-Identifier: MPL-2.0
// Options and results of curve fitting and of curve fairing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Prescribed position and tangent of one end of an open curve.
struct CurveEnd {
  Vec3 position;
  Vec3 tangent;  ///< unit vector, in the direction of increasing u
};

/// Options of fit_points() and fit_curve().
struct FitOptions {
  double tolerance = 0;  ///< maximum distance between curve and points; model units, above 0
  /// Smallest turning angle of a corner, degrees in (0, 180]; 180: no corners. See find_corners().
  double corner_angle = 50;
  std::optional<std::vector<int>> corners;  ///< point indices of the corners; unset: detected
  std::optional<bool> closed;               ///< unset: closed if the last point equals the first
  /// Prescribed ends of an open curve; unset: the first and the last point, with free tangents.
  std::optional<CurveEnd> start, end;
  /// True: points keep their initial parameters (chord or arc length). The curve then has more
  /// segments, but a more uniform parameter.
  bool fixed_parameters = false;
  /// True: adds nodes only by repeated halving of parameter intervals, and removes none. Use it for
  /// meshes whose boundary edges are also refined by halving.
  bool bisection_only = false;
  int max_segments = 1 << 14;
};

/// Distance between a curve and ordered points; model units.
struct Deviation {
  double max = 0, rms = 0;  ///< largest and RMS distance of the points from the curve
  /// Largest distance of the curve from the polyline through the points, in excess of
  /// sagitta_bound(), the bulge of a circle through neighbouring points. This value bounds
  /// oscillations of the curve between the points.
  double between = 0;
};

/// Result of fit_points().
struct CurveFit {
  HermiteCurve curve;
  /// Parameter of the closest curve point for each point, in input order.
  std::vector<double> parameters;
  Deviation deviation;
};

/// A condition that a faired curve satisfies exactly.
struct CurveCondition {
  enum class Type {
    Point,    ///< the curve passes through the point `at`
    Tangent,  ///< at the curve point closest to `at`, the tangent is parallel to ±`direction`
    ZeroEndCurvature,  ///< the second derivative vanishes at both ends of an open curve
    Plane,             ///< the whole curve lies in the plane through `at` with normal `direction`
    Symmetry           ///< mirror symmetry about the plane through `at` with normal `direction`
  };
  std::string name;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  /// Tangent direction (Tangent) or plane normal (Plane, Symmetry); any length except zero.
  Vec3 direction = Vec3::UnitZ();
};

/// Options of fair_points(): global fairing of ordered points by a smoothing spline.
///
/// The curve minimises
///
///     Σ_i |X(u_i) - p_i|² + ρ ∫ (1-b) (ra)⁶ |X_uuu|² + b (ra)⁴ (|X_uu|² + alpha |X_u|²) du
///
/// (FairingEnergy) over C1 cubics whose second derivatives are almost continuous at the nodes. ρ is
/// the number of points per length and w = 2πa the wavelength below which waves are smoothed away.
/// b = 1 / (1 + (L/4πa)²) with the length L, and r ≤ 1 is a local wavelength factor, which is
/// reduced in tight bends.
///
/// Nodes are placed at every k-th point, several times as densely as the smoothing can resolve. The
/// u_i start as chord lengths. After each solve they move to the foot points (closest points on the
/// curve) and u becomes arc length. This is repeated until the u_i no longer move, so the distances
/// are orthogonal distances to the curve.
struct FairOptions {
  /// How the smoothing wavelength is chosen.
  enum class Smoothing {
    /// Generalised cross-validation [CravenWahba1979] of x, y, z together: the curve that best
    /// predicts points that are left out of the fit.
    ///
    /// With 20 points or more, each degree of freedom counts 1.3 times, close to [KimGu2004]; with
    /// six points, it counts once. Points move by at most twice their estimated noise (RMS),
    /// because larger deviations cannot be noise. Only variation that neighbouring points do not
    /// share is recognised as noise. For slow hand tremor, state its wavelength (Wavelength) or its
    /// size (Noise). In tight bends, the wavelength is reduced locally, because the bends would be
    /// flattened otherwise.
    ///
    /// The noise of fewer than 15 points cannot be distinguished from their shape: the curve
    /// interpolates them, unless `drawn_by_hand` is set. The same holds for more points, if curves
    /// within twice their noise would have spikes.
    CrossValidation,
    /// The fairest curve whose RMS distance from the points is `noise`, corrected for the effective
    /// dofs of the curve. Use it if the noise is known, also for correlated noise such as tremor.
    Noise,
    /// The fairest curve within `deviation` of all points. If conditions or an undetected corner
    /// make that impossible, FairCurve::deviation is larger.
    Deviation,
    /// Waves of length `wavelength` keep half of their height. Waves of length v keep the fraction
    /// 1 / (1 + (1-b) (wavelength/v)⁶ + b (wavelength/v)⁴) of their height, with b = 1 / (1 + (L /
    /// (2 wavelength))²) and the curve length L.
    Wavelength
  };
  Smoothing smoothing = Smoothing::CrossValidation;
  /// Known RMS distance of the points from the curve, for Smoothing::Noise; model units, above 0.
  double noise = 0;
  /// Maximum distance of a point from the curve, for Smoothing::Deviation; model units, above 0.
  double deviation = 0;
  double wavelength = 0;  ///< smoothing wavelength, for Smoothing::Wavelength; model units, above 0
  double alpha = 0;       ///< (stretching / bending resistance of the curve) · size², ≥ 0
  double corner_angle = 50;  ///< smallest turning angle of a corner, degrees; 180: no corners
  std::optional<std::vector<int>> corners;  ///< point indices of the corners; unset: detected
  /// True: the curve is closed. Unset: it is closed if the last point equals the first.
  std::optional<bool> closed;
  /// True: ignores outliers, that is one or two adjacent points whose distance from a noisy curve
  /// is larger than the noise explains (a wrong digit, a twitch of the hand). Given corners are
  /// always kept.
  bool reject_outliers = true;
  bool fix_ends = false;  ///< true: fixes the first and the last point of an open curve
  /// True: the points are known to be noisy. Cross-validation then also smooths six to 14 points,
  /// and points that zigzag may move by more than twice their estimated noise. Fewer than eleven
  /// points move by at most 2.5 % of the size (RMS).
  bool drawn_by_hand = false;
  /// Conditions that the curve satisfies exactly.
  std::vector<CurveCondition> conditions;
  /// Maximum number of rounds, each of which solves for the curve and moves the parameters.
  int max_rounds = 10;
};

/// Result of fair_points(): the faired curve and the course of the iteration.
struct FairCurve {
  HermiteCurve curve;              ///< faired curve; its parameter u is arc length to a few digits
  std::vector<double> parameters;  ///< per point: parameter of the closest point of `curve`
  std::vector<int> outliers;       ///< indices of the points ignored as outliers, ascending
  Deviation deviation;             ///< distances of the points, without the outliers, from `curve`
  double wavelength = 0;           ///< smoothing wavelength used, model units; 0: no smoothing
  /// Estimated standard deviation of the points from the underlying curve, model units; 0 for few
  /// points that are interpolated, and for fewer than eleven points.
  double noise = 0;
  double effective_dofs = 0;  ///< effective degrees of freedom of the fit, per coordinate
  int rounds = 0;
  bool converged = false;   ///< true: parameters stopped moving within max_rounds
  double max_residual = 0;  ///< largest violation of a condition, divided by the size of `curve`
};

}  // namespace batten
