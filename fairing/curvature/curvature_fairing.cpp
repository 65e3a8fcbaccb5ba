// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curvature/curvature_fairing.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/quadrature.h"
#include "batten/fairing/curvature/curvature_minimizer.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {
namespace {

// Limits for ending the rounds. kEven: relative difference of arc length and parametric length (its
// square times parametrization_weight is what remains of their effect). kStill: motion of the foot
// points of springs.
constexpr double kEven = 1e-4, kStill = 1e-5;
// Stiffness of a spring along the curve over that across it; enters squared.
constexpr double kAlong = 0.3;

void check(const CurvatureFairingOptions& o) {
  const auto require = [](bool good, const char* name, double found, const char* expected) {
    if (!good)
      throw InputError(std::string("curvature fairing: found ") + name + " = " +
                       format_number(found) + ", expected " + expected);
  };
  require(o.tolerance > 0 && std::isfinite(o.tolerance), "tolerance", o.tolerance,
          "a length above 0");
  require(o.segments > 0, "segments", o.segments, "1 or more");
  require(o.length_weight >= 0 && std::isfinite(o.length_weight), "length_weight", o.length_weight,
          "0 or more");
  require(o.parametrization_weight > 0 && std::isfinite(o.parametrization_weight),
          "parametrization_weight", o.parametrization_weight, "a number above 0");
  require(o.max_rounds > 0, "max_rounds", o.max_rounds, "1 or more");
  require(o.max_iterations > 0, "max_iterations", o.max_iterations, "1 or more");
}

void check(const HermiteCurve& start, const std::vector<FixedCurvePoint>& fixed_points,
           const std::vector<CurveSpring>& springs) {
  if (start.node_count() < 2) throw InputError("the curve to be faired has no nodes");
  if (!start.mesh().corners().empty())
    throw InputError("a curve with corners cannot be faired as a whole: split it at its corners");
  for (const CurveSpring& spring : springs)
    if (!spring.point.allFinite() || !(spring.stiffness > 0) || !std::isfinite(spring.stiffness))
      throw InputError("a spring needs a finite point and a stiffness above 0");
  const auto held = std::count_if(fixed_points.begin(), fixed_points.end(),
                                  [](const auto& h) { return h.position; });
  if (held < 2 && springs.size() < 2)
    throw InputError("curvature fairing needs two fixed points or two springs, found fewer");
}

// Bounding box of a curve: its centre becomes the origin and its diagonal 1.
struct Frame {
  Vec3 origin;
  double size;

