#include "batten/fairing/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fairing/curve_band.h"
#include "batten/fairing/point_row.h"

namespace batten {
namespace {

// What a node may not change: its position, a slope.
struct Held {
  double u;
  std::optional<Vec3> position, slope_in, slope_out;
  bool removable = false;  // with its node
};

// The least-squares problem on one mesh: the points, their parameters, what is held.
class Fit {
 public:
  std::vector<Vec3> points;
  std::vector<double> t;     // ascending; outside of the mesh: only seen as ends of gaps
  std::vector<char> kept;    // t stays: corners, ends
  std::vector<double> bend;  // curvature of the circle around each gap, for beyond_chord()
  std::vector<Held> held;    // ascending
  bool closed = false, even = false, whole_loop = false;
  double tolerance = 0;

  CurveMesh mesh;
  Points dofs;  // empty before the first solve

  // What the last improve() reached, for each segment.
  std::vector<double> off;
  double worst() const { return *std::max_element(off.begin(), off.end()); }
  bool done() const { return worst() <= tolerance; }

  int count() const { return static_cast<int>(points.size()); }
  double period() const { return mesh.end() - mesh.start(); }

  void set_mesh(std::vector<double> knots, const std::vector<int>& corners) {
    mesh = CurveMesh(std::move(knots), closed, corners);
    dofs.resize(0, 3);
  }

  // Solves and moves the parameters to the nearest points, until all is within the tolerance or
  // nothing improves; the best state stays.
  void improve(int most_rounds) {
    double best = std::numeric_limits<double>::infinity();
    Points best_dofs;
    std::vector<double> best_t, best_off;
    int stalled = 0;
    for (int round = 0; round < most_rounds && stalled < 2; ++round) {
      constexpr int settling = 4;
      if (round < settling) dofs.resize(0, 3);
      solve();
      measure();
      const double now = worst();
      if (now <= tolerance) return;
      // Moving parameters gains a factor or two a round: no round for what is farther off.
      if (now > 8 * tolerance || now * std::pow(now / best, most_rounds - 1 - round) > tolerance)
        stalled = 2;
      constexpr double noticeable = 0.97;
      stalled = now > noticeable * best ? stalled + 1 : 0;
      if (now < best) {
        best = now;
        best_dofs = dofs;
        best_t = t;
        best_off = off;
      }
    }
    dofs = best_dofs;
    t = best_t;
    off = best_off;
  }

  // Index of the first point of each segment, and the count behind the last.
  std::vector<int> first_points() const {
    std::vector<int> first;
    for (const double u : mesh.parameters())
      first.push_back(static_cast<int>(std::lower_bound(t.begin(), t.end(), u) - t.begin()));
    first.back() = static_cast<int>(std::upper_bound(t.begin(), t.end(), mesh.end()) - t.begin());
    return first;
  }

 private:
  bool outside(int i) const { return t[i] < mesh.start() || t[i] > mesh.end(); }

