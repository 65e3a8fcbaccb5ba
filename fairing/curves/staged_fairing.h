// SPDX-License-Identifier: MPL-2.0
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
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A curve to be faired, given by points in order. The optional fields are set for points that were
/// sampled from a curve (sample_line()).
struct CurveSamples {
  std::string name;               ///< name of the curve, used in messages
  std::string where = {};         ///< prefix of messages, such as "scene.toml:8:1: "
  std::vector<Vec3> points = {};  ///< points of the curve in order, model units
  /// Indices of the corners among the points; unset: corners are detected.
  std::optional<std::vector<int>> corners = {};
  std::optional<bool> closed = {};      ///< unset: closed if the last point equals the first
  std::vector<Vec3> extra_points = {};  ///< additional points whose deviation is measured

  /// True unless all points coincide.
  bool has_length() const;
};

/// One stage of fairing. It fairs whole curves or, as a local stage (brush or segment), a part of
/// the curves that result from the previous stages.
struct FairStage {
  /// Local stage: a sphere in which curves are faired; see fair_brush().
  struct Brush {
    Vec3 at;
    double radius;
  };
  /// Local stage: the part of a curve between two points; see fair_interval(). On a closed curve it
  /// is the shorter arc.
  struct CurveSegment {
    Vec3 from, to;  ///< the ends are the curve points nearest to these points
  };
  /// Indices of the curves that the stage applies to; empty: all. A segment stage applies only to
  /// the curve that is nearest to both ends of the segment.
  std::vector<int> curves;
  /// Options of fair_points(), except `corners`, which is ignored. Local stages use the wavelength
  /// only.
  FairOptions options;
  /// If set, the stage does not smooth the points but interpolates them (at most 200) by the curve
  /// that minimises this functional.
  std::optional<CurveFunctional> minimum;
  /// Positions of corners; each makes the nearest point among all curves of the stage a corner.
  /// Unset: CurveSamples::corners.
  std::optional<std::vector<Vec3>> corners;
  std::optional<Brush> brush;
  std::optional<CurveSegment> segment;
  std::string where = {};  ///< prefix of messages, such as "scene.toml:8:1: stage 'smooth': "

  /// True if the stage fairs only a part of the curves (a brush or a segment).
  bool local() const { return brush || segment; }
};

/// Measurements of a faired curve.
struct FairedLine {
  std::string name;
  int points = 0, segments = 0;  ///< number of input points and of result segments
  bool closed = false;
  bool faired = false;  ///< false: no stage applied to the curve, or it cannot be faired
  double size = 0;      ///< diagonal of the bounding box of the points
  Deviation deviation;  ///< deviation of the result from the input points, without outliers
  /// Smoothing wavelength (model units) and effective dofs per coordinate (FairCurve) in the last
  /// stage that smoothed the whole curve.
  double wavelength = 0, effective_dofs = 0;
  /// Estimated noise of the points (FairCurve::noise, model units) in the first stage that faired
  /// the whole curve.
  double noise = 0;
  /// Indices of the input points ignored by the first stage that faired the whole curve.
  std::vector<int> outliers;
  int rounds = 0;
  bool converged = true;
  double max_residual = 0;  ///< largest violation of a curve condition, divided by `size`
  /// Requested and reached deviation, model units, if a stage exceeded its requested deviation;
  /// otherwise unset.
  std::optional<std::pair<double, double>> exceeded_deviation;
  /// largest_movement() and the reached RMS distance, model units, if an automatic stage moved the
  /// points by more; otherwise unset.
  std::optional<std::pair<double, double>> exceeded_movement;
  /// Fairness of input and result; unset for a curve of zero length.
  std::optional<Fairness> before, after;
  double seconds = 0;

  /// True if the input was noisy: it has 15 points or more, noise above 1e-6 of its size, and
  /// fairing removed at least two thirds of its curvature extrema, and no fewer than four. If `freehand` is true (hand-drawn curve), one removed extremum is enough.
  bool was_noisy(bool freehand) const;
};

/// Result of fair_in_stages() for one curve: the curve after each stage, and measurements.
struct StagedFairingResult {
  FairedLine report;
  /// The interpolating spline of the points, followed by the curve after each stage (unchanged if
  /// the stage did not apply). Empty if the curve cannot be faired.
  std::vector<HermiteCurve> states;
  std::vector<double> parameters;  ///< parameter of each point on states.back(), non-descending
  /// Per state: the largest curvature before the local stages that led to it, the `scale` of
  /// fairness().
  std::vector<double> scales;
  /// Wavelengths of local stages that are longer than the part of the curve, and stages that found
  /// no fairer curve, as sentences.
  std::vector<std::string> notes;
  /// Reason why the curve cannot be faired, such as "zero length"; empty if it can be faired.
  std::string rejection_reason;

  bool has_curve() const { return !states.empty(); }
};

/// Corner angle (degrees) of the first whole-curve stage that applies to a curve; the default of
/// FairOptions if no such stage exists. Use this angle to sample the curve.
double corner_angle_of(const std::vector<FairStage>& stages, int curve);

/// Fairs curves in stages, in parallel. The first stage of a whole curve starts from its points,
/// later stages from the curve at these points. FairedLine::deviation is measured from the input
/// points.
///
/// `reduction_tolerance`: model units; if above 0, the last state is approximated within this
/// distance by as few C1 segments as possible (fit_curve()).
///
/// A curve cannot be faired if it has a single point, all points coincide, or it is closed and has
/// two points. Its result then has a `rejection_reason`, but no states. Throws InputError if a
/// brush meets none of its curves, a segment has zero length, or more than 200 points are to be
/// interpolated by a curve of minimum bending or variation. Also throws CancelledError and the
/// exceptions of fair_points(), fair_interval() and minimum_curvature_curve(), with
/// CurveSamples::where in front of their messages. Cost: that of these functions.
std::vector<StagedFairingResult> fair_in_stages(const std::vector<CurveSamples>& curves,
                                                const std::vector<FairStage>& stages,
                                                double reduction_tolerance = 0,
                                                const Progress& progress = {});

}  // namespace batten
