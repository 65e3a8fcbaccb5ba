// How a curve is faired, what holds meanwhile, and what comes of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

// What a curve fit is asked for, and what it gives.

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


/// What must hold exactly while a curve is faired.
struct CurveCondition {
  enum class Type {
    Point,    ///< the curve passes through `at`
    Tangent,  ///< where the curve is nearest to `at`, it runs along `direction` (or against)
    ZeroEndCurvature,  ///< no second derivative at both ends of an open curve
    Plane,             ///< the whole curve lies in the plane through `at` with normal `direction`
    Symmetry           ///< the curve is its own mirror image in that plane
  };
  std::string name;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();  ///< its length does not matter
};

/// Fairing of points given in an order (global): the curve minimises
///
///     Σ_i |X(u_i) - p_i|² + ρ ∫ (1-b) (ra)⁶ |X_uuu|² + b (ra)⁴ (|X_uu|² + alpha |X_u|²) du
///
/// (FairingEnergy) over C1 cubics whose second derivatives all but go on at the nodes: ρ points per
/// length, wavelength 2πa, b = 1 / (1 + (L/4πa)²) with L the length, ease r (CurvatureAdaptiveWavelength). Nodes are at every k-th point, several times as many
/// as the balance can make use of. u_i begin as chord lengths; after each solve they move to the nearest point of the curve and u
/// becomes arc length, until they stand still: distances are then those to the curve, not to an
/// assumed parameter.
struct FairOptions {
  /// The way in which λ is found.
  enum class Smoothing {
    /// Generalised cross-validation (Craven, Wahba 1979) of x, y, z together: the curve that would
    /// predict left-out points best. From 20 points on each degree of freedom counts 1.3 times
    /// (nearly as Kim, Gu 2004), with six once. Points move by twice their noise at most (root mean square;
    /// of fewer than eleven, whose noise nobody knows, by 2.5 % of the size): what is larger was
    /// none. Noise is what neighbouring points do not share; a hand's slow tremor needs its
    /// wavelength or its size stated. Fewer than six points tell nothing about noise: the curve then goes
    /// through them. Waves are shorter in tight bends (CurvatureAdaptiveWavelength), which would be flattened.
    CrossValidation,
    Noise,  ///< the fairest curve whose points are off by `noise`, root mean square, less what
            ///< its freedom takes: where the noise is known, also a tremor that neighbours share
    Deviation,  ///< the fairest curve not farther than `deviation` from any point; where conditions
                ///< or a missing corner do not let it be, FairCurve::deviation is larger
    Wavelength  ///< waves of length `wavelength` keep half of their height, waves of length v
                ///< 1 / (1 + (1-b) (wavelength/v)⁶ + b (wavelength/v)⁴)
  };
  Smoothing smoothing = Smoothing::CrossValidation;
  double noise = 0;          ///< model units, above 0: of the distances across the line
  double deviation = 0;      ///< model units, above 0
  double wavelength = 0;     ///< model units, above 0
  double alpha = 0;          ///< resistance to stretching over that to bending × size², ≥ 0
  double corner_angle = 50;  ///< a corner turns by more than this, as in FitOptions
  std::optional<std::vector<int>> corners;  ///< corners that are given instead of found
  std::optional<bool> closed;
  /// Points of a noisy line that lie off it, one or two among their neighbours, farther than its
  /// noise explains have no spring (a wrong digit, a twitch of the hand). Given corners are kept.
  bool reject_outliers = true;
  bool fix_ends = false;  ///< the first and the last point of an open curve stay
  std::vector<CurveCondition> conditions;
  int max_rounds = 10;
};

/// A faired curve, and how it was found.
struct FairCurve {
  HermiteCurve curve;              ///< u: arc length to a few digits
  std::vector<double> parameters;  ///< nearest parameter of each point
  std::vector<int> outliers;       ///< points that were passed over, ascending
  Deviation deviation;             ///< of the others
  double wavelength = 0;  ///< wavelength of the balance that was found; 0: nothing was smoothed
  /// Standard deviation of the points across their line, estimated from their differences; 0 for
  /// fewer than eleven points.
  double noise = 0;
  double effective_dofs = 0;  ///< effective degrees of freedom of one coordinate
  int rounds = 0;
  bool converged = false;   ///< parameters stood still within the rounds
  double max_residual = 0;  ///< largest violation of a condition, measured, over the size
};

}  // namespace batten
