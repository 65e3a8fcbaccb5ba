// Fits of input curves: exact where they are cubic, by samples otherwise.
#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/fairing/arc_length.h"
#include "batten/fairing/curve_fit.h"
#include "batten/fairing/point_sequence.h"

namespace batten {
namespace {

double degrees_at(const InputCurve& curve, double t) {
  const double e = 1e-9 * (curve.end() - curve.start());
  return degrees_between(curve.evaluate(t - e, 1), curve.evaluate(t + e, 1));
}

bool comes_back(const InputCurve& curve, double length) {
  return (curve.evaluate(curve.end()) - curve.evaluate(curve.start())).norm() <= 1e-9 * length;
}

double seam_degrees(const InputCurve& curve) {
  const double e = 1e-9 * (curve.end() - curve.start());
  return degrees_between(curve.evaluate(curve.end() - e, 1), curve.evaluate(curve.start() + e, 1));
}

// Largest distance from the curve of points of the input between the samples that were fitted.
double between_samples(const InputCurve& input, const ArcLength& arc, const CurveFit& fit,
                       const std::vector<double>& s) {
  double worst = 0;
  const double period = fit.curve.end() - fit.curve.start();
  for (size_t i = 0; i + 1 < s.size(); ++i)
    for (const double part : {0.1, 0.25, 0.5, 0.75, 0.9}) {
      const Vec3 p = input.evaluate(arc.parameter(s[i] + part * (s[i + 1] - s[i])));
      const double a = fit.parameters[i], b = i + 1 < fit.parameters.size()
                                                  ? fit.parameters[i + 1]
                                                  : fit.parameters[0] + period;
      const auto nearest = closest_on_curve(
          [&](double u, int order) { return fit.curve.evaluate(u, order); }, {a, b}, p);
      worst = std::max(worst, nearest.distance);
    }
  return worst;
}

// Derivatives by t on either side of each break of a piecewise cubic curve.
struct Slopes {
  std::vector<Vec3> before, after;
  double chords = 0;  // sum of the distances between breaks

