// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/curve_fit_problem.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {
namespace {

using Problem = CurveFitProblem;
using Corners = std::vector<double>;  // curve parameters

// Node parameters are rounded to this fraction of the whole. The same curve in mm and in m is then
// split at the same positions, and a mesh can have a vertex exactly there.
double on_grid(double u, double whole) {
  constexpr double grid = 1 << 30;
  return std::round(u / whole * grid) / grid * whole;
}

std::vector<int> corner_nodes(const std::vector<double>& knots, const Corners& corners) {
  std::vector<int> nodes;
  for (size_t i = 0; i < knots.size(); ++i)
    if (std::binary_search(corners.begin(), corners.end(), knots[i]))
      nodes.push_back(static_cast<int>(i));
  return nodes;
}

// -- insertion of nodes ---------------------------------------------------------------------------

// Parameter for a new node in segment s: at the point that halves the sum of squared distances, or
// at the midpoint if `halve`.
std::optional<double> split_of(const Problem& fit, const HermiteCurve& curve, int s, int first,
                               int behind, bool halve) {
  const double a = fit.mesh.parameters()[s], b = fit.mesh.parameters()[s + 1];
  if (halve) return first < behind ? std::optional(0.5 * (a + b)) : std::nullopt;
  std::vector<double> inside, sum = {0};
  for (int i = first; i < behind; ++i) {
    const FitPoint& p = fit.points[i];
    // A point at which the curve was split earlier has moved a little since.
    constexpr double apart = 0.05;
    const double gap_behind = i + 1 < fit.count() ? fit.points[i + 1].gap : fit.points[0].gap;
    if (p.t - a <= std::max(1e-3 * (b - a), apart * p.gap) ||
        b - p.t <= std::max(1e-3 * (b - a), apart * gap_behind))
      continue;
    inside.push_back(p.t);
    sum.push_back(sum.back() + (curve.evaluate(p.t) - p.x).squaredNorm() + 1e-300);
  }
  if (inside.empty()) return std::nullopt;
  const auto half =
      std::lower_bound(sum.begin() + 1, sum.end(), 0.5 * sum.back()) - sum.begin() - 1;
  // Not so close to an end that the remaining piece has nothing to fit.
  const auto n = static_cast<long>(inside.size());
  return inside[std::clamp<long>(half, n / 4, n - 1 - n / 4)];
}

// The mesh with an additional node in every segment that misses the tolerance; empty if none of
// them has a point to split it at.
std::vector<double> split_mesh(const Problem& fit, bool halve) {
  const std::vector<int> first = fit.first_points();
  const HermiteCurve curve(fit.mesh, fit.dofs);
  std::vector<double> u = fit.mesh.parameters();
  const size_t before = u.size();
  for (int s = 0; s < fit.mesh.segment_count(); ++s)
    if (fit.segment_errors[s] > fit.tolerance)
      if (const auto at = split_of(fit, curve, s, first[s], first[s + 1], halve))
        u.push_back(on_grid(*at, fit.mesh.end()));
  std::sort(u.begin(), u.end());
  u.erase(std::unique(u.begin(), u.end()), u.end());  // the grid is as fine as parameters can be
  if (u.size() == before) return {};
  return u;
}

// Interpolates all points: a node at every point, parameters by chord length, least bending.
// Returns false if that was done before.
bool interpolate(Problem& fit, const PointSequence& row, const Corners& corners) {
  if (std::all_of(fit.points.begin(), fit.points.end(),
                  [](const FitPoint& p) { return p.fixed_parameter; }))
    return false;
  std::vector<NodeConstraint> node_constraints;
  auto given_constraint = fit.node_constraints.begin();
  for (int i = 0; i < row.count(); ++i) {
    FitPoint& p = fit.points[i];
    p.t = row.chord[i];
    p.fixed_parameter = true;
    const bool is_given =
        given_constraint != fit.node_constraints.end() && given_constraint->u == p.t;
    node_constraints.push_back(is_given ? *given_constraint++
                                        : NodeConstraint{p.t, p.x, {}, {}, true});
  }
  fit.node_constraints = std::move(node_constraints);
  fit.set_mesh(row.chord, corner_nodes(row.chord, corners));
  return true;
}

// Fallback if the spline through all points still oscillates: fixes the slopes there too. They get
// the mean direction of the adjacent chords and at most unit speed, which bounds every bulge by a
// third of its chord. Returns false if that was done before.
bool clamp_slopes(Problem& fit) {
  const int n = fit.count(), nodes = fit.mesh.node_count();
  bool changed = false;
  for (int s = 0; s < fit.mesh.segment_count(); ++s) {
    if (fit.segment_errors[s] <= fit.tolerance) continue;
    for (const int node : {s, (s + 1) % nodes}) {
      NodeConstraint& node_constraints =
          fit.node_constraints[node];  // there is one per point, and thus per node
      if (node_constraints.slope_in || node_constraints.slope_out || fit.mesh.is_corner(node))
        continue;
      if (!fit.closed && (node == 0 || node == n - 1)) continue;
      const Vec3 x = fit.points[node].x, before = x - fit.points[(node + n - 1) % n].x,
                 after = fit.points[(node + 1) % n].x - x;
      node_constraints.slope_in = node_constraints.slope_out =
          (after.norm() * before.normalized() + before.norm() * after.normalized()) /
          (before.norm() + after.norm());
      changed = true;
    }
  }
  return changed;
}

// -- removal of nodes -----------------------------------------------------------------------------

std::vector<NodeConstraint>::const_iterator first_constraint(const Problem& fit, double u) {
  return std::lower_bound(fit.node_constraints.begin(), fit.node_constraints.end(), u,
                          [](const NodeConstraint& h, double at) { return h.u < at; });
}

// A part of a fit between two nodes that keep position and slope, from which the nodes in between
// are removed.
struct Window {
  int a, b;         // first and last node of the part
  double from, to;  // parameters of the first and the last removed node
  int first_point;  // index of its first point in the whole fit; negative: before the seam
  Problem part;

