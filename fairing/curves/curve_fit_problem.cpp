// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/curve_fit_problem.h"

#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/curve_dof_ordering.h"

namespace batten {

void CurveFitProblem::set_mesh(std::vector<double> knots, const std::vector<int>& corners) {
  mesh = CurveMesh(std::move(knots), closed, corners);
  dofs.resize(0, 3);
}

int CurveFitProblem::first_from(double u) const {
  const auto before = [](const FitPoint& p, double at) { return p.t < at; };
  return static_cast<int>(std::lower_bound(points.begin(), points.end(), u, before) -
                          points.begin());
}

int CurveFitProblem::first_behind(double u) const {
  const auto before = [](double at, const FitPoint& p) { return at < p.t; };
  return static_cast<int>(std::upper_bound(points.begin(), points.end(), u, before) -
                          points.begin());
}

std::vector<int> CurveFitProblem::first_points() const {
  std::vector<int> first;
  for (const double u : mesh.parameters()) first.push_back(first_from(u));
  first.back() = first_behind(mesh.end());
  return first;
}

void CurveFitProblem::iterate(int max_rounds) {
  constexpr int kStartupRounds = 4;
  constexpr double noticeable = 0.99, too_far = 15;
  double best = std::numeric_limits<double>::infinity();
  Points best_dofs;
  std::vector<double> best_t, best_errors;
  for (const FitPoint& p : points) best_t.push_back(p.t);
  int stalled = 0;
  for (int round = 0; round < max_rounds && stalled < 2; ++round) {
    if (round < kStartupRounds) dofs.resize(0, 3);
    if (round > 0) extrapolate_parameters();
    solve();
    make_cubics();
    move_parameters();
    measure();
    const double now = worst();
    if (now <= tolerance) return;
    // A round gains about a factor of two, later rounds less. Foot points on a curve that is far
    // away are useless for the next mesh: the parameters then stay.
    const bool far = now > too_far * tolerance,
               is_diverging = far || now * std::pow(now / best, max_rounds - 1 - round) > tolerance;
    stalled = now > noticeable * best ? stalled + 1 : 0;
    if (now < best) {
      best = now;
      best_dofs = dofs;
      best_errors = segment_errors;
      for (size_t i = 0; i < points.size() && !far; ++i) best_t[i] = points[i].t;
    }
    if (is_diverging) break;
  }
  dofs = best_dofs;
  segment_errors = best_errors;
  for (size_t i = 0; i < points.size(); ++i) points[i].t = best_t[i];
}

void CurveFitProblem::solve() {
  const CurveDofOrdering band(mesh);
  band.reset(A_);
  rhs_.setZero(mesh.dof_count(), 3);
  const std::vector<int> first = first_points();
  for (int s = 0; s < mesh.segment_count(); ++s) {
    const double h = mesh.length(s);
    const auto dof = mesh.segment_dofs(s);
    // A little bending regularises what the points leave free. In later rounds it acts on the
    // change only, so that it does not bias the result. It is HermiteSegment::bending(k h³),
    // specialised.
    constexpr double little = 1e-8;
    const double k = little * std::max(first[s + 1] - first[s], 1), kh = k * h, khh = kh * h;
    HermiteSegment::Matrix K;
    K << 12 * k, 6 * kh, -12 * k, 6 * kh,   //
        6 * kh, 4 * khh, -6 * kh, 2 * khh,  //
        -12 * k, -6 * kh, 12 * k, -6 * kh,  //
        6 * kh, 2 * khh, -6 * kh, 4 * khh;
    Eigen::Matrix<double, 4, 3> b = Eigen::Matrix<double, 4, 3>::Zero();
    if (dofs.rows() > 0) {
      Eigen::Matrix<double, 4, 3> q;
      for (int a = 0; a < 4; ++a) q.row(a) = dofs.row(dof[a]);
      b = K * q;
    }
    for (int i = first[s]; i < first[s + 1]; ++i) {
      const double x = local_parameter(points[i].t, s), y = 1 - x;
      const HermiteSegment::Vector H(y * y * (1 + 2 * x), h * x * y * y, x * x * (1 + 2 * y),
                                     -h * x * x * y);
      K.noalias() += H * H.transpose();
      b.noalias() += H * points[i].x.transpose();
    }
    band.add(A_, s, K);
    for (int a = 0; a < 4; ++a) rhs_.row(band.banded_index(dof[a])) += b.row(a);
  }
  auto it = node_constraints.begin();
  for (int node = 0; node < mesh.node_count() && it != node_constraints.end(); ++node) {
    if (mesh.parameters()[node] != it->u) continue;
    if (it->position) A_.fix(band.banded_index(mesh.position_dof(node)), *it->position, rhs_);
    if (it->slope_in) A_.fix(band.banded_index(mesh.slope_in(node)), *it->slope_in, rhs_);
    if (it->slope_out && mesh.slope_out(node) != mesh.slope_in(node))
      A_.fix(band.banded_index(mesh.slope_out(node)), *it->slope_out, rhs_);
    ++it;
  }
  if (!A_.factorize())
    throw NoSolutionError("a curve cannot be fitted: its system of equations is singular");
  A_.solve(rhs_);
  dofs.resize(mesh.dof_count(), 3);
  for (int d = 0; d < mesh.dof_count(); ++d) dofs.row(d) = rhs_.row(band.banded_index(d));
}

void CurveFitProblem::make_cubics() {
  cubics_.resize(mesh.segment_count());
  for (int s = 0; s < mesh.segment_count(); ++s) {
    const auto d = mesh.segment_dofs(s);
    const double h = mesh.length(s);
    cubics_[s] = PowerCubic<Vec3>::of_hermite(dof(d[0]), h * dof(d[1]), dof(d[2]), h * dof(d[3]));
  }
}

// One Newton step towards the foot point for each parameter, in order.
void CurveFitProblem::move_parameters() {
  moves_.assign(points.size(), 0.0);
  if (fixed_parameters) return;
  const int segments = mesh.segment_count();
  int s = 0;
  for (int i = 0; i < count(); ++i) {
    FitPoint& p = points[i];
    if (p.fixed_parameter || p.t < mesh.start() || p.t > mesh.end()) continue;
    while (s + 1 < segments && p.t >= mesh.parameters()[s + 1]) ++s;
    const double at = local_parameter(p.t, s);
    const Vec3 d = cubics_[s].at(at) - p.x, d1 = cubics_[s].slope(at);
    const double slope = d1.squaredNorm() + std::max(0.0, d.dot(cubics_[s].second(at)));
    if (slope > 0) moves_[i] = move(i, -mesh.length(s) * d.dot(d1) / slope);
  }
}

// Extrapolation: the next solve will move the curve on in the same direction.
void CurveFitProblem::extrapolate_parameters() {
  constexpr double part = 0.6;
  for (int i = 0; i < count(); ++i)
    if (moves_[i] != 0) move(i, part * moves_[i]);
}

// Moves a parameter by at most half the distance to its neighbour or to the end. Returns the
// change.
double CurveFitProblem::move(int i, double change) {
  // Points keep this fraction of their distance in u, so that the speed stays bounded.
  constexpr double least_gap = 0.4;
  FitPoint& p = points[i];
  const FitPoint *before = i > 0 ? &p - 1 : nullptr, *after = i + 1 < count() ? &p + 1 : nullptr;
  const double from = before ? std::max(before->t, mesh.start()) : mesh.start(),
               to = after ? std::min(after->t, mesh.end()) : mesh.end();
  double least = 0.5 * (from + p.t), most = 0.5 * (to + p.t);
  if (before) least = std::min(std::max(least, before->t + least_gap * p.gap), p.t);
  if (after) most = std::max(std::min(most, after->t - least_gap * after->gap), p.t);
  const double old = p.t;
  p.t = std::clamp(old + change, least, most);
  return p.t - old;
}

void CurveFitProblem::measure() {
  const int segments = mesh.segment_count();
  segment_errors.assign(segments, 0.0);
  int s = 0;
  bool near_before = false;
  for (int i = 0; i < count(); ++i) {
    const FitPoint& p = points[i];
    while (s + 1 < segments && p.t >= mesh.parameters()[s + 1]) ++s;
    double distance = 0;
    if (p.t >= mesh.start() && p.t <= mesh.end()) {
      distance = (cubics_[s].at(local_parameter(p.t, s)) - p.x).norm();
      segment_errors[s] = std::max(segment_errors[s], distance);
      if (s > 0 && p.t == mesh.parameters()[s])
        segment_errors[s - 1] = std::max(segment_errors[s - 1], distance);
    }
    // A bulge to one side shows at either sample, an S-shaped one at both. Its peak is searched
    // only when everything else is within the tolerance.
    const bool near = distance <= tolerance;
    if (near && near_before) measure_gap(i, {3, 5}, s);
    near_before = near;
  }
  if (closed) measure_gap(0, {3, 5}, 0);
  if (!done()) return;
  s = 0;
  for (int i = closed ? 0 : 1; i < count(); ++i) s = measure_gap(i, {1, 2, 4, 6, 7}, s);
}

// Checks the gap before point i for bulges between two points that are close enough. `places`:
// sample numbers of kSamplesPerGap. `s`: a segment near the first sample. Returns the segment of
// the last sample.
int CurveFitProblem::measure_gap(int i, std::initializer_list<int> places, int s) {
  const FitPoint &b = points[i], &a = i > 0 ? points[i - 1] : points.back();
  const double limit = tolerance + b.sagitta, from = i > 0 ? a.t : a.t - period();
  for (const int place : places) {
    const double part = static_cast<double>(place) / kSamplesPerGap;
    double u = from + part * (b.t - from);
    if (u < mesh.start() && closed) u += period();
    if (u < mesh.start() || u > mesh.end()) continue;
    while (s > 0 && u < mesh.parameters()[s]) --s;
    while (s + 1 < mesh.segment_count() && u >= mesh.parameters()[s + 1]) ++s;
    const Vec3 x = cubics_[s].at(local_parameter(u, s));
    if ((x - a.x - part * (b.x - a.x)).squaredNorm() > limit * limit)
      segment_errors[s] = std::max(segment_errors[s], chord_excess(x, a.x, b.x, b.sagitta));
  }
  return s;
}

}  // namespace batten