  void solve() {
    const CurveBand band(mesh);
    band.reset(A_);
    right_.setZero(mesh.dof_count(), 3);
    const std::vector<int> first = first_points();
    for (int s = 0; s < mesh.segment_count(); ++s) {
      const HermiteSegment segment(mesh.length(s));
      const double h = mesh.length(s);
      const auto dof = mesh.segment_dofs(s);
      // A little bending holds what the points leave free; later that of the change only, so that
      // it pulls the result nowhere.
      constexpr double little = 1e-8;
      HermiteSegment::Matrix K =
          segment.bending(little * std::max(first[s + 1] - first[s], 1) * h * h * h);
      Eigen::Matrix<double, 4, 3> b = Eigen::Matrix<double, 4, 3>::Zero();
      if (dofs.rows() > 0) {
        Eigen::Matrix<double, 4, 3> q;
        for (int a = 0; a < 4; ++a) q.row(a) = dofs.row(dof[a]);
        b = K * q;
      }
      for (int i = first[s]; i < first[s + 1]; ++i) {
        const double x = (t[i] - mesh.parameters()[s]) / h, y = 1 - x;
        const HermiteSegment::Vector H(y * y * (1 + 2 * x), h * x * y * y, x * x * (1 + 2 * y),
                                       -h * x * x * y);
        K.noalias() += H * H.transpose();
        b.noalias() += H * points[i].transpose();
      }
      band.add(A_, s, K);
      for (int a = 0; a < 4; ++a) right_.row(band.place(dof[a])) += b.row(a);
    }
    auto it = held.begin();
    for (int node = 0; node < mesh.node_count() && it != held.end(); ++node) {
      if (mesh.parameters()[node] != it->u) continue;
      if (it->position) A_.fix(band.place(mesh.position_dof(node)), *it->position, right_);
      if (it->slope_in) A_.fix(band.place(mesh.slope_in(node)), *it->slope_in, right_);
      if (it->slope_out && mesh.slope_out(node) != mesh.slope_in(node))
        A_.fix(band.place(mesh.slope_out(node)), *it->slope_out, right_);
      ++it;
    }
    if (!A_.factorize()) throw NoSolutionError("the fit of a curve is singular");
    A_.solve(right_);
    dofs.resize(mesh.dof_count(), 3);
    for (int d = 0; d < mesh.dof_count(); ++d) dofs.row(d) = right_.row(band.place(d));
  }

  // One step of Newton's method towards the nearest point, in order; then the distances.
  void measure() {
    const auto& u = mesh.parameters();
    const int segments = mesh.segment_count();
    off.assign(segments, 0.0);
    cubics_.resize(segments);
    for (int s = 0; s < segments; ++s) cubics_[s] = cubic(s);
    int s = 0;
    for (int i = 0; i < count(); ++i) {
      if (kept[i] || even || outside(i)) continue;
      while (s + 1 < segments && t[i] >= u[s + 1]) ++s;
      const double h = mesh.length(s);
      const Jet at = cubics_[s]((t[i] - u[s]) / h);
      const Vec3 d = at.x - points[i];
      const double slope = at.d1.squaredNorm() + std::max(0.0, d.dot(at.d2));
      const double low = i > 0 ? std::max(t[i - 1], u.front()) : u.front(),
                   high = i + 1 < count() ? std::min(t[i + 1], u.back()) : u.back();
      if (slope > 0)
        t[i] = std::clamp(t[i] - h * d.dot(at.d1) / slope, 0.5 * (low + t[i]), 0.5 * (high + t[i]));
    }
    s = 0;
    bool near_before = false;
    for (int i = 0; i < count(); ++i) {
      while (s + 1 < segments && t[i] >= u[s + 1]) ++s;
      double distance = 0;
      if (!outside(i)) {
        distance = (cubics_[s].position((t[i] - u[s]) / mesh.length(s)) - points[i]).norm();
        off[s] = std::max(off[s], distance);
        if (t[i] == u[s] && s > 0) off[s - 1] = std::max(off[s - 1], distance);
      }
      const bool near = distance <= tolerance;
      if (i > 0 && near && near_before) measure_gap(i - 1, i, t[i - 1], t[i]);
      near_before = near;
    }
    if (whole_loop) {
      measure_gap(count() - 1, 0, t.back(), t.front() + period());
      measure_gap(count() - 1, 0, t.back() - period(), t.front());
    }
  }

  // Between two points that are near enough the curve must not bulge.
  void measure_gap(int i, int j, double from, double to) {
    const auto& u = mesh.parameters();
    for (const double part : {0.3, 0.7}) {  // a bulge to one side shows there, and one to both
      const double between = from + part * (to - from);
      if (between < u.front() || between > u.back()) continue;
      const int at = mesh.where(between).segment;
      const Vec3 x = cubics_[at].position((between - u[at]) / mesh.length(at));
      if ((x - points[i] - part * (points[j] - points[i])).squaredNorm() > tolerance * tolerance)
        off[at] =
            std::max(off[at], beyond_chord(x, points[i], points[j], std::max(bend[i], bend[j])));
    }
  }