  // Removes `removed` nodes from `node` on, or replaces them by one node.
  Window(const Problem& fit, int node, int removed, std::optional<double> instead,
         const Corners& corners)
      : a(std::max(0, node - reach)),
        b(std::min(fit.mesh.segment_count(), node + removed - 1 + reach)) {
    const auto& u = fit.mesh.parameters();
    from = u[node];
    to = u[node + removed - 1];
    std::vector<double> knots(u.begin() + a, u.begin() + b + 1);
    const auto at = knots.begin() + (node - a);
    const auto behind = knots.erase(at, at + removed);
    if (instead) knots.insert(behind, on_grid(from + *instead * (to - from), u.back()));
    part.tolerance = fit.tolerance;
    part.fixed_parameters = fit.fixed_parameters;
    take_points(fit, knots.front(), knots.back());
    take_constraints(fit, knots.front(), knots.back());
    std::vector<int> nodes = corner_nodes(knots, corners);
    std::erase_if(nodes, [&](int i) { return i == 0 || i + 1 == isize(knots); });
    part.set_mesh(std::move(knots), nodes);
  }

  bool removes(double u) const { return u >= from && u <= to; }
  // Fits the part; returns its error over the tolerance, at least 1.
  double fitted() {
    constexpr int rounds = 6;
    part.iterate(rounds);
    return part.done() ? 1 : part.worst() / part.tolerance;
  }

 private:
  static constexpr int reach = 2;  // number of segments on either side

  void take_points(const Problem& fit, double start, double end) {
    // Includes the points before and behind, because the gaps to them count too.
    const int n = fit.count();
    first_point = fit.first_from(start) - 1;
    int behind = fit.first_behind(end) + 1;
    if (!fit.closed) {
      first_point = std::max(first_point, 0);
      behind = std::min(behind, n);
    }
    for (int i = first_point; i < behind; ++i) {
      part.points.push_back(fit.points[(i + n) % n]);
      FitPoint& p = part.points.back();
      p.t += i < 0 ? -fit.period() : i >= n ? fit.period() : 0;
      if (removes(p.t)) p.fixed_parameter = false;
    }
  }

