// Curves that fair themselves: springs to the data balanced against bending.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curve_fit.h"

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
///     Σ_i |X(u_i) - p_i|² + λ ∫ (|X_uu|² + alpha |X_u|²) du
///
/// over all C2 cubics with a node at each u_i (points closer than a quarter of the mean spacing
/// share one; from 1,000 points on there are fewer nodes than points, but always several times as
/// many as the balance can make use of). u_i begin as chord lengths; after each solve they move
/// to the nearest point of the curve and u becomes arc length, until they stand still: distances
/// are then those to the curve, not to an assumed parameter.
struct FairOptions {
  /// The way in which λ is found.
  enum class Balance {
    /// Generalised cross-validation (Craven, Wahba 1979) of x, y, z together: the curve that would
    /// predict left-out points best. From 20 points on each degree of freedom counts 1.4 times
    /// (Kim, Gu 2004), with six once. Points move by 2.5 % of the size at most (root mean
    /// square): what is larger was no noise. Fewer than six points tell nothing about noise: the
    /// curve then goes through them.
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
  bool hold_ends = false;  ///< the first and the last point of an open curve stay
  std::vector<CurveCondition> conditions;
  int most_rounds = 10;
};

struct FairCurve {
  HermiteCurve curve;              ///< u: arc length to a few digits
  std::vector<double> parameters;  ///< nearest parameter of each point
  Deviation deviation;
  double wavelength = 0;  ///< wavelength of the balance that was found; 0: nothing was smoothed
  double freedom = 0;     ///< effective degrees of freedom of one coordinate
  int rounds = 0;
  bool settled = false;     ///< parameters stood still within the rounds
  double max_residual = 0;  ///< largest violation of a condition, measured, over the size
};

/// Fairs two points or more. Cost: O(points) a round; about 0.2 ms for a hundred points.
/// Throws InputError (as fit_points; a condition of an open curve on a closed one; a deviation or
/// wavelength that is not above 0), ConflictError when conditions contradict each other,
/// NoSolutionError when fairing leaves no curve (a loop shorter than the wavelength).
FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options = {});

/// The curve through the points as they are, before any fairing: C2 between corners.
HermiteCurve curve_as_given(const std::string& name, const std::vector<Vec3>& points,
                            const FairOptions& options = {});

/// Local fairing. Minimises ∫ |X - X⁰|² + (φ(u) wavelength / 2π)⁴ |X_uu|² du (u in arc length) over
/// the segments that the stretch touches, φ falling smoothly from 1 in its middle to 0 at its ends:
/// the wave that keeps half of its height grows from nothing to `wavelength`. The nodes at the ends
/// of those segments keep position and slope: outside nothing changes, not a bit. Inside, nodes are
/// added first, without a change of shape, as many as the wavelength needs. At the end of an open
/// curve the slope is free.
///
/// The stretch goes from parameter `from` to `to` (on closed curves across the seam when to <
/// from). Throws InputError when that is no part of the curve, or wavelength is not above 0.
HermiteCurve fair_stretch(const HermiteCurve& curve, double from, double to, double wavelength);
/// A brush: every stretch inside the sphere, φ falling from 1 at its centre to 0 at `radius`. A
/// sphere that the curve does not meet: InputError.
HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength);

}  // namespace batten