  // A segment over s in [0, 1]: x = c0 + s (c1 + s (c2 + s c3)).
  struct Jet {
    Vec3 x, d1, d2;
  };
  struct Cubic {
    Vec3 c0, c1, c2, c3;
    Vec3 position(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
    Jet operator()(double s) const {
      return {position(s), c1 + s * (2 * c2 + 3 * s * c3), 2 * c2 + 6 * s * c3};
    }
  };
  Cubic cubic(int segment) const {
    const auto d = mesh.segment_dofs(segment);
    const double h = mesh.length(segment);
    const Vec3 a = dofs.row(d[0]), b = dofs.row(d[2]), p = h * dofs.row(d[1]),
               q = h * dofs.row(d[3]);
    return {a, p, 3 * (b - a) - 2 * p - q, 2 * (a - b) + p + q};
  }
  std::vector<Cubic> cubics_;

  BandCholesky A_;
  Points right_;
};

// Parameters of nodes are rounded to this fraction of the whole: the same line in mm and in m is
// then cut in the same places, and a mesh can have a vertex exactly there.
double on_grid(double u, double whole) {
  constexpr double grid = 1 << 30;
  return std::round(u / whole * grid) / grid * whole;
}

// Where to put a node into segment s: at the point that halves the squared distances; or half way.
std::optional<double> split_of(const Fit& fit, int s, const std::vector<int>& first, bool halve) {
  const double a = fit.mesh.parameters()[s], b = fit.mesh.parameters()[s + 1];
  if (halve) return 0.5 * (a + b);
  std::vector<int> inside;
  for (int i = first[s]; i < first[s + 1]; ++i)
    if (fit.t[i] > a + 1e-3 * (b - a) && fit.t[i] < b - 1e-3 * (b - a)) inside.push_back(i);
  if (inside.empty()) return std::nullopt;
  const HermiteCurve curve(fit.mesh, fit.dofs);
  std::vector<double> sum = {0};
  for (const int i : inside)
    sum.push_back(sum.back() + (curve.evaluate(fit.t[i]) - fit.points[i]).squaredNorm() + 1e-300);
  const auto half =
      std::lower_bound(sum.begin() + 1, sum.end(), 0.5 * sum.back()) - sum.begin() - 1;
  // Not so near to an end that the rest has nothing to fit.
  const auto n = static_cast<long>(inside.size());
  return fit.t[inside[std::clamp<long>(half, n / 4, n - 1 - n / 4)]];
}

std::vector<int> corner_nodes(const std::vector<double>& knots,
                              const std::vector<double>& corners) {
  std::vector<int> nodes;
  for (size_t i = 0; i < knots.size(); ++i)
    if (std::find(corners.begin(), corners.end(), knots[i]) != corners.end())
      nodes.push_back(static_cast<int>(i));
  return nodes;
}

// A part of a fit between two nodes, which keep position and slope.
Fit window_of(const Fit& fit, int a, int b, std::vector<double> knots,
              const std::vector<double>& corners) {
  Fit part;
  part.tolerance = fit.tolerance;
  part.even = fit.even;
  const double from = knots.front(), to = knots.back();
  // With the points before and behind: the gaps to them count too.
  const auto i =
      std::max<long>(std::lower_bound(fit.t.begin(), fit.t.end(), from) - fit.t.begin() - 1, 0);
  const auto j = std::min<long>(
      std::upper_bound(fit.t.begin(), fit.t.end(), to) - fit.t.begin() + 1, fit.count());
  part.points.assign(fit.points.begin() + i, fit.points.begin() + j);
  part.t.assign(fit.t.begin() + i, fit.t.begin() + j);
  part.kept.assign(fit.kept.begin() + i, fit.kept.begin() + j);
  part.bend.assign(fit.bend.begin() + i, fit.bend.begin() + j);
  if (fit.closed) {
    const auto beyond = [&](int point, double at, bool in_front) {
      part.points.insert(in_front ? part.points.begin() : part.points.end(), fit.points[point]);
      part.t.insert(in_front ? part.t.begin() : part.t.end(), at);
      part.kept.insert(in_front ? part.kept.begin() : part.kept.end(), 0);
      part.bend.insert(in_front ? part.bend.begin() : part.bend.end(), fit.bend[point]);
    };
    if (a == 0) beyond(fit.count() - 1, fit.t.back() - fit.period(), true);
    if (b == fit.mesh.segment_count()) beyond(0, fit.t.front() + fit.period(), false);
  }
  const auto row = [&](int d) { return Vec3(fit.dofs.row(d).transpose()); };
  const int end = b % fit.mesh.node_count();
  for (const Held& h : fit.held)
    if (h.u > from && h.u < to) part.held.push_back(h);
  part.held.insert(part.held.begin(), {from, row(fit.mesh.position_dof(a)),
                                       row(fit.mesh.slope_out(a)), row(fit.mesh.slope_out(a))});
  part.held.push_back({to, row(fit.mesh.position_dof(end)), row(fit.mesh.slope_in(end)),
                       row(fit.mesh.slope_in(end))});
  std::vector<int> nodes = corner_nodes(knots, corners);
  std::erase_if(nodes, [&](int n) { return n == 0 || n + 1 == static_cast<int>(knots.size()); });
  part.set_mesh(std::move(knots), nodes);
  return part;
}

// A node at every point, parameters by chord length: the spline of least bending through all
// points. False when that was done before.
bool interpolate(Fit& fit, const PointRow& row, const std::vector<double>& corners) {
  if (std::all_of(fit.kept.begin(), fit.kept.end(), [](char k) { return k; })) return false;
  fit.t.assign(row.chord.begin(), row.chord.begin() + row.count());
  std::vector<Held> held;
  auto users = fit.held.begin();
  for (int i = 0; i < row.count(); ++i) {
    const bool is_users = users != fit.held.end() && users->u == fit.t[i];
    held.push_back(is_users ? *users++ : Held{fit.t[i], fit.points[i], {}, {}, true});
  }
  fit.held = std::move(held);
  fit.kept.assign(row.count(), 1);
  std::vector<double> knots = row.chord;
  const std::vector<int> at_corners = corner_nodes(knots, corners);
  fit.set_mesh(std::move(knots), at_corners);
  return true;
}

// Where the spline through all points still swings out: there the slopes are held too, to the mean
// direction of the chords beside and not faster than the parameter, which bounds every bulge by a
// third of its chord. False when that was done before.
bool calm(Fit& fit, const PointRow& row) {
  const int n = row.count(), nodes = fit.mesh.node_count();
  bool changed = false;
  for (int s = 0; s < fit.mesh.segment_count(); ++s) {
    if (fit.off[s] <= fit.tolerance) continue;
    for (const int node : {s, (s + 1) % nodes}) {
      Held& held = fit.held[node];  // there is one for each point, and so for each node
      if (held.slope_in || held.slope_out || fit.mesh.is_corner(node)) continue;
      if (!fit.closed && (node == 0 || node == n - 1)) continue;
      const Vec3 before = row.points[node] - row.points[(node + n - 1) % n],
                 after = row.points[(node + 1) % n] - row.points[node];
      held.slope_in = held.slope_out =
          (after.norm() * before.normalized() + before.norm() * after.normalized()) /
          (before.norm() + after.norm());
      changed = true;
    }
  }
  return changed;
}

// Takes nodes out where their neighbourhood can be fitted without them: a window of segments is
// solved again, everything outside stays.
void prune(Fit& fit, const std::vector<double>& corners) {
  constexpr int reach = 2, rounds = 5;
  const auto movable = [&](double u) {
    return std::none_of(fit.held.begin(), fit.held.end(),
                        [&](const Held& h) { return h.u == u && !h.removable; });
  };
  const auto attempt = [&](int node, int removed, bool put_one) {
    const auto& u = fit.mesh.parameters();
    const int a = std::max(0, node - reach),
              b = std::min(fit.mesh.segment_count(), node + removed - 1 + reach);
    if (fit.closed && b - a == fit.mesh.segment_count() && fit.mesh.segment_count() <= 3)
      return false;
    std::vector<double> knots(u.begin() + a, u.begin() + b + 1);
    const auto at = knots.begin() + (node - a);
    const double middle = on_grid(0.5 * (*at + *(at + removed - 1)), u.back());
    const auto behind = knots.erase(at, at + removed);
    if (put_one) knots.insert(behind, middle);
    Fit part = window_of(fit, a, b, knots, corners);
    const auto gone = [&](double at_u) {
      return std::find(u.begin() + node, u.begin() + node + removed, at_u) !=
             u.begin() + node + removed;
    };
    std::erase_if(part.held, [&](const Held& h) { return gone(h.u); });
    for (int i = 0; i < part.count(); ++i)
      if (gone(part.t[i])) part.kept[i] = 0;
    part.improve(rounds);
    if (!part.done()) return false;
    std::erase_if(fit.held, [&](const Held& h) { return gone(h.u); });
    // Put it back.
    std::vector<double> all(u.begin(), u.begin() + a);
    all.insert(all.end(), knots.begin(), knots.end());
    all.insert(all.end(), u.begin() + b + 1, u.end());
    const auto first = std::max<long>(
        std::lower_bound(fit.t.begin(), fit.t.end(), knots.front()) - fit.t.begin() - 1, 0);
    const int in_front = fit.closed && a == 0,
              behind_seam = fit.closed && b + 1 == static_cast<int>(u.size());
    std::copy(part.t.begin() + in_front, part.t.end() - behind_seam, fit.t.begin() + first);
    std::copy(part.kept.begin() + in_front, part.kept.end() - behind_seam,
              fit.kept.begin() + first);
    const CurveMesh old = fit.mesh;
    const Points before = fit.dofs;
    fit.set_mesh(all, corner_nodes(all, corners));
    fit.dofs.resize(fit.mesh.dof_count(), 3);
    const int change = fit.mesh.node_count() - old.node_count();
    for (int n = 0; n < fit.mesh.node_count(); ++n) {
      const int last = a + static_cast<int>(knots.size()) - 1;
      const bool inside = n > a && n < last;
      const int from = n <= a ? n : n - change;
      const CurveMesh& m = inside ? part.mesh : old;
      const Points& q = inside ? part.dofs : before;
      const int k = inside ? n - a : from;
      fit.dofs.row(fit.mesh.position_dof(n)) = q.row(m.position_dof(k));
      fit.dofs.row(fit.mesh.slope_in(n)) = q.row(m.slope_in(k));
      fit.dofs.row(fit.mesh.slope_out(n)) = q.row(m.slope_out(k));
    }
    return true;
  };
  for (int node = 1; node < fit.mesh.segment_count(); ++node) {
    const auto& u = fit.mesh.parameters();
    if (!movable(u[node])) continue;
    // Alone, or together with the next one for one between them. Then those before it anew.
    if (attempt(node, 1, false) ||
        (node + 1 < fit.mesh.segment_count() && movable(u[node + 1]) && attempt(node, 2, true)))
      node = std::max(0, node - reach);
  }
}

}  // namespace

CurveFit fit_row(const std::string& name, PointRow row, const FitOptions& options) {
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    throw InputError("line '" + name + "': found the tolerance " + number(options.tolerance) +
                     ", expected a length above 0");
  const double least = 4e-15 * (row.points[0].cwiseAbs().maxCoeff() + row.size);
  for (double& u : row.chord) u = on_grid(u, row.length());
  Fit fit;
  fit.tolerance = std::max(options.tolerance, least);
  fit.closed = fit.whole_loop = row.closed;
  fit.even = options.even;
  fit.points = row.points;
  fit.t.assign(row.chord.begin(), row.chord.begin() + row.count());
  fit.kept.assign(row.count(), 0);
  fit.bend.assign(row.count(), 0);
  const int n = row.count();
  for (int i = row.closed ? 0 : 1; i < (row.closed ? n : n - 1); ++i)
    fit.bend[i] =
        circle_curvature(row.points[(i + n - 1) % n], row.points[i], row.points[(i + 1) % n]);
  // of gap i - 1, i: the larger of both; the ends of an open row have none
  std::vector<double> corners, knots = {0};
  for (const int c : row.corners) {
    corners.push_back(row.chord[c]);
    if (c > 0) knots.push_back(row.chord[c]);
    fit.held.push_back({row.chord[c], row.points[c], {}, {}});
    fit.kept[c] = 1;
  }
  knots.push_back(row.length());
  if (!row.closed) {
    std::optional<Vec3> start, end;
    if (options.start) {
      fit.points.front() = options.start->position;
      start = options.start->tangent;
    }
    if (options.end) {
      fit.points.back() = options.end->position;
      end = options.end->tangent;
    }
    fit.held.insert(fit.held.begin(), {0, fit.points.front(), start, start});
    fit.held.push_back({row.length(), fit.points.back(), end, end});
    fit.kept.front() = fit.kept.back() = 1;
  } else if (knots.size() < 5) {
    // A closed curve begins with four segments at least.
    for (size_t i = 0; knots.size() < 5; i += 2) {
      if (i + 1 >= knots.size()) i = 0;
      knots.insert(knots.begin() + static_cast<long>(i) + 1, 0.5 * (knots[i] + knots[i + 1]));
    }
    std::sort(knots.begin(), knots.end());
  }
  fit.set_mesh(knots, corner_nodes(knots, corners));

  constexpr int rounds = 10;
  while (true) {
    fit.improve(rounds);
    if (fit.done()) break;
    const std::vector<int> first = fit.first_points();
    std::vector<double> u = fit.mesh.parameters();
    bool split = false;
    for (int s = 0; s < fit.mesh.segment_count(); ++s) {
      if (fit.off[s] <= fit.tolerance) continue;
      if (const auto at = split_of(fit, s, first, options.halved)) {
        u.push_back(on_grid(*at, row.length()));
        split = true;
      }
    }
    if (!split || fit.held.size() == fit.points.size()) {
      // What fails has no point left to part it: the curve goes through its points.
      if (!interpolate(fit, row, corners) && !calm(fit, row)) break;
      continue;
    }
    std::sort(u.begin(), u.end());
    u.erase(std::unique(u.begin(), u.end()), u.end());
    if (static_cast<int>(u.size()) - 1 > options.most_segments)
      throw InputError("line '" + name + "' is not within " + number(options.tolerance) +
                       " of a smooth curve of " + std::to_string(options.most_segments) +
                       " segments (off by " + number(fit.worst()) +
                       "): is there a corner, or is the tolerance too small?");
    std::vector<int> at_corners = corner_nodes(u, corners);
    fit.set_mesh(std::move(u), at_corners);
  }
  if (!options.halved) prune(fit, corners);

  CurveFit result;
  result.curve = HermiteCurve(fit.mesh, fit.dofs);
  result.parameters = fit.t;
  result.deviation = deviation_of(result.curve, row, fit.t);
  return result;
}

CurveFit fit_points(const std::string& name, const std::vector<Vec3>& points,
                    const FitOptions& options) {
  const PointRow row(name, points, options.corner_angle, options.corners, options.closed);
  CurveFit fit = fit_row(name, row, options);
  std::vector<double> all;
  for (const int i : row.index) all.push_back(fit.parameters[i]);
  fit.parameters = std::move(all);
  return fit;
}

}  // namespace batten