  void take_constraints(const Problem& fit, double start, double end) {
    const CurveMesh& m = fit.mesh;
    const Vec3 out = fit.dof(m.slope_out(a));
    part.node_constraints.push_back({start, fit.dof(m.position_dof(a)), out, out});
    for (auto it = first_constraint(fit, start); it != fit.node_constraints.end() && it->u < end;
         ++it)
      if (it->u > start && !removes(it->u)) part.node_constraints.push_back(*it);
    const int last = b % m.node_count();
    const Vec3 in = fit.dof(m.slope_in(last));
    part.node_constraints.push_back({end, fit.dof(m.position_dof(last)), in, in});
  }
};

// Inserts these windows into the fit. They are in order and share at most end nodes.
void put_back(Problem& fit, const Corners& corners, const std::vector<Window>& windows) {
  struct Source {
    const CurveMesh* mesh;
    const Points* dofs;
    int node;
  };
  const CurveMesh old = fit.mesh;
  const Points before = fit.dofs;
  std::vector<double> u;
  std::vector<Source> sources;
  int next = 0;
  const auto keep_to = [&](int node) {
    for (; next <= node; ++next) {
      u.push_back(old.parameters()[next]);
      if (next < old.node_count()) sources.push_back({&old, &before, next});
    }
  };
  for (const Window& w : windows) {
    for (int k = 0; k < w.part.count(); ++k) {
      const int i = w.first_point + k;
      if (i < 0 || i >= fit.count()) continue;
      fit.points[i].t = w.part.points[k].t;
      fit.points[i].fixed_parameter = w.part.points[k].fixed_parameter;
    }
    keep_to(w.a);
    for (int k = 1; k < w.part.mesh.segment_count(); ++k) {
      u.push_back(w.part.mesh.parameters()[k]);
      sources.push_back({&w.part.mesh, &w.part.dofs, k});
    }
    next = w.b;
  }
  keep_to(old.segment_count());
  auto w = windows.begin();
  std::erase_if(fit.node_constraints, [&](const NodeConstraint& h) {
    while (w != windows.end() && w->to < h.u) ++w;
    return w != windows.end() && w->removes(h.u);
  });
  const std::vector<int> at_corners = corner_nodes(u, corners);
  fit.set_mesh(std::move(u), at_corners);
  fit.dofs.resize(fit.mesh.dof_count(), 3);
  for (int node = 0; node < fit.mesh.node_count(); ++node) {
    const Source& source = sources[node];
    const auto copy = [&](int to, int from) { fit.dofs.row(to) = source.dofs->row(from); };
    copy(fit.mesh.position_dof(node), source.mesh->position_dof(source.node));
    copy(fit.mesh.slope_in(node), source.mesh->slope_in(source.node));
    copy(fit.mesh.slope_out(node), source.mesh->slope_out(source.node));
  }
}

bool is_removable(const Problem& fit, int node) {
  const double u = fit.mesh.parameters()[node];
  for (auto it = first_constraint(fit, u); it != fit.node_constraints.end() && it->u == u; ++it)
    if (!it->removable) return false;
  return true;
}

// For many nodes: tries every fourth node in parallel and removes all that can go, until few can.
// One at a time, a long segment would absorb the points of a straight line one after the other.
void remove_knots_in_parallel(Problem& fit, const Corners& corners) {
  constexpr int many = 200, side_by_side = 4;
  constexpr double few = 0.95;
  for (int before = std::numeric_limits<int>::max();
       fit.mesh.segment_count() > many && fit.mesh.segment_count() < few * before;) {
    before = fit.mesh.segment_count();
    for (int offset = 0; offset < side_by_side; ++offset) {
      std::vector<int> nodes;
      for (int node = 2 + offset; node + 2 <= fit.mesh.segment_count(); node += side_by_side)
        if (is_removable(fit, node)) nodes.push_back(node);
      std::vector<std::optional<Window>> tried(nodes.size());
      parallel_for_each<16>(isize(nodes), [&](int i) {
        Window window(fit, nodes[i], 1, {}, corners);
        if (window.fitted() <= 1) tried[i] = std::move(window);
      });
      std::vector<Window> gone;
      for (auto& window : tried)
        if (window) gone.push_back(std::move(*window));
      put_back(fit, corners, gone);
    }
  }
}

// Removes nodes without which their neighbourhood can still be fitted: a window of segments is
// solved again, everything outside stays unchanged.
void remove_knots(Problem& fit, const Corners& corners) {
  // Removes one node, or replaces two by one at the relative position `instead`. Returns the error
  // over the tolerance; the nodes are removed if it is at most 1.
  const auto attempt = [&](int node, int removed, std::optional<double> instead) {
    Window window(fit, node, removed, instead, corners);
    if (fit.closed && window.b - window.a == fit.mesh.segment_count() &&
        fit.mesh.segment_count() <= 3)
      return std::numeric_limits<double>::infinity();
    const double reached = window.fitted();
    if (reached <= 1) put_back(fit, corners, {std::move(window)});
    return reached;
  };
  for (int node = 1; node < fit.mesh.segment_count(); ++node) {
    if (!is_removable(fit, node)) continue;
    bool gone = attempt(node, 1, {}) <= 1;
    if (!gone && node + 1 < fit.mesh.segment_count() && is_removable(fit, node + 1)) {
      constexpr double nearly = 1.5;
      const double reached = attempt(node, 2, 0.5);
      gone = reached <= 1 || (reached < nearly && (attempt(node, 2, 0.2) <= 1 ||  //
                                                   attempt(node, 2, 0.8) <= 1));
    }
    if (gone) node = std::max(0, node - 2);  // tries the previous nodes again
  }
}

// -- the whole fit --------------------------------------------------------------------------------

// Initial problem: points at their chord lengths, the user's constraints, and one segment from
// corner to corner.
Problem problem_of(const PointSequence& row, const FitOptions& options, const Corners& corners) {
  Problem fit;
  const double least = 4e-15 * (row.points[0].cwiseAbs().maxCoeff() + row.size);
  fit.tolerance = std::max(options.tolerance, least);
  fit.closed = row.closed;
  fit.fixed_parameters = options.fixed_parameters;
  for (int i = 0; i < row.count(); ++i) fit.points.push_back({row.points[i], row.chord[i]});
  std::vector<double> knots = {0};
  for (const int c : row.corners) {
    if (c > 0) knots.push_back(row.chord[c]);
    fit.node_constraints.push_back({row.chord[c], row.points[c], {}, {}});
    fit.points[c].fixed_parameter = true;
  }
  knots.push_back(row.length());
  if (!row.closed) {
    const auto end = [&](const std::optional<CurveEnd>& given, FitPoint& p,
                         double u) -> NodeConstraint {
      p.fixed_parameter = true;
      if (!given) return {u, p.x, {}, {}};
      p.x = given->position;
      return {u, p.x, given->tangent, given->tangent};
    };
    fit.node_constraints.insert(fit.node_constraints.begin(),
                                end(options.start, fit.points.front(), 0));
    fit.node_constraints.push_back(end(options.end, fit.points.back(), row.length()));
  } else if (knots.size() < 5) {
    // A closed curve starts with at least four segments.
    for (size_t i = 0; knots.size() < 5; i += 2) {
      if (i + 1 >= knots.size()) i = 0;
      knots.insert(knots.begin() + static_cast<long>(i) + 1, 0.5 * (knots[i] + knots[i + 1]));
    }
    std::sort(knots.begin(), knots.end());
  }
  double curvature = row.curvature(row.closed ? row.count() - 1 : 0);
  for (int j = row.closed ? 0 : 1; j < row.count(); ++j) {
    const double before = std::exchange(curvature, row.curvature(j));
    fit.points[j].gap = (fit.points[j].x - fit.points[j > 0 ? j - 1 : row.count() - 1].x).norm();
    fit.points[j].sagitta = sagitta_bound(fit.points[j].gap, std::max(before, curvature));
  }
  fit.set_mesh(knots, corner_nodes(knots, corners));
  return fit;
}

}  // namespace

