#include "batten/apps/commands/lines/fair_lines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fairing/corners/point_sequence.h"

namespace batten {
namespace {

/// Effect of a stage on a line.
struct LineStage {
  bool acts = false;
  std::optional<std::vector<int>> corners;  ///< points that the stage declares corners
};

/// Calls `work` for each line, in batches. Between batches this thread reports progress and can
/// cancel.
void for_each_line(size_t lines, const Progress& progress, const char* stage,
                   const std::function<void(size_t line)>& work) {
  constexpr size_t portion = 64;
  for (size_t first = 0; first < lines; first += portion) {
    progress.update(stage, static_cast<double>(first) / static_cast<double>(lines));
    const size_t count = std::min(portion, lines - first);
    parallel_for(static_cast<int>(count),
                 [&](int part) { work(first + static_cast<size_t>(part)); });
  }
}

class Fairing {
 public:
  Fairing(const std::vector<SourceLine>& lines, const FairingSettings& settings,
          const Progress& progress)
      : lines_(lines), settings_(settings), hit_(settings.stages.size()) {
    for (const SourceLine& line : lines) names_.push_back(line.name);
    line_stages_.assign(lines.size(), std::vector<LineStage>(settings.stages.size()));
    for (size_t s = 0; s < settings.stages.size(); ++s) select_lines(s);
    sampled_.resize(lines.size());
    for_each_line(lines.size(), progress, "reading curves",
                  [&](size_t i) { sampled_[i] = sample_line(lines[i], angle_of(i)); });
    for (size_t s = 0; s < settings.stages.size(); ++s) resolve_points(s);
  }

  FairedResult faired(size_t index);
  /// Throws InputError for a brush that affected no line; call it after all lines.
  void check_brushes() const {
    for (size_t s = 0; s < settings_.stages.size(); ++s)
      if (settings_.stages[s].brush && !hit_[s])
        fail(s, "a brush that meets none of its curves",
             "'at' and 'radius' of a sphere that contains a part of one");
  }

 private:
  [[noreturn]] void fail(size_t stage, const std::string& found,
                         const std::string& expected) const {
    const FairStage& s = settings_.stages[stage];
    throw InputError(format_location(settings_.file, s.location) + "the [[fair]] stage '" + s.name +
                     "': found " + found + ", expected " + expected);
  }

  /// Determines the lines to which a stage applies.
  void select_lines(size_t s) {
    const FairStage& stage = settings_.stages[s];
    for (size_t i = 0; i < lines_.size(); ++i) line_stages_[i][s].acts = stage.lines.empty();
    for (const LocatedString& word : stage.lines) {
      bool any = false;
      for (size_t i = 0; i < lines_.size(); ++i)
        if (matches_wildcard(word.text, names_[i])) any = line_stages_[i][s].acts = true;
      if (!any)
        throw InputError(format_location(settings_.file, word.location) + "found the curve name '" +
                         word.text + "', expected " + expected_one_of(word.text, names_));
    }
  }

  /// Corner angle of the first non-local stage that applies to a line.
  double angle_of(size_t i) const {
    for (size_t s = 0; s < settings_.stages.size(); ++s)
      if (line_stages_[i][s].acts && !settings_.stages[s].local())
        return settings_.stages[s].options.corner_angle;
    return FairOptions{}.corner_angle;
  }

