// How a curve is faired, and what holds meanwhile.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/fit.h"

namespace batten {

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
///     Σ_i |X(u_i) - p_i|² + λ ∫ (ease |X_uu|² + alpha |X_u|²) du
///
/// over all C2 cubics with a node at each u_i (points closer than a fiftieth of the mean spacing
/// share one, but for an end or a corner, which has none but its own; from 1,000 points on there
/// are fewer nodes than points, but always several times as many as the balance can make use of).
/// u_i begin as chord lengths; after each solve they move to the nearest point of the curve and u
/// becomes arc length, until they stand still: distances are then those to the curve, not to an
/// assumed parameter.
struct FairOptions {
  /// The way in which λ is found.
  enum class Balance {
    /// Generalised cross-validation (Craven, Wahba 1979) of x, y, z together: the curve that would
    /// predict left-out points best. From 20 points on each degree of freedom counts 1.4 times
    /// (Kim, Gu 2004), with six once. Points move by twice their noise at most (root mean square;
    /// of fewer than eleven, whose noise nobody knows, by 2.5 % of the size): what is larger was
    /// none. Noise is what neighbouring points do not share; a hand's slow tremor needs its
    /// wavelength stated. Fewer than six points tell nothing about noise: the curve then goes
    /// through them. Bending is eased in tight bends (BendingEase), where it would flatten them.
    CrossValidation,
    Deviation,  ///< the fairest curve not farther than `deviation` from any point; where conditions
                ///< or a missing corner do not let it be, FairCurve::deviation is larger
    Wavelength  ///< waves of length `wavelength` keep half of their height; shorter ones less
  };
  Balance balance = Balance::CrossValidation;
  double deviation = 0;   ///< model units, above 0
  double wavelength = 0;  ///< model units, above 0; λ = (wavelength / 2π)⁴ × points per length
  double alpha = 0;       ///< resistance to stretching over that to bending × size², ≥ 0
  double corner_angle = 50;                 ///< a corner turns by more than this, as in FitOptions
  std::optional<std::vector<int>> corners;  ///< corners that are given instead of found
  std::optional<bool> closed;
  /// Points of a noisy line that lie off it, one or two among their neighbours, farther than its
  /// noise explains have no spring (a wrong digit, a twitch of the hand). Given corners are kept.
  bool drop_outliers = true;
  bool hold_ends = false;  ///< the first and the last point of an open curve stay
  std::vector<CurveCondition> conditions;
  int most_rounds = 10;
};

}  // namespace batten