CurveFit fit_point_sequence(const std::string& name, PointSequence row, const FitOptions& options) {
  check_tolerance(name, options.tolerance);
  for (double& u : row.chord) u = on_grid(u, row.length());
  Corners corners;
  for (const int c : row.corners) corners.push_back(row.chord[c]);
  Problem fit = problem_of(row, options, corners);
  constexpr int rounds = 30;
  for (fit.iterate(rounds); !fit.done(); fit.iterate(rounds)) {
    std::vector<double> u = split_mesh(fit, options.bisection_only);
    if (u.empty() || fit.node_constraints.size() == fit.points.size()) {
      // Segments that fail have no point left to split at: interpolate the points instead. Meshes
      // by bisection stay as they are and are reported as too far off.
      if (options.bisection_only || (!interpolate(fit, row, corners) && !clamp_slopes(fit))) break;
      continue;
    }
    if (isize(u) - 1 > options.max_segments)
      throw InputError("curve '" + name + "' cannot be fitted within the tolerance " +
                       format_number(options.tolerance) + ": with " + std::to_string(u.size() - 1) +
                       " segments the deviation is " + format_number(fit.worst()) +
                       "; add a corner, or increase the tolerance");
    const std::vector<int> at_corners = corner_nodes(u, corners);
    fit.set_mesh(std::move(u), at_corners);
  }
  if (!options.bisection_only) {
    remove_knots_in_parallel(fit, corners);
    remove_knots(fit, corners);
  }

  CurveFit result;
  result.curve = HermiteCurve(fit.mesh, fit.dofs);
  for (const FitPoint& p : fit.points) result.parameters.push_back(p.t);
  result.deviation = deviation_of(result.curve, row, result.parameters);
  return result;
}