  explicit Frame(const HermiteCurve& curve) {
    Box3 box(curve.position(0));
    constexpr int samples = 8;
    for (int i = 0; i < curve.segment_count(); ++i)
      for (int k = 0; k <= samples; ++k)
        box.extend(curve.evaluate(CurveMesh::SegmentPoint{i, static_cast<double>(k) / samples}));
    origin = box.center();
    size = box.diagonal().norm();
    if (!(size > 0)) throw InputError("a curve of length zero cannot be faired");
  }
};

// Node parameters: at the fixed points and evenly spaced between them. node_of: node of each fixed
// point.
struct Nodes {
  std::vector<double> u;  // including the end of a closed curve
  std::vector<int> node_of;
};

Nodes place_nodes(const HermiteCurve& start, const std::vector<FixedCurvePoint>& fixed_points,
                  int segments) {
  std::vector<double> cuts = {start.start(), start.end()};
  for (const FixedCurvePoint& hold : fixed_points) {
    if (!(hold.u >= start.start() && hold.u <= start.end()))
      throw InputError("found a fixed point at u = " + format_number(hold.u) + ", expected " +
                       format_number(start.start()) + " to " + format_number(start.end()));
    if (start.closed() && hold.u == start.end())
      throw InputError(
          "found a fixed point at the end of a closed curve, expected it at its start");
    cuts.push_back(hold.u);
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  const double shortest = 1e-9 * (start.end() - start.start());
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    if (cuts[i + 1] - cuts[i] < shortest)
      throw InputError("found two fixed points near u = " + format_number(cuts[i]));
  const int spans = isize(cuts) - 1, least = std::max(spans, start.closed() ? 2 : 1);
  if (segments < least)
    throw InputError("found " + std::to_string(segments) + " segments, expected at least " +
                     std::to_string(least) + ", one between adjacent fixed points");

  // Adds one segment at a time to the span whose segments are longest.
  std::vector<int> count(spans, 1);
  const auto piece = [&](int s) { return (cuts[s + 1] - cuts[s]) / count[s]; };
  for (int n = spans; n < segments; ++n) {
    int longest = 0;
    for (int s = 1; s < spans; ++s)
      if (piece(s) > piece(longest) * (1 + 1e-9)) longest = s;
    ++count[longest];
  }
  Nodes nodes;
  for (int s = 0; s < spans; ++s)
    for (int k = 0; k < count[s]; ++k)
      nodes.u.push_back(cuts[s] + (cuts[s + 1] - cuts[s]) * k / count[s]);
  nodes.u.push_back(cuts.back());
  for (const FixedCurvePoint& hold : fixed_points)
    nodes.node_of.push_back(static_cast<int>(
        std::lower_bound(nodes.u.begin(), nodes.u.end(), hold.u) - nodes.u.begin()));
  return nodes;
}

// The initial quintic curve of size 1 over arc length. Its nodes have the positions, tangents and
// curvature vectors (mean of both sides) of the start.
QuinticCurve quintic_start(const HermiteCurve& start, const Frame& frame, const Nodes& nodes) {
  static const SegmentRule rule = gauss_legendre(16);
  std::vector<double> s = {0};
  for (size_t i = 0; i + 1 < nodes.u.size(); ++i) {
    const double h = nodes.u[i + 1] - nodes.u[i];
    double length = 0;
    for (long p = 0; p < rule.s.size(); ++p)
      length += h * rule.weights[p] * start.evaluate(nodes.u[i] + h * rule.s[p], 1).norm();
    s.push_back(s.back() + length / frame.size);
  }
  const auto n = static_cast<long>(nodes.u.size()) - (start.closed() ? 1 : 0);
  Points dofs(3 * n, 3);
  const double aside = 1e-7 * (start.end() - start.start());
  for (long i = 0; i < n; ++i) {
    const double u = nodes.u[i];
    const Vec3 d1 = start.evaluate(u, 1);
    const double speed = d1.norm();
    if (!(speed > 0)) throw InputError("the curve has no direction at u = " + format_number(u));
    const Vec3 t = d1 / speed;
    const Vec3 bend = 0.5 * (start.evaluate(u - aside, 2) + start.evaluate(u + aside, 2));
    dofs.row(3 * i) = (start.evaluate(u) - frame.origin) / frame.size;
    dofs.row(3 * i + 1) = t;
    dofs.row(3 * i + 2) = frame.size / (speed * speed) * (bend - t * t.dot(bend));
  }
  return {s, dofs, start.closed()};
}

double total_length(const QuinticCurve& curve) {
  double sum = 0;
  for (int i = 0; i < curve.segment_count(); ++i) sum += curve.arc_length(i);
  return sum;
}

// Reparametrises by arc length. Returns the largest relative change; the shape changes by as
// little.
double make_even(QuinticCurve& curve) {
  std::vector<double> u = {0};
  double change = 0;
  for (int i = 0; i < curve.segment_count(); ++i) {
    const double length = curve.arc_length(i);
    change = std::max(change, std::abs(length / curve.length(i) - 1));
    u.push_back(u.back() + length);
  }
  Points dofs = curve.dofs();
  for (int i = 0; i < curve.node_count(); ++i) {
    const double speed = dofs.row(3L * i + 1).norm();
    dofs.row(3L * i + 1) /= speed;
    dofs.row(3L * i + 2) /= speed * speed;
  }
  curve = QuinticCurve(u, dofs, curve.closed());
  return change;
}

double nearest_parameter(const QuinticCurve& curve, const Vec3& p) {
  std::vector<double> u;
  constexpr int samples = 8;
  for (int i = 0; i < curve.segment_count(); ++i)
    for (int k = 0; k < samples; ++k)
      u.push_back(curve.parameters()[i] + curve.length(i) * k / samples);
  u.push_back(curve.parameters().back());
  return closest_on_curve([&](double at, int order) { return curve.evaluate(at, order); }, u, p).u;
}

// Attaches the springs at the foot points. Along the curve they are weak, so that points can slide.
// At the foot points of the final curve this component vanishes; without it, a step would slide far
// along tangents that are not yet those of the result. Returns the largest displacement of a foot
// point.
double move_springs(const std::vector<CurveSpring>& given, const Frame& frame,
                    CurvatureMinimization& problem) {
  const QuinticCurve& curve = problem.curve;
  double moved = 0;
  const auto before = std::move(problem.springs);
  problem.springs.clear();
  for (size_t i = 0; i < given.size(); ++i) {
    const Vec3 p = (given[i].point - frame.origin) / frame.size;
    const double u = nearest_parameter(curve, p);
    const Vec3 t = curve.evaluate(u, 1).normalized();
    const bool end =
        !curve.closed() && (u == curve.parameters().front() || u == curve.parameters().back());
    const Mat3 across = Mat3::Identity() - (end ? 0 : 1 - kAlong) * t * t.transpose();
    problem.springs.push_back({curve.locate(u), p, std::sqrt(given[i].stiffness) * across});
    if (!before.empty())
      moved = std::max(
          moved, (curve.evaluate(problem.springs[i].at) - curve.evaluate(before[i].at)).norm());
  }
  return before.empty() ? (given.empty() ? 0 : 1) : moved;
}

// Transforms back to model units; fixed positions are bit-identical to the start only after
// finish_curves().
QuinticCurve in_model_units(const QuinticCurve& curve, const Frame& frame) {
  std::vector<double> u = curve.parameters();
  for (double& x : u) x *= frame.size;
  Points dofs = curve.dofs();
  for (long i = 0; i < dofs.rows(); i += 3) {
    dofs.row(i) = frame.origin.transpose() + frame.size * dofs.row(i);
    dofs.row(i + 2) /= frame.size;
  }
  return {u, dofs, curve.closed()};
}

// Runs the rounds of fair_curvature() for one curve.
class CurvatureFairing {
 public:
  CurvatureFairing(const HermiteCurve& start, const std::vector<FixedCurvePoint>& fixed_points,
                   const std::vector<CurveSpring>& springs, const CurvatureFairingOptions& options)
      : start_(start),
        holds_(fixed_points),
        springs_(springs),
        options_(options),
        frame_(start),
        nodes_(place_nodes(start, fixed_points, options.segments)) {
    problem_.curve = quintic_start(start, frame_, nodes_);
    problem_.functional = options.functional;
    problem_.length_weight = options.length_weight;
    problem_.parametrization_weight = options.parametrization_weight;
    problem_.max_iterations = options.max_iterations;
    problem_.fixed_position.assign(problem_.curve.node_count(), 0);
    problem_.fixed_tangent.assign(problem_.curve.node_count(), 0);
    for (size_t i = 0; i < fixed_points.size(); ++i) {
      if (fixed_points[i].position) problem_.fixed_position[nodes_.node_of[i]] = 1;
      if (fixed_points[i].tangent) problem_.fixed_tangent[nodes_.node_of[i]] = 1;
    }
  }

  CurvatureFairingResult run() {
    result_.start_functional =
        curvature_functional(in_model_units(problem_.curve, frame_), options_.functional);
    minimize_in_rounds();
    finish_curves();
    measure_fixed_points();
    measure_deviation();
    return std::move(result_);
  }

 private:
  void minimize_in_rounds() {
    const double start_length = total_length(problem_.curve);
    bool still_now = false;
    double last_change = 1e300;
    move_springs(springs_, frame_, problem_);
    while (result_.rounds < options_.max_rounds && !still_now) {
      minimize_once(start_length);
      QuinticCurve even = problem_.curve;
      // A curve of few segments cannot become as even as kEven: it suffices that it stops
      // improving.
      const double change = make_even(even);
      const bool even_now = change < kEven || change > 0.5 * last_change;
      last_change = change;
      still_now = move_springs(springs_, frame_, problem_) < kStill && even_now;
      if (!still_now && result_.rounds < options_.max_rounds) problem_.curve = std::move(even);
    }
    result_.converged = result_.converged && still_now;
  }

  void minimize_once(double start_length) {
    constexpr double out_of_bounds = 50;
    const CurvatureMinimizationResult minimum = minimize(problem_);
    ++result_.rounds;
    result_.iterations += minimum.iterations;
    result_.converged = minimum.converged;
    QuinticCurve& curve = problem_.curve;
    curve = QuinticCurve(curve.parameters(), minimum.dofs, curve.closed());
    if (!(total_length(curve) < out_of_bounds * start_length))
      throw NoSolutionError("the curve grows without bound; use a length_weight above 0");
  }

  // Transforms to model units, restores fixed positions bit for bit, and approximates by cubics.
  void finish_curves() {
    const QuinticCurve curve = in_model_units(problem_.curve, frame_);
    Points dofs = curve.dofs();
    for (size_t i = 0; i < holds_.size(); ++i)
      if (holds_[i].position) dofs.row(3L * nodes_.node_of[i]) = start_.evaluate(holds_[i].u);
    result_.quintic = QuinticCurve(curve.parameters(), dofs, curve.closed());
    result_.functional = curvature_functional(result_.quintic, options_.functional);
    result_.curve = result_.quintic.cubics(options_.tolerance);
  }

  void measure_fixed_points() {
    for (size_t i = 0; i < holds_.size(); ++i) {
      const FixedCurvePoint& hold = holds_[i];
      const double u = result_.quintic.parameters()[nodes_.node_of[i]];
      result_.parameters.push_back(u);
      const Vec3 x = start_.evaluate(hold.u), t = start_.evaluate(hold.u, 1).normalized();
      double residual = 0;
      if (hold.position) residual = (result_.curve.evaluate(u) - x).norm() / frame_.size;
      if (hold.tangent)
        residual = std::max(residual, (result_.curve.evaluate(u, 1).normalized() - t).norm());
      result_.max_residual = std::max(result_.max_residual, residual);
    }
  }

  void measure_deviation() {
    constexpr int samples = 37;  // differs from the samples of cubics()
    const HermiteCurve& cubics = result_.curve;
    for (int i = 0; i < cubics.segment_count(); ++i)
      for (int k = 1; k < samples; ++k) {
        const double u = cubics.parameters()[i] + cubics.mesh().length(i) * k / samples;
        result_.deviation =
            std::max(result_.deviation, (cubics.evaluate(u) - result_.quintic.evaluate(u)).norm());
      }
  }

  const HermiteCurve& start_;
  const std::vector<FixedCurvePoint>& holds_;
  const std::vector<CurveSpring>& springs_;
  const CurvatureFairingOptions& options_;
  Frame frame_;
  Nodes nodes_;
  CurvatureMinimization problem_;
  CurvatureFairingResult result_;
};

}  // namespace

double curvature_functional(const QuinticCurve& curve, CurveFunctional functional, int points) {
  const SegmentRule rule = gauss_legendre(points);
  double sum = 0;
  for (int i = 0; i < curve.segment_count(); ++i)
    for (long p = 0; p < rule.s.size(); ++p) {
      const auto d = [&](int order) { return curve.evaluate({i, rule.s[p]}, order); };
      sum += curve.length(i) * rule.weights[p] *
             curvature_root<double>(functional, d(1), d(2), d(3)).squaredNorm();
    }
  return sum;
}

CurvatureFairingResult fair_curvature(const HermiteCurve& start,
                                      const std::vector<FixedCurvePoint>& fixed_points,
                                      const std::vector<CurveSpring>& springs,
                                      const CurvatureFairingOptions& options) {
  check(options);
  check(start, fixed_points, springs);
  return CurvatureFairing(start, fixed_points, springs, options).run();
}

namespace {

// Tangent at the middle of three points to the circle through them.
Vec3 circle_tangent(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e = b - a, f = c - b;
  const Vec3 t = e / e.squaredNorm() + f / f.squaredNorm();
  return t.norm() > 1e-9 / e.norm() ? t.normalized() : f.normalized();
}

// Tangent at the other end of a circular arc over the chord, given the tangent t at one end.
Vec3 mirrored(const Vec3& chord, const Vec3& t) {
  const Vec3 c = chord.normalized();
  return 2 * t.dot(c) * c - t;
}

// Length of the circular arc over a chord with these end tangents; at most three chords.
double arc_over(const Vec3& chord, const Vec3& t0, const Vec3& t1) {
  const double length = chord.norm();
  const auto angle = [&](const Vec3& t) { return std::atan2(t.cross(chord).norm(), t.dot(chord)); };
  const double half = std::min(0.5 * (angle(t0) + angle(t1)), 2.28);
  return half > 1e-4 ? length * half / std::sin(half) : length;
}

}  // namespace

CurvatureFairingResult minimum_curvature_curve(const std::vector<CurveThroughPoint>& points,
                                               bool closed,
                                               const CurvatureFairingOptions& options) {
  const auto n = static_cast<long>(points.size());
  if (n < (closed ? 3 : 2))
    throw InputError("found " + std::to_string(n) + " points, expected at least " +
                     (closed ? "three for a closed curve" : "two"));
  const auto at = [&](long i) -> const Vec3& { return points[(i + n) % n].position; };
  for (long i = 0; i < n; ++i) {
    const std::string name = "point " + std::to_string(i + 1);
    const auto& tangent = points[i].tangent;
    if (!at(i).allFinite() || (tangent && !tangent->allFinite()))
      throw InputError(name + " has a value that is not finite");
    if (tangent && !(tangent->norm() > 0)) throw InputError(name + " has a tangent of length zero");
    if ((i > 0 || closed) && at(i) == at(i - 1))
      throw InputError(name + " coincides with the point before it");
  }

  std::vector<Vec3> t(n);
  const auto given = [&](long i) { return points[i].tangent.has_value(); };
  for (long i = 0; i < n; ++i) {
    if (given(i))
      t[i] = points[i].tangent->normalized();
    else if (closed || (i > 0 && i < n - 1))
      t[i] = circle_tangent(at(i - 1), at(i), at(i + 1));
  }
  if (!closed && n == 2 && !given(0) && !given(1))
    t[0] = t[1] = (at(1) - at(0)).normalized();
  else if (!closed) {
    if (!given(0)) t[0] = mirrored(at(1) - at(0), t[1]);
    if (!given(n - 1)) t[n - 1] = mirrored(at(n - 1) - at(n - 2), t[n - 2]);
  }

  std::vector<double> u = {0};
  for (long i = 0; i + 1 < n + (closed ? 1 : 0); ++i)
    u.push_back(u.back() + arc_over(at(i + 1) - at(i), t[i], t[(i + 1) % n]));
  Points dofs(2 * n, 3);
  std::vector<FixedCurvePoint> fixed_points;
  for (long i = 0; i < n; ++i) {
    dofs.row(2 * i) = at(i);
    dofs.row(2 * i + 1) = t[i];
    fixed_points.push_back({u[i], true, given(i)});
  }
  return fair_curvature(HermiteCurve(CurveMesh(u, closed), dofs), fixed_points, {}, options);
}

}  // namespace batten
