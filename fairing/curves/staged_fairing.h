// Fairing of several curves in stages: whole curves by smoothing splines or curves of minimum
// bending or variation, then parts of them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fairing/curvature/curvature_fairing.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A curve to be faired, given by points in order. The optional fields are set for points that were
/// sampled from a curve (sample_line()).
struct CurveSamples {
  std::string name;               ///< used in messages
  std::string where = {};         ///< prefix of messages, such as "scene.toml:8:1: "
  std::vector<Vec3> points = {};  ///< model units
  /// Indices of the points at corners; unset: detected.
  std::optional<std::vector<int>> corners = {};
  std::optional<bool> closed = {};      ///< unset: closed if the last point equals the first
  std::vector<Vec3> extra_points = {};  ///< further points, for measuring deviations

  /// True if the points do not all coincide.
  bool has_length() const;
};

/// One stage of fairing. It fairs whole curves or, as a local stage (brush or segment), a part of
/// the curves that the previous stages made.
struct FairStage {
  /// Local stage: a sphere in which curves are faired; see fair_brush().
  struct Brush {
    Vec3 at;
    double radius;
  };
  /// Local stage: the part of a curve between two points; see fair_interval(). On a closed curve it
  /// is the shorter arc.
  struct CurveSegment {
    Vec3 from, to;  ///< ends: the curve points nearest to these
  };
  /// Indices of the curves that the stage applies to; empty: all. A segment applies only to the one
  /// that is nearest to both of its ends.
  std::vector<int> curves;
  /// Options of fair_points(). Their `corners` are not used. Local stages use the wavelength only.
  FairOptions options;
  /// Functional that a curve through all points minimises, instead of smoothing; at most 200
  /// points.
  std::optional<CurveFunctional> minimum;
  /// Positions of the corners; each marks the nearest point of all curves of the stage. Unset:
  /// CurveSamples::corners.
  std::optional<std::vector<Vec3>> corners;
  std::optional<Brush> brush;
  std::optional<CurveSegment> segment;
  std::string where = {};  ///< prefix of messages, such as "scene.toml:8:1: stage 'smooth': "

  /// True for a local stage.
  bool local() const { return brush || segment; }
};

/// Measurements of a faired curve.
struct FairedLine {
  std::string name;
  int points = 0, segments = 0;  ///< input points; segments of the result
  bool closed = false;
  bool faired = false;  ///< false: no stage applied to it, or it cannot be faired
  double size = 0;      ///< diagonal of the bounding box of the points
  Deviation deviation;  ///< distance of the result from the input, without outliers
  /// From FairCurve, for the last stage of the whole curve.
  double wavelength = 0, effective_dofs = 0;
  /// From FairCurve, for the first stage of the whole curve.
  double noise = 0;
  std::vector<int> outliers;  ///< likewise: ignored input points
  int rounds = 0;
  bool converged = true;
  double max_residual = 0;  ///< largest residual of the conditions, relative to the size
  /// Set if a stage exceeded its requested deviation: the requested and the reached value.
  std::optional<std::pair<double, double>> exceeded_deviation;
  std::optional<Fairness> before, after;  ///< empty for a curve without length
  double seconds = 0;

  /// True if the input was noisy: fairing removed two thirds of its curvature extrema, and at least
  /// four. `freehand`: of a hand-drawn curve it removed any.
  bool was_noisy(bool freehand) const;
};

/// A curve after each stage.
struct StagedFairingResult {
  FairedLine report;
  /// The interpolating spline of the points, then the curve after each stage (unchanged if the
  /// stage did not apply). Empty if the curve cannot be faired.
  std::vector<HermiteCurve> states;
  std::vector<double> parameters;  ///< parameters of the points on the last curve, not descending
  /// Why it cannot be faired, such as "zero length"; empty: it can.
  std::string rejection_reason;

  bool has_curve() const { return !states.empty(); }
};

/// Corner angle of the first stage for whole curves that applies to a curve, degrees; the default
/// of FairOptions if there is none. It is the angle at which to sample the curve.
double corner_angle_of(const std::vector<FairStage>& stages, int curve);

/// Fairs curves in stages, in parallel. The first stage of a whole curve starts from its points,
/// later stages from the curve at these points. FairedLine::deviation is measured from the input
/// points.
///
/// `reduction_tolerance`: if above 0, model units, the last state is approximated by the fewest C1
/// segments within this distance (fit_curve()).
///
/// A curve cannot be faired if it has a single point, all points coincide, or it is closed and has
/// two points. Its result then has a reason, but no states. Throws InputError if a brush meets none
/// of its curves, a segment has no length, or more than 200 points are to be interpolated by a
/// curve of minimum bending or variation; the exceptions of fair_points(), fair_interval() and
/// minimum_curvature_curve(), beginning with CurveSamples::where; CancelledError. Cost: that of
/// these functions.
std::vector<StagedFairingResult> fair_in_stages(const std::vector<CurveSamples>& curves,
                                                const std::vector<FairStage>& stages,
                                                double reduction_tolerance = 0,
                                                const Progress& progress = {});

}  // namespace batten