CurveFit fit_points(const std::string& name, const std::vector<Vec3>& points,
                    const FitOptions& options) {
  const PointSequence row(name, points, options.corner_angle, options.corners, options.closed);
  CurveFit fit = fit_point_sequence(name, row, options);
  if (options.bisection_only && fit.deviation.max > options.tolerance)
    throw InputError(
        "curve '" + name + "' cannot be fitted within the tolerance " +
        format_number(options.tolerance) + ": with bisected segments the deviation is " +
        format_number(fit.deviation.max) + "; add a corner, or increase the tolerance");
  std::vector<double> all;
  for (const int i : row.index) all.push_back(fit.parameters[i]);
  fit.parameters = std::move(all);
  return fit;
}

// Fits of input curves: exact if they are piecewise cubic, otherwise by samples.

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

// Largest distance of the input from the fitted curve, between the fitted samples.
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

// Derivatives with respect to t on either side of each break of a piecewise cubic curve.
struct BreakSlopes {
  std::vector<Vec3> before, after;
  double chords = 0;  // sum of the distances between breaks

  BreakSlopes(const InputCurve& curve, const std::vector<double>& t)
      : before(t.size()), after(t.size()) {
    const size_t n = t.size();
    for (size_t i = 0; i + 1 < n; ++i) after[i] = curve.evaluate(t[i], 1);
    for (size_t i = 1; i < n; ++i) {
      // The end derivative of a cubic piece follows from three of its points and its start
      // derivative.
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

// The curve over a mesh whose segment i is scale[i] times as long as piece i of the input.
HermiteCurve scaled_pieces(const InputCurve& curve, const std::vector<double>& t,
                           const BreakSlopes& slopes, const CurveMesh& mesh,
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
  const BreakSlopes slopes(curve, t);
  const auto &before = slopes.before, &after = slopes.after;
  // If the direction is continuous, the parameter of the next segment is scaled so that the speed
  // is continuous too.
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
  // Scales all of it so that u ranges over the length of the curve.
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
  // Corners are samples; the others are distributed between them.
  std::vector<double> ends = {0};
  const std::vector<double> breaks = curve->breaks();
  for (size_t i = 1; i + 1 < breaks.size(); ++i)
    if (degrees_at(*curve, breaks[i]) > options.corner_angle)
      ends.push_back(arc.length_at(breaks[i]));
  ends.push_back(total);
  const bool seam = closed && seam_degrees(*curve) > options.corner_angle;

  FitOptions half = options;
  half.tolerance = 0.5 * options.tolerance;  // the rest is for deviations between the samples
  constexpr int most_samples = 1 << 14;
  for (int per_line = 64 + 8 * isize(breaks);; per_line *= 2) {
    std::vector<double> s;
    std::vector<int> corners;
    if (seam) corners.push_back(0);
    for (size_t k = 0; k + 1 < ends.size(); ++k) {
      const double part = ends[k + 1] - ends[k];
      const int n = std::max(8, static_cast<int>(per_line * part / total));
      if (k > 0) corners.push_back(isize(s));
      // Half of them are even by length, half by the input's own parameter, which often runs slowly
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
    constexpr double sure = 0.9;  // a maximum may lie between the checked points
    if (off <= sure * options.tolerance) return fit.curve;
    if (2 * per_line > most_samples)
      throw InputError("curve '" + name + "' cannot be fitted within the tolerance " +
                       format_number(options.tolerance) + ": the deviation is " +
                       format_number(off) + "; add a corner, or increase the tolerance");
  }
}

}  // namespace batten
