// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/staged_fairing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fairing/corners/point_noise.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fairing/curves/local_fairing.h"

namespace batten {
namespace {

bool applies_to(const FairStage& stage, int curve) {
  return stage.curves.empty() ||
         std::find(stage.curves.begin(), stage.curves.end(), curve) != stage.curves.end();
}

std::string short_length(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Effect of a stage on a curve.
struct StageEffect {
  bool acts = false;
  std::optional<std::vector<int>> corners;  ///< points that the stage declares corners
};

/// Parameters of the curve points closest to `points`. Each search starts at its parameter in
/// `given` (ascending). The result need not be ascending: it follows points that go back and forth.
/// O(points).
std::vector<double> closest_parameters(const HermiteCurve& curve, const std::vector<Vec3>& points,
                                       const std::vector<double>& given) {
  std::vector<double> guess = given, result;
  // The last point of a closed list may repeat the first one, with parameter 0.
  for (size_t i = 1; i < guess.size() && curve.closed(); ++i)
    while (guess[i] < guess[i - 1] - (curve.end() - curve.start()) / 2)
      guess[i] += curve.end() - curve.start();
  const double low = curve.start(), high = curve.end();
  const double least = 1e-3 * (high - low);
  for (size_t i = 0; i < points.size(); ++i) {
    const double before = i > 0 ? guess[i] - guess[i - 1] : 0;
    const double after = i + 1 < points.size() ? guess[i + 1] - guess[i] : 0;
    const double reach = 2 * std::max({before, after, least});
    std::vector<double> tries;
    constexpr int steps = 4;
    for (int k = -steps; k <= steps; ++k) tries.push_back(guess[i] + reach * k / steps);
    for (const int corner : curve.mesh().corners()) {
      const double u = curve.parameters()[corner];
      if (u > tries.front() && u < tries.back()) tries.push_back(u);
    }
    if (!curve.closed())
      for (double& u : tries) u = std::clamp(u, low, high);
    std::sort(tries.begin(), tries.end());
    tries.erase(std::unique(tries.begin(), tries.end()), tries.end());
    result.push_back(closest_on_curve([&](double t, int order) { return curve.evaluate(t, order); },
                                      tries, points[i])
                         .u);
  }
  return result;
}

/// Like closest_parameters(), but non-decreasing in the order of `points`.
std::vector<double> closest_parameters_in_order(const HermiteCurve& curve,
                                                const std::vector<Vec3>& points,
                                                const std::vector<double>& guess) {
  std::vector<double> result = closest_parameters(curve, points, guess);
  for (size_t i = 1; i < result.size(); ++i) result[i] = std::max(result[i], result[i - 1]);
  return result;
}

/// A curve that hides that it is a cubic spline, so that fit_curve() fits it instead of copying it.
class HermiteInputCurve final : public InputCurve {
 public:
  explicit HermiteInputCurve(HermiteCurve curve) : curve_(curve_from_hermite(std::move(curve))) {}
  double start() const override { return curve_->start(); }
  double end() const override { return curve_->end(); }
  Vec3 evaluate(double t, int order) const override { return curve_->evaluate(t, order); }
  std::vector<double> breaks() const override { return curve_->breaks(); }

 private:
  std::shared_ptr<const InputCurve> curve_;
};

std::vector<Vec3> at(const HermiteCurve& curve, const std::vector<double>& parameters) {
  std::vector<Vec3> points;
  for (const double u : parameters) points.push_back(curve.evaluate(u));
  return points;
}

HermiteCurve reduce_segments(const std::string& name, const HermiteCurve& curve, double tolerance) {
  FitOptions options;
  options.tolerance = tolerance;
  options.closed = curve.closed();
  // Only breaks that the mesh marks as corners are corners.
  options.corner_angle = curve.mesh().corners().empty() ? 180 : 1;
  return fit_curve(name, std::make_shared<HermiteInputCurve>(curve), options);
}

std::vector<double> rescale_parameters(std::vector<double> u, const HermiteCurve& from,
                                       const HermiteCurve& to) {
  for (double& t : u)
    t = to.start() + (t - from.start()) / (from.end() - from.start()) * (to.end() - to.start());
  return u;
}

Deviation measured(const std::string& name, const HermiteCurve& curve, const CurveSamples& samples,
                   const std::vector<int>& outliers, std::vector<double> parameters) {
  std::vector<Vec3> points = samples.points;
  for (size_t k = outliers.size(); k-- > 0;) {
    points.erase(points.begin() + outliers[k]);
    parameters.erase(parameters.begin() + outliers[k]);
  }
  const PointSequence row(name, points, 180, {}, curve.closed());
  std::vector<double> t(static_cast<size_t>(row.count()));
  for (size_t i = parameters.size(); i-- > 0;) t[row.index[i]] = parameters[i];
  Deviation d = deviation_of(curve, row, t);
  if (samples.extra_points.empty()) return d;
  double sum = d.rms * d.rms * row.count();
  for (const Vec3& p : samples.extra_points) {
    const double distance = curve.closest_point(p).distance;
    d.max = std::max(d.max, distance);
    sum += distance * distance;
  }
  d.rms = std::sqrt(sum / static_cast<double>(samples.extra_points.size() + row.points.size()));
  return d;
}

/// Parameters of the points on the curve through them, proportional to chord length.
std::vector<double> chord_parameters(const HermiteCurve& curve, const std::vector<Vec3>& points) {
  std::vector<double> u = {0};
  for (size_t i = 1; i < points.size(); ++i)
    u.push_back(u.back() + (points[i] - points[i - 1]).norm());
  const double back = curve.closed() ? (points.back() - points.front()).norm() : 0;
  const double chord = u.back() + back;
  for (double& t : u) t = curve.start() + t / chord * (curve.end() - curve.start());
  return u;
}

/// Curves and stages of one call of fair_in_stages().
class StagedFairing {
 public:
  StagedFairing(const std::vector<CurveSamples>& curves, const std::vector<FairStage>& stages,
                double reduction_tolerance)
      : curves_(curves),
        stages_(stages),
        reduction_tolerance_(reduction_tolerance),
        hit_(stages.size()) {
    effects_.assign(curves.size(), std::vector<StageEffect>(stages.size()));
    for (size_t s = 0; s < stages.size(); ++s) {
      select_curves(s);
      resolve_points(s);
    }
  }

  StagedFairingResult faired(size_t index);
  /// Throws InputError for a brush that affected no curve; call it after all curves.
  void check_brushes() const {
    for (size_t s = 0; s < stages_.size(); ++s)
      if (stages_[s].brush && !hit_[s])
        fail(s, "a brush that meets none of its curves", "a sphere that contains a part of one");
  }

 private:
  [[noreturn]] void fail(size_t stage, const std::string& found,
                         const std::string& expected) const {
    throw InputError(stages_[stage].where + "found " + found + ", expected " + expected);
  }

  /// Determines the curves to which a stage applies.
  void select_curves(size_t s) {
    const std::vector<int>& selected = stages_[s].curves;
    for (std::vector<StageEffect>& effects : effects_) effects[s].acts = selected.empty();
    for (const int i : selected) {
      if (i < 0 || i >= isize(curves_))
        fail(s, "the curve number " + std::to_string(i),
             "one from 0 to " + std::to_string(curves_.size() - 1));
      effects_[i][s].acts = true;
    }
  }

  /// Among the curves of a stage, the one with the point nearest to one of `places`, and the index
  /// of that point.
  std::pair<size_t, size_t> nearest(size_t s, const std::vector<Vec3>& places) const {
    double best = std::numeric_limits<double>::infinity();
    std::pair<size_t, size_t> result{0, 0};
    for (size_t i = 0; i < curves_.size(); ++i) {
      if (!effects_[i][s].acts) continue;
      double sum = 0;
      size_t first = 0;
      for (const Vec3& p : places) {
        double least = std::numeric_limits<double>::infinity();
        for (size_t k = 0; k < curves_[i].points.size(); ++k) {
          const double d = (curves_[i].points[k] - p).norm();
          if (d < least && &p == &places.front()) first = k;
          least = std::min(least, d);
        }
        sum += least;
      }
      if (sum < best) {
        best = sum;
        result = {i, first};
      }
    }
    return result;
  }

  /// Assigns corners and segments to the nearest curves.
  void resolve_points(size_t s) {
    const FairStage& stage = stages_[s];
    if (stage.corners) {
      for (size_t i = 0; i < curves_.size(); ++i)
        if (effects_[i][s].acts) effects_[i][s].corners.emplace();
      for (const Vec3& p : *stage.corners) {
        const auto [i, k] = nearest(s, {p});
        effects_[i][s].corners->push_back(static_cast<int>(k));
      }
    }
    if (stage.segment) {
      const size_t chosen = nearest(s, {stage.segment->from, stage.segment->to}).first;
      for (size_t i = 0; i < curves_.size(); ++i)
        effects_[i][s].acts = effects_[i][s].acts && i == chosen;
    }
  }

  /// The parts of a curve that a local stage fairs.
  std::vector<CurvePart> local_parts(size_t s, const HermiteCurve& curve) {
    const FairStage& stage = stages_[s];
    if (stage.brush) {
      const std::vector<CurvePart> parts =
          parts_inside(curve, stage.brush->at, stage.brush->radius);
      if (!parts.empty()) hit_[s] = true;
      return parts;
    }
    double from = curve.closest_point(stage.segment->from).u;
    double to = curve.closest_point(stage.segment->to).u;
    // Closed curves: take the shorter arc.
    const double length = curve.end() - curve.start();
    const bool swap =
        curve.closed() ? std::fmod(to - from + length, length) > length / 2 : to < from;
    if (swap) std::swap(from, to);
    if (from == to) fail(s, "a segment of zero length", "two different points of the curve");
    return {{from, to < from ? to + length : to}};
  }

  /// The curve after a local stage.
  HermiteCurve local(size_t index, size_t s, HermiteCurve curve, std::vector<std::string>& notes) {
    const FairStage& stage = stages_[s];
    const double wavelength = stage.options.wavelength;
    const char* kind = stage.brush ? "brush" : "segment";
    double longest = 0;
    bool changed = false;
    for (const CurvePart& part : local_parts(s, curve)) {
      HermiteCurve result = fair_part(curve, part, wavelength);
      longest = std::max(longest, part_length(curve, part));
      changed =
          changed || result.node_count() != curve.node_count() || result.dofs() != curve.dofs();
      curve = std::move(result);
    }
    if (!(longest > 0)) return curve;
    const std::string& name = curves_[index].name;
    if (wavelength > longest)
      notes.push_back(stage.where + "the wavelength " + format_number(wavelength) +
                      " is longer than the part of '" + name + "' that the " + kind + " fairs (" +
                      short_length(longest) + "): waves longer than this part remain; " +
                      (stage.brush ? "increase the radius" : "use a longer segment") +
                      " to remove them");
    if (!changed)
      notes.push_back(stage.where + "'" + name + "' is unchanged in the " + kind +
                      ": fairing would add curvature extrema; use another wavelength or another " +
                      kind);
    return curve;
  }

  FairOptions options_of(size_t index, size_t s) const;
  /// Options of the first non-local stage that applies to the curve. They also determine the
  /// initial curve.
  FairOptions given_options(size_t index) const;
  /// Why a curve cannot be faired; empty: it can.
  std::string rejection_reason(size_t index) const;
  CurvatureFairingResult least_curvature(size_t index, size_t s, const HermiteCurve& curve,
                                         const std::vector<Vec3>& points) const;
  /// Applies all stages to a curve, starting from its initial curve.
  void run_stages(size_t index, StagedFairingResult& result);

  const std::vector<CurveSamples>& curves_;
  const std::vector<FairStage>& stages_;
  double reduction_tolerance_;
  std::vector<std::vector<StageEffect>> effects_;  // per curve and stage
  std::vector<std::atomic<bool>> hit_;
};

FairOptions StagedFairing::options_of(size_t index, size_t s) const {
  const FairStage& stage = stages_[s];
  FairOptions options = stage.options;
  options.corners =
      effects_[index][s].corners ? effects_[index][s].corners : curves_[index].corners;
  if (!options.closed) options.closed = curves_[index].closed;
  return options;
}

std::string StagedFairing::rejection_reason(size_t index) const {
  const std::vector<Vec3>& points = curves_[index].points;
  if (points.size() == 1) return "only one point";
  if (!curves_[index].has_length()) return "zero length";
  if (!given_options(index).closed.value_or(false)) return "";
  const PointSequence row(curves_[index].name, points, 180, {}, false);
  const bool repeated = (row.points.back() - row.points.front()).norm() <= 1e-12 * row.size;
  return row.count() - repeated < 3 ? "too few points for a closed curve" : "";
}

FairOptions StagedFairing::given_options(size_t index) const {
  FairOptions options;
  options.corners = curves_[index].corners;
  options.closed = curves_[index].closed;
  for (size_t s = 0; s < stages_.size(); ++s)
    if (effects_[index][s].acts && !stages_[s].local()) {
      options = options_of(index, s);
      break;
    }
  return options;
}

CurvatureFairingResult StagedFairing::least_curvature(size_t index, size_t s,
                                                      const HermiteCurve& curve,
                                                      const std::vector<Vec3>& points) const {
  constexpr size_t most = 200;
  if (points.size() > most)
    fail(
        s, std::to_string(points.size()) + " points of '" + curves_[index].name + "'",
        "at most " + std::to_string(most) +
            " for a curve of minimum bending or variation, which interpolates all points including "
            "their noise");
  const PointSequence row(curves_[index].name, points, 180, {}, curve.closed());
  std::vector<CurveThroughPoint> through;
  for (const Vec3& p : row.points) through.push_back({p});
  CurvatureFairingOptions options;
  options.functional = *stages_[s].minimum;
  options.tolerance = 1e-6 * row.size;
  options.segments = std::max(16, 4 * row.count());
  return minimum_curvature_curve(through, curve.closed(), options);
}

void StagedFairing::run_stages(size_t index, StagedFairingResult& result) {
  const std::vector<Vec3>& points = curves_[index].points;
  FairedLine& report = result.report;
  HermiteCurve curve = result.states.front();
  std::vector<double> u = chord_parameters(curve, points);
  for (size_t s = 0; s < stages_.size(); ++s) {
    if (effects_[index][s].acts && stages_[s].local()) {
      curve = local(index, s, std::move(curve), result.notes);
      report.faired = true;
    } else if (effects_[index][s].acts && stages_[s].minimum) {
      const CurvatureFairingResult least = least_curvature(index, s, curve, at(curve, u));
      u = rescale_parameters(std::move(u), curve, least.curve);
      curve = least.curve;
      report.faired = true;
      report.rounds = least.rounds;
      report.converged = least.converged;
      report.max_residual = std::max(report.max_residual, least.max_residual);
    } else if (effects_[index][s].acts) {
      FairOptions options = options_of(index, s);
      options.closed = curve.closed();
      options.fix_ends = options.fix_ends && !curve.closed();
      const std::vector<Vec3> current =
          report.faired ? at(curve, closest_parameters_in_order(curve, points, u)) : points;
      const FairCurve fair = fair_points(curves_[index].name, current, options);
      curve = fair.curve;
      u = fair.parameters;
      if (!report.faired) {
        report.noise = fair.noise;
        report.outliers = fair.outliers;
      }
      report.faired = true;
      report.wavelength = fair.wavelength;
      report.effective_dofs = fair.effective_dofs;
      report.rounds = fair.rounds;
      report.converged = fair.converged;
      report.max_residual = std::max(report.max_residual, fair.max_residual);
      if (options.smoothing == FairOptions::Smoothing::Deviation &&
          fair.deviation.max > options.deviation)
        report.exceeded_deviation = {options.deviation, fair.deviation.max};
      const double most = largest_movement(fair.noise, bounding_box(current).diagonal().norm());
      if (options.smoothing == FairOptions::Smoothing::CrossValidation &&
          options.conditions.empty() && !options.drawn_by_hand && fair.deviation.rms > most)
        report.exceeded_movement = {most, fair.deviation.rms};
    }
    result.states.push_back(curve);
    const bool whole = effects_[index][s].acts && !stages_[s].local();
    result.scales.push_back(whole ? fairness(curve).largest_curvature : result.scales.back());
  }
  if (reduction_tolerance_ > 0) {
    HermiteCurve few = reduce_segments(curves_[index].name, curve, reduction_tolerance_);
    u = rescale_parameters(std::move(u), curve, few);
    result.states.back() = std::move(few);
  }
  result.parameters = closest_parameters_in_order(result.states.back(), points, u);
}

StagedFairingResult StagedFairing::faired(size_t index) {
  const CurveSamples& samples = curves_[index];
  StagedFairingResult result;
  FairedLine& report = result.report;
  report.name = samples.name;
  report.points = isize(samples.points);
  result.rejection_reason = rejection_reason(index);
  if (!result.rejection_reason.empty()) return result;
  report.size = bounding_box(samples.points).diagonal().norm();

  const auto start = std::chrono::steady_clock::now();
  result.states.push_back(interpolating_spline(report.name, samples.points, given_options(index)));
  report.before = fairness(result.states.front());
  result.scales.push_back(report.before->largest_curvature);
  run_stages(index, result);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const HermiteCurve& curve = result.states.back();
  report.segments = curve.segment_count();
  report.closed = curve.closed();
  report.deviation = measured(report.name, curve, samples, report.outliers,
                              closest_parameters(curve, samples.points, result.parameters));
  report.after = fairness(curve, result.scales.back());
  return result;
}

}  // namespace

bool CurveSamples::has_length() const {
  return std::any_of(points.begin(), points.end(),
                     [&](const Vec3& p) { return p != points.front(); });
}

bool FairedLine::was_noisy(bool freehand) const {
  if (!faired || !before || !after) return false;
  constexpr int most_left = 3, fewest = 4;
  const int gone = before->extrema - after->extrema;
  if (freehand) return gone > 0;
  // The shape of few points is not to be told from noise, nor is rounding.
  constexpr int few_points = 15;
  constexpr double rounding = 1e-6;
  return points >= few_points && noise > rounding * size && gone >= fewest &&
         most_left * after->extrema <= before->extrema;
}

double corner_angle_of(const std::vector<FairStage>& stages, int curve) {
  for (const FairStage& stage : stages)
    if (applies_to(stage, curve) && !stage.local()) return stage.options.corner_angle;
  return FairOptions{}.corner_angle;
}

std::vector<StagedFairingResult> fair_in_stages(const std::vector<CurveSamples>& curves,
                                                const std::vector<FairStage>& stages,
                                                double reduction_tolerance,
                                                const Progress& progress) {
  if (curves.empty()) return {};
  StagedFairing fairing(curves, stages, reduction_tolerance);
  std::vector<StagedFairingResult> results(curves.size());
  const auto work = [&](size_t i) {
    try {
      results[i] = fairing.faired(i);
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), curves[i].where);
    } catch (const InputError& e) {
      throw InputError(curves[i].where + e.what());
    }
  };
  // Between batches this thread reports progress and can cancel.
  constexpr size_t batch = 64;
  for (size_t first = 0; first < curves.size(); first += batch) {
    progress.update("fairing", static_cast<double>(first) / static_cast<double>(curves.size()));
    parallel_for(static_cast<int>(std::min(batch, curves.size() - first)),
                 [&](int part) { work(first + static_cast<size_t>(part)); });
  }
  fairing.check_brushes();
  return results;
}

}  // namespace batten