  Slopes(const InputCurve& curve, const std::vector<double>& t)
      : before(t.size()), after(t.size()) {
    const size_t n = t.size();
    for (size_t i = 0; i + 1 < n; ++i) after[i] = curve.evaluate(t[i], 1);
    for (size_t i = 1; i < n; ++i) {
      // At its end a piece has the derivative that follows from three points and the one at its
      // start.
      const double h = t[i] - t[i - 1];
      const Vec3 a = curve.evaluate(t[i - 1]), m = curve.evaluate(t[i - 1] + 0.5 * h),
                 b = curve.evaluate(t[i]);
      before[i] = (4 * a - 8 * m + 4 * b) / h + after[i - 1];
      if (i + 1 < n && (before[i] - after[i]).norm() <= 1e-9 * after[i].norm())
        before[i] = after[i];
      chords += (b - a).norm();
    }
  }
};

// The curve over a mesh whose segment i is scale[i] times as long as the piece of the input.
HermiteCurve scaled_pieces(const InputCurve& curve, const std::vector<double>& t,
                           const Slopes& slopes, const CurveMesh& mesh,
                           const std::vector<double>& scale) {
  const auto n = isize(t);
  Points dofs(mesh.dof_count(), 3);
  for (int i = n - 1; i >= 0; --i) {
    if (mesh.closed() && i == n - 1) {
      dofs.row(mesh.slope_in(0)) = slopes.before[i] / scale[i - 1];
      continue;
    }
    dofs.row(mesh.position_dof(i)) = curve.evaluate(t[i]);
    if (i > 0) dofs.row(mesh.slope_in(i)) = slopes.before[i] / scale[i - 1];
    if (i + 1 < n) dofs.row(mesh.slope_out(i)) = slopes.after[i] / scale[i];
  }
  return {mesh, dofs};
}

}  // namespace

std::optional<HermiteCurve> exact_curve(const InputCurve& curve, double corner_angle) {
  if (!curve.piecewise_cubic()) return std::nullopt;
  const std::vector<double> t = curve.breaks();
  const auto n = isize(t);
  const Slopes slopes(curve, t);
  const auto &before = slopes.before, &after = slopes.after;
  // Where the direction goes on, the parameter of the next segment is scaled so that the speed
  // does.
  constexpr double same_direction = 1e-5;  // degrees
  std::vector<double> u = {0}, scale = {1};
  std::vector<int> corners;
  for (int i = 0; i + 1 < n; ++i) {
    if (i > 0) {
      const double turn = degrees_between(before[i], after[i]);
      if (!(before[i].norm() > 0) || !(after[i].norm() > 0)) return std::nullopt;
      if (turn > corner_angle) {
        corners.push_back(i);
        scale.push_back(1);
      } else if (turn > same_direction) {
        return std::nullopt;
      } else {
        scale.push_back(scale.back() * after[i].norm() / before[i].norm());
      }
    }
    u.push_back(u.back() + scale[i] * (t[i + 1] - t[i]));
  }
  bool closed = n > 2 && comes_back(curve, slopes.chords);
  if (closed) {
    const double turn = seam_degrees(curve);
    const double speeds = (before[n - 1].norm() / scale[n - 2]) / (after[0].norm() / scale[0]);
    if (turn > corner_angle)
      corners.insert(corners.begin(), 0);
    else
      closed = turn <= same_direction && std::abs(speeds - 1) < 1e-9;
  }
  // And all of it so that u has the length of the curve.
  const HermiteCurve exact = scaled_pieces(curve, t, slopes, CurveMesh(u, closed, corners), scale);
  const double stretch = ArcLength(curve_from_hermite(exact)).total() / exact.end();
  if (!(stretch > 0)) return std::nullopt;
  return exact.with_scaled_parameter(stretch);
}

HermiteCurve fit_curve(const std::string& name, std::shared_ptr<const InputCurve> curve,
                       const FitOptions& options) {
  check_tolerance(name, options.tolerance);
  if (!options.bisection_only && !options.fixed_parameters && !options.start && !options.end)
    if (auto exact = exact_curve(*curve, options.corner_angle))
      if (exact->closed() == options.closed.value_or(exact->closed())) return *exact;
  const ArcLength arc(curve);
  const double total = arc.total();
  const bool closed = options.closed.value_or(comes_back(*curve, total));
  // Corners are samples; between them samples lie evenly.
  std::vector<double> ends = {0};
  const std::vector<double> breaks = curve->breaks();
  for (size_t i = 1; i + 1 < breaks.size(); ++i)
    if (degrees_at(*curve, breaks[i]) > options.corner_angle)
      ends.push_back(arc.length_at(breaks[i]));
  ends.push_back(total);
  const bool seam = closed && seam_degrees(*curve) > options.corner_angle;

  FitOptions half = options;
  half.tolerance = 0.5 * options.tolerance;  // the rest is for what lies between the samples
  constexpr int most_samples = 1 << 14;
  for (int per_line = 64 + 8 * isize(breaks);; per_line *= 2) {
    std::vector<double> s;
    std::vector<int> corners;
    if (seam) corners.push_back(0);
    for (size_t k = 0; k + 1 < ends.size(); ++k) {
      const double part = ends[k + 1] - ends[k];
      const int n = std::max(8, static_cast<int>(per_line * part / total));
      if (k > 0) corners.push_back(isize(s));
      // Half of them evenly by length, half by the input's own parameter, which often runs slowly
      // where the curve bends.
      const double from = arc.parameter(ends[k]), to = arc.parameter(ends[k + 1]);
      std::vector<double> stretch;
      for (int i = 1; i < n; ++i) {
        stretch.push_back(ends[k] + part * i / n);
        stretch.push_back(arc.length_at(from + (to - from) * i / n));
      }
      std::sort(stretch.begin(), stretch.end());
      s.push_back(ends[k]);
      const double nearest = 1e-3 * part / n;
      for (const double at : stretch)
        if (at > s.back() + nearest && at < ends[k + 1] - nearest) s.push_back(at);
    }
    s.push_back(total);
    std::vector<Vec3> points;
    for (const double at : s) points.push_back(curve->evaluate(arc.parameter(at)));
    PointSequence sequence(name, points, 180, corners, closed);
    if (sequence.chord.size() == s.size()) sequence.chord = s;
    const CurveFit fit = fit_point_sequence(name, sequence, half);
    const double off = std::max(fit.deviation.max, between_samples(*curve, arc, fit, s));
    constexpr double sure = 0.9;  // a peak may lie between the points that were looked at
    if (off <= sure * options.tolerance) return fit.curve;
    if (2 * per_line > most_samples)
      throw InputError("line '" + name + "' is not within " + format_number(options.tolerance) +
                       " of a smooth curve (off by " + format_number(off) +
                       "): is there a corner, or is the tolerance too small?");
  }
}

}  // namespace batten