  /// Among the lines of a stage, the one with the point nearest to one of `places`, and the index
  /// of that point.
  std::pair<size_t, size_t> nearest(size_t s, const std::vector<Vec3>& places) const {
    double best = std::numeric_limits<double>::infinity();
    std::pair<size_t, size_t> result{0, 0};
    for (size_t i = 0; i < lines_.size(); ++i) {
      if (!line_stages_[i][s].acts) continue;
      double sum = 0;
      size_t first = 0;
      for (const Vec3& p : places) {
        double least = std::numeric_limits<double>::infinity();
        for (size_t k = 0; k < sampled_[i].points.size(); ++k) {
          const double d = (sampled_[i].points[k] - p).norm();
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

  /// Assigns corners and segments to the nearest lines.
  void resolve_points(size_t s) {
    const FairStage& stage = settings_.stages[s];
    if (stage.corners) {
      for (size_t i = 0; i < lines_.size(); ++i)
        if (line_stages_[i][s].acts) line_stages_[i][s].corners.emplace();
      for (const Vec3& p : *stage.corners) {
        const auto [i, k] = nearest(s, {p});
        line_stages_[i][s].corners->push_back(static_cast<int>(k));
      }
    }
    if (stage.segment) {
      const size_t chosen = nearest(s, {stage.segment->from, stage.segment->to}).first;
      for (size_t i = 0; i < lines_.size(); ++i)
        line_stages_[i][s].acts = line_stages_[i][s].acts && i == chosen;
    }
  }

  HermiteCurve local(size_t s, const HermiteCurve& curve) {
    const FairStage& stage = settings_.stages[s];
    const double wavelength = stage.options.wavelength;
    if (stage.brush) {
      if (!(curve.closest_point(stage.brush->at).distance < stage.brush->radius)) return curve;
      hit_[s] = true;
      return fair_brush(curve, stage.brush->at, stage.brush->radius, wavelength);
    }
    double from = curve.closest_point(stage.segment->from).u;
    double to = curve.closest_point(stage.segment->to).u;
    // Closed curves: take the shorter arc.
    const double length = curve.end() - curve.start();
    const bool swap =
        curve.closed() ? std::fmod(to - from + length, length) > length / 2 : to < from;
    if (swap) std::swap(from, to);
    if (from == to) fail(s, "a segment of zero length", "two different points of the curve");
    return fair_interval(curve, from, to, wavelength);
  }

  FairOptions options_of(size_t line, size_t s) const;
  /// Options of the first non-local stage that applies to the line. They also determine the initial
  /// curve.
  FairOptions given_options(size_t line) const;
  /// Why a line cannot be faired; empty: it can.
  std::string rejection_reason(size_t line) const;
  CurvatureFairingResult least_curvature(size_t line, size_t s, const HermiteCurve& curve,
                                         const std::vector<Vec3>& points) const;
  /// Applies all stages to a line, starting from its initial curve.
  void run_stages(size_t line, FairedResult& result);

  const std::vector<SourceLine>& lines_;
  const FairingSettings& settings_;
  std::vector<std::string> names_;
  std::vector<SampledLine> sampled_;
  std::vector<std::vector<LineStage>> line_stages_;  // per line and stage
  std::vector<std::atomic<bool>> hit_;
};

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

Deviation measured(const std::string& name, const HermiteCurve& curve, const SampledLine& line,
                   const std::vector<int>& outliers, std::vector<double> parameters) {
  std::vector<Vec3> points = line.points;
  for (size_t k = outliers.size(); k-- > 0;) {
    points.erase(points.begin() + outliers[k]);
    parameters.erase(parameters.begin() + outliers[k]);
  }
  const PointSequence row(name, points, 180, {}, curve.closed());
  std::vector<double> t(static_cast<size_t>(row.count()));
  for (size_t i = parameters.size(); i-- > 0;) t[row.index[i]] = parameters[i];
  Deviation d = deviation_of(curve, row, t);
  if (line.extra_points.empty()) return d;
  double sum = d.rms * d.rms * row.count();
  for (const Vec3& p : line.extra_points) {
    const double distance = curve.closest_point(p).distance;
    d.max = std::max(d.max, distance);
    sum += distance * distance;
  }
  d.rms = std::sqrt(sum / static_cast<double>(line.extra_points.size() + row.points.size()));
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

FairOptions Fairing::options_of(size_t line, size_t s) const {
  const FairStage& stage = settings_.stages[s];
  FairOptions options = stage.options;
  options.fix_ends = stage.fix_ends.value_or(settings_.fix_ends);
  options.corners =
      line_stages_[line][s].corners ? line_stages_[line][s].corners : sampled_[line].corners;
  if (!options.closed) options.closed = sampled_[line].closed;
  return options;
}

std::string Fairing::rejection_reason(size_t line) const {
  const std::vector<Vec3>& points = sampled_[line].points;
  if (points.size() == 1) return "only one point";
  if (!sampled_[line].has_length()) return "zero length";
  if (!given_options(line).closed.value_or(false)) return "";
  const PointSequence row(names_[line], points, 180, {}, false);
  const bool repeated = (row.points.back() - row.points.front()).norm() <= 1e-12 * row.size;
  return row.count() - repeated < 3 ? "too few points for a closed curve" : "";
}

FairOptions Fairing::given_options(size_t line) const {
  FairOptions options;
  options.corners = sampled_[line].corners;
  options.closed = sampled_[line].closed;
  for (size_t s = 0; s < settings_.stages.size(); ++s)
    if (line_stages_[line][s].acts && !settings_.stages[s].local()) {
      options = options_of(line, s);
      break;
    }
  return options;
}

CurvatureFairingResult Fairing::least_curvature(size_t line, size_t s, const HermiteCurve& curve,
                                                const std::vector<Vec3>& points) const {
  constexpr size_t most = 200;
  if (points.size() > most)
    fail(s, std::to_string(points.size()) + " points of '" + names_[line] + "'",
         "at most " + std::to_string(most) +
             " for 'minimize', which interpolates all points including their noise");
  const PointSequence row(names_[line], points, 180, {}, curve.closed());
  std::vector<CurveThroughPoint> through;
  for (const Vec3& p : row.points) through.push_back({p});
  CurvatureFairingOptions options;
  options.functional = *settings_.stages[s].minimum;
  options.tolerance = 1e-6 * row.size;
  options.segments = std::max(16, 4 * row.count());
  return minimum_curvature_curve(through, curve.closed(), options);
}

void Fairing::run_stages(size_t line, FairedResult& result) {
  const std::vector<Vec3>& points = sampled_[line].points;
  FairedLine& report = result.report;
  HermiteCurve curve = result.states.front();
  std::vector<double> u = chord_parameters(curve, points);
  for (size_t s = 0; s < settings_.stages.size(); ++s) {
    if (line_stages_[line][s].acts && settings_.stages[s].local()) {
      curve = local(s, curve);
      report.faired = true;
    } else if (line_stages_[line][s].acts && settings_.stages[s].minimum) {
      const CurvatureFairingResult least = least_curvature(line, s, curve, at(curve, u));
      u = rescale_parameters(std::move(u), curve, least.curve);
      curve = least.curve;
      report.faired = true;
      report.rounds = least.rounds;
      report.converged = least.converged;
      report.max_residual = std::max(report.max_residual, least.max_residual);
    } else if (line_stages_[line][s].acts) {
      FairOptions options = options_of(line, s);
      options.closed = curve.closed();
      options.fix_ends = options.fix_ends && !curve.closed();
      const FairCurve fair = fair_points(
          names_[line],
          report.faired ? at(curve, closest_parameters_in_order(curve, points, u)) : points,
          options);
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
    }
    result.states.push_back(curve);
  }
  if (settings_.segments > 0) {
    HermiteCurve few = reduce_segments(names_[line], curve, settings_.segments);
    u = rescale_parameters(std::move(u), curve, few);
    result.states.back() = std::move(few);
  }
  result.parameters = closest_parameters_in_order(result.states.back(), points, u);
}

FairedResult Fairing::faired(size_t index) {
  const SampledLine& line = sampled_[index];
  FairedResult result;
  result.role = lines_[index].role;
  result.points = line.points;
  FairedLine& report = result.report;
  report.name = names_[index];
  report.points = isize(line.points);
  const std::string why = rejection_reason(index);
  if (!why.empty()) {
    result.warning = "curve '" + report.name + "' has " + why + " and is not faired";
    return result;
  }
  report.size = bounding_box(line.points).diagonal().norm();

  const auto start = std::chrono::steady_clock::now();
  result.states.push_back(interpolating_spline(report.name, line.points, given_options(index)));
  run_stages(index, result);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const HermiteCurve& curve = result.states.back();
  report.segments = curve.segment_count();
  report.closed = curve.closed();
  report.deviation = measured(report.name, curve, line, report.outliers,
                              batten::nearest(curve, line.points, result.parameters));
  report.before = fairness(result.states.front());
  report.after = fairness(curve);
  return result;
}

}  // namespace

NamedCurve FairedResult::named() const {
  if (!has_curve()) return {report.name, {}, {}, points};
  return {report.name, states.back(), parameters, {}};
}

std::string first_few(const std::vector<std::string>& names) {
  constexpr size_t few = 5;
  if (names.size() <= few) return comma_separated(names);
  return comma_separated({names.begin(), names.begin() + few}) + " and " +
         std::to_string(names.size() - few) + " more";
}

std::string describe_outliers(const FairedLine& line) {
  if (line.outliers.empty()) return "";
  std::vector<std::string> numbers;
  for (const int i : line.outliers) numbers.push_back(std::to_string(i + 1));
  const bool one = numbers.size() == 1;
  return "'" + line.name + "': " + (one ? "point " : "points ") + first_few(numbers) +
         (one ? " lies" : " lie") + " off the curve by more than its noise and " +
         (one ? "was ignored as an outlier" : "were ignored as outliers") +
         " (outliers = \"keep\" keeps " + (one ? "it)" : "them)");
}

std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress) {
  Fairing fairing(lines, settings, progress);
  std::vector<FairedResult> results(lines.size());
  for_each_line(lines.size(), progress, "fairing", [&](size_t i) {
    try {
      results[i] = fairing.faired(i);
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), lines[i].at);
    } catch (const InputError& e) {
      throw InputError(lines[i].at + e.what());
    }
  });
  fairing.check_brushes();
  return results;
}

}  // namespace batten
