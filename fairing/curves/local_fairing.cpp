// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/local_fairing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/band_cholesky.h"
#include "batten/elements/quadrature.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/fem/curves/bspline.h"

namespace batten {
namespace {

using Poles3 = Eigen::Matrix<double, 3, 3>;  // a row per pole

double wrapped(const HermiteCurve& curve, double u) {
  const double whole = curve.end() - curve.start();
  return curve.closed() && u > curve.end() ? u - whole : u;
}

/// A node of the faired part.
struct PartNode {
  double u = 0;  ///< parameter on the curve
  double v = 0;  ///< the same, continued beyond the seam
  bool corner = false;
  bool kept = false;  ///< must remain a node: border, corner, seam
};

/// The faired part of a curve as cubic splines between corners, which share the poles at the
/// corners.
class PartSpline {
 public:
  PartSpline(const HermiteCurve& curve, const CurvePart& part, double wavelength);

  /// The curve with its part faired; `softness`: c of fair_part().
  HermiteCurve faired(double softness) const;

 private:
  enum class Border { Clamped, Pinned, Periodic };
  /// Weights of ∫ |X^(k)|², k = 0 … 3, relative to X⁰ (k = 0), to Q (1, 2) and to 0 (3).
  using Weights = std::array<double, 4>;

  std::vector<PartNode> coarse_nodes(const CurvePart& part, bool all);
  void place_nodes(const std::vector<PartNode>& coarse);
  void number_poles();
  void fix_borders();
  int banded(int pole) const {
    if (start_ != Border::Periodic) return pole;
    return 2 * pole < poles_ ? 2 * pole : 2 * (poles_ - 1 - pole) + 1;
  }
  /// Calls visit(first pole numbers, basis of order 0 … 3, weight, X⁰) at all quadrature points.
  template <class Visit>
  void integrate(const Visit& visit) const;
  Points minimiser(const Weights& weights, const Points& reference) const;
  Points residual(const Weights& weights, const Points& reference, const Points& poles) const;
  HermiteCurve with_poles(const Points& poles) const;
  double scale(double wavelength, double softness) const;

  HermiteCurve curve_;  // the given curve, with nodes at the borders of the part
  double length_ = 0, speed_ = 1, wavelength_;
  Border start_ = Border::Pinned, end_ = Border::Pinned;
  std::vector<PartNode> nodes_;
  std::vector<SplineAxis> pieces_;
  std::vector<int> first_pole_;  // of each piece
  int poles_ = 0;
  Vec3 origin_ = Vec3::Zero();                     // poles are relative to it, to keep digits
  std::vector<std::pair<int, Vec3>> fixed_poles_;  // relative to origin_
};

// Parameters that differ by less are the same.
double same_parameter(const HermiteCurve& curve) { return 1e-12 * (curve.end() - curve.start()); }

// Moves the borders of a part to the inside, if segments outside would be so short that second
// derivatives lost their digits.
CurvePart with_long_neighbours(const HermiteCurve& curve, const CurvePart& part) {
  constexpr double fraction = 0.02, inside = 5e-4;
  const CurveMesh& mesh = curve.mesh();
  const double whole = mesh.end() - mesh.start(), extent = part.to - part.from;
  const auto moved = [&](double u, double sign) {
    const double turn = u > mesh.end() ? whole : 0;
    const int s = mesh.locate(u - turn).segment;
    const double a = mesh.parameters()[s] + turn, b = mesh.parameters()[s + 1] + turn;
    for (const double node : {a, b})
      if (std::abs(u - node) <= same_parameter(curve)) return node;
    const double least = std::min(fraction * (b - a), inside * extent);
    return sign > 0 ? std::max(u, a + least) : std::min(u, b - least);
  };
  return {moved(part.from, 1), moved(part.to, -1)};
}

PartSpline::PartSpline(const HermiteCurve& curve, const CurvePart& given, double wavelength)
    : wavelength_(wavelength) {
  const double whole = curve.end() - curve.start();
  const bool all = curve.closed() && given.to - given.from >= whole - same_parameter(curve);
  const CurvePart part = all ? given : with_long_neighbours(curve, given);
  curve_ = all ? curve : curve.with_nodes({part.from, wrapped(curve, part.to)});
  length_ = part_length(curve, part);
  speed_ = length_ / (part.to - part.from);
  place_nodes(coarse_nodes(part, all));
  number_poles();
  fix_borders();
}

// The nodes of the given curve on the part, and the kinds of both borders.
std::vector<PartNode> PartSpline::coarse_nodes(const CurvePart& part, bool all) {
  const CurveMesh& mesh = curve_.mesh();
  const double whole = mesh.end() - mesh.start();
  const int n = mesh.segment_count();
  int first = mesh.locate(part.from).segment;
  int count = 0;
  if (all) {
    // Starts at a corner, if there is one.
    first = mesh.corners().empty() ? 0 : mesh.corners().front();
    count = n;
  } else {
    double covered = 0;
    while (count < n && covered < part.to - part.from - same_parameter(curve_))
      covered += mesh.length((first + count++) % n);
  }
  const auto border = [&](int node) {
    const bool open_end = !curve_.closed() && (node == 0 || node == n);
    if (open_end || mesh.is_corner(node % mesh.node_count())) return Border::Pinned;
    return all ? Border::Periodic : Border::Clamped;
  };
  start_ = border(first);
  end_ = border(first + count > n ? first + count - n : first + count);
  std::vector<PartNode> nodes;
  for (int k = 0; k <= count; ++k) {
    const bool beyond = curve_.closed() && first + k >= n;
    const int node = beyond ? first + k - n : first + k;
    const double u = mesh.parameters()[node];
    const bool corner = k > 0 && k < count && mesh.is_corner(node % mesh.node_count());
    const bool seam = curve_.closed() && node == 0;
    nodes.push_back({u, beyond ? u + whole : u, corner, corner || seam || k == 0 || k == count});
  }
  return nodes;
}

// Nodes dense enough for the shortest wave that remains and for the part. Nodes of the given curve
// remain, unless they are close to their neighbours: third derivatives would lose digits.
void PartSpline::place_nodes(const std::vector<PartNode>& coarse) {
  constexpr int per_wave = 24, per_part = 72, most = 4000;
  constexpr double close = 0.3;
  const double step =
      std::max(std::min(wavelength_ / per_wave, length_ / per_part), length_ / most) / speed_;
  std::vector<PartNode> sparse;
  for (const PartNode& node : coarse) {
    while (node.kept && sparse.size() > 1 && !sparse.back().kept &&
           node.v - sparse.back().v < close * step)
      sparse.pop_back();
    if (sparse.empty() || node.kept || node.v - sparse.back().v >= close * step)
      sparse.push_back(node);
  }
  for (size_t k = 0; k < sparse.size(); ++k) {
    nodes_.push_back(sparse[k]);
    if (k + 1 == sparse.size()) break;
    const double gap = sparse[k + 1].v - sparse[k].v;
    const int pieces = std::max(1, static_cast<int>(std::ceil(gap / step)));
    for (int i = 1; i < pieces; ++i)
      nodes_.push_back({sparse[k].u + gap * i / pieces, sparse[k].v + gap * i / pieces});
  }
}

void PartSpline::number_poles() {
  std::vector<double> knots;
  for (size_t k = 0; k < nodes_.size(); ++k) {
    knots.push_back(nodes_[k].v);
    if (k == 0 || !(nodes_[k].corner || k + 1 == nodes_.size())) continue;
    first_pole_.push_back(poles_);
    pieces_.emplace_back(knots, start_ == Border::Periodic);
    // Neighbouring pieces share the pole at the corner.
    poles_ += pieces_.back().functions() - (nodes_[k].corner ? 1 : 0);
    knots = {nodes_[k].v};
  }
}

// Poles at which the derivatives of order 0 … 2 at one end of an axis take given values.
Poles3 border_poles(const SplineAxis& axis, bool at_end, const Poles3& derivatives) {
  const int k = at_end ? axis.intervals() - 1 : 0;
  Poles3 A, b = derivatives;
  for (int order = 0; order < 3; ++order) {
    const Eigen::Vector4d B = axis.basis(k, at_end, order);
    A.row(order) = (at_end ? B.tail<3>() : B.head<3>()).transpose();
    b.row(order) *= std::pow(axis.length(k), order);
  }
  return A.inverse() * b;
}

void PartSpline::fix_borders() {
  const CurveMesh& mesh = curve_.mesh();
  const int n = mesh.segment_count();
  const auto node_at = [&](double u) {
    const auto& all = mesh.parameters();
    return static_cast<int>(std::lower_bound(all.begin(), all.end(), u) - all.begin()) %
           mesh.node_count();
  };
  const int first = node_at(nodes_.front().u), last = node_at(nodes_.back().u);
  origin_ = curve_.position(first);
  for (size_t k = 1; k < pieces_.size(); ++k)
    fixed_poles_.emplace_back(
        first_pole_[k],
        curve_.position(node_at(pieces_[k].knots().front() > mesh.end()
                                    ? pieces_[k].knots().front() - (mesh.end() - mesh.start())
                                    : pieces_[k].knots().front())) -
            origin_);
  const auto fix = [&](Border border, bool at_end) {
    const int node = at_end ? last : first;
    const int outermost = at_end ? poles_ - 1 : 0;
    if (border == Border::Pinned)
      fixed_poles_.emplace_back(outermost, curve_.position(node) - origin_);
    if (border != Border::Clamped) return;
    // The second derivative is that of the segment outside.
    const CurveMesh::SegmentPoint outside = at_end
                                                ? CurveMesh::SegmentPoint{node, 0.0}
                                                : CurveMesh::SegmentPoint{(node + n - 1) % n, 1.0};
    Poles3 derivatives;
    derivatives.row(0) = curve_.position(node) - origin_;
    derivatives.row(1) = curve_.slope_out(node);
    derivatives.row(2) = curve_.evaluate(outside, 2);
    const Poles3 poles =
        border_poles(at_end ? pieces_.back() : pieces_.front(), at_end, derivatives);
    for (int i = 0; i < 3; ++i)
      fixed_poles_.emplace_back(at_end ? poles_ - 3 + i : i, poles.row(i).transpose());
  };
  fix(start_, false);
  fix(end_, true);
}

template <class Visit>
void PartSpline::integrate(const Visit& visit) const {
  static const SegmentRule rule = gauss_legendre(4);  // exact for degree 7
  for (size_t p = 0; p < pieces_.size(); ++p) {
    const SplineAxis& axis = pieces_[p];
    for (int k = 0; k < axis.intervals(); ++k) {
      std::array<int, 4> pole;
      for (int i = 0; i < 4; ++i) pole[i] = first_pole_[p] + axis.function(k, i);
      const double h = axis.length(k);
      for (long q = 0; q < rule.s.size(); ++q) {
        Eigen::Matrix4d basis;  // a column per order
        for (int order = 0; order < 4; ++order)
          basis.col(order) = axis.basis(k, rule.s[q], order) / std::pow(h, order);
        const double u = wrapped(curve_, axis.knots()[k] + h * rule.s[q]);
        visit(pole, basis, h * rule.weights[q], Vec3(curve_.evaluate(u) - origin_));
      }
    }
  }
}

// Negative gradient of the energy. The differences of neighbouring poles keep more digits than a
// product with the matrix of the system would.
Points PartSpline::residual(const Weights& weights, const Points& reference,
                            const Points& poles) const {
  Points f = Points::Zero(poles_, 3);
  integrate([&](const std::array<int, 4>& pole, const Eigen::Matrix4d& basis, double weight,
                const Vec3& given) {
    Eigen::Matrix<double, 4, 3> local, away;
    for (int i = 0; i < 4; ++i) {
      local.row(i) = poles.row(pole[i]) - poles.row(pole[0]);
      away.row(i) = poles.row(pole[i]) - reference.row(pole[i]);
    }
    const Vec3 x = poles.row(pole[0]).transpose() + local.transpose() * basis.col(0);
    Eigen::Matrix<double, 4, 3> force =
        weights[0] * basis.col(0) * (given - x).transpose() -
        weights[3] * basis.col(3) * (basis.col(3).transpose() * local);
    for (const int order : {1, 2})
      if (weights[order] > 0)
        force -= weights[order] * basis.col(order) * (basis.col(order).transpose() * away);
    for (int i = 0; i < 4; ++i) f.row(pole[i]) += weight * force.row(i);
  });
  for (const auto& [pole, value] : fixed_poles_) f.row(pole).setZero();
  return f;
}

Points PartSpline::minimiser(const Weights& weights, const Points& reference) const {
  BandCholesky A;
  constexpr int band = 3, folded_band = 7;
  A.reset(poles_, start_ == Border::Periodic ? folded_band : band);
  integrate([&](const std::array<int, 4>& pole, const Eigen::Matrix4d& basis, double weight,
                const Vec3&) {
    Eigen::Matrix4d K = Eigen::Matrix4d::Zero();
    for (int order = 0; order < 4; ++order)
      K += weight * weights[order] * basis.col(order) * basis.col(order).transpose();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j <= i; ++j) A.add(banded(pole[i]), banded(pole[j]), K(i, j));
  });
  Points poles = Points::Zero(poles_, 3), ignored = poles;
  for (const auto& [pole, value] : fixed_poles_) {
    poles.row(pole) = value.transpose();
    A.fix(banded(pole), Vec3::Zero(), ignored);
  }
  if (!A.factorize())
    throw NoSolutionError(
        "a part of a curve cannot be faired: its system is not positive definite");
  // The first step solves the system, the others refine the solution.
  constexpr int steps = 3;
  Points change(poles_, 3);
  for (int step = 0; step < steps; ++step) {
    const Points f = residual(weights, reference, poles);
    for (int i = 0; i < poles_; ++i) change.row(banded(i)) = f.row(i);
    A.solve(change);
    for (int i = 0; i < poles_; ++i) poles.row(i) += change.row(banded(i));
  }
  return poles;
}

// a in units of u, such that a wave of the wavelength keeps half of its height.
double PartSpline::scale(double wavelength, double softness) const {
  double low = 0, high = 1;  // x = aω: 3c x² + 3c x⁴ + x⁶ = 1
  constexpr int halvings = 60;
  for (int i = 0; i < halvings; ++i) {
    const double x2 = 0.25 * (low + high) * (low + high);
    (3 * softness * x2 * (1 + x2) + x2 * x2 * x2 < 1 ? low : high) = 0.5 * (low + high);
  }
  constexpr double longest = 4;  // above this multiple of the length nothing changes
  return high * std::min(wavelength, longest * length_) / (2 * std::numbers::pi * speed_);
}

HermiteCurve PartSpline::with_poles(const Points& poles) const {
  // All nodes of the curve: those outside of the part, and those of the part.
  std::vector<double> added;
  for (const PartNode& node : nodes_) added.push_back(node.u);
  std::sort(added.begin(), added.end());
  const CurveMesh& old = curve_.mesh();
  const double whole = old.end() - old.start();
  const double from = nodes_.front().v, to = nodes_.back().v;
  const auto is_inside = [&](double u) {
    return (u > from && u < to) || (u + whole > from && u + whole < to);
  };
  std::vector<double> u;
  for (const double t : old.parameters())
    if (!is_inside(t) || t == old.start() || t == old.end()) u.push_back(t);
  for (const double t : added)
    if (t > old.start() && t < old.end()) u.push_back(t);
  std::sort(u.begin(), u.end());
  u.erase(std::unique(u.begin(), u.end()), u.end());
  const auto node_in = [](const std::vector<double>& all, double t, int count) {
    const auto at = std::lower_bound(all.begin(), all.end(), t);
    return at != all.end() && *at == t ? static_cast<int>(at - all.begin()) % count : -1;
  };
  std::vector<int> corners;
  for (const int corner : old.corners())
    corners.push_back(node_in(u, old.parameters()[corner], isize(u)));
  const CurveMesh mesh(u, old.closed(), corners);
  Points dofs(mesh.dof_count(), 3);
  for (int node = 0; node < mesh.node_count(); ++node) {
    const int source = node_in(old.parameters(), u[node], old.node_count());
    if (source < 0) continue;  // of the part, set below
    dofs.row(mesh.position_dof(node)) = curve_.position(source);
    dofs.row(mesh.slope_in(node)) = curve_.slope_in(source);
    dofs.row(mesh.slope_out(node)) = curve_.slope_out(source);
  }
  size_t k = 0;  // node of the part
  for (size_t p = 0; p < pieces_.size(); ++p) {
    const SplineAxis& axis = pieces_[p];
    for (int i = 0; i <= axis.intervals(); ++i) {
      const int interval = std::min(i, axis.intervals() - 1);
      const double s = i - interval;
      Eigen::Matrix<double, 4, 3> local;
      for (int j = 0; j < 4; ++j)
        local.row(j) = poles.row(first_pole_[p] + axis.function(interval, j));
      const int node = node_in(u, nodes_[k + static_cast<size_t>(i)].u, mesh.node_count());
      const bool first = p == 0 && i == 0, last = p + 1 == pieces_.size() && i == axis.intervals();
      const bool kept = (first && start_ == Border::Clamped) || (last && end_ == Border::Clamped);
      if (kept) continue;
      const bool pinned = (i == 0 && start_ != Border::Periodic) ||
                          (i == axis.intervals() && start_ != Border::Periodic);
      if (!pinned)
        dofs.row(mesh.position_dof(node)) =
            axis.basis(interval, s).transpose() * local + origin_.transpose();
      const Eigen::RowVector3d slope =
          axis.basis(interval, s, 1).transpose() * local / axis.length(interval);
      // At a corner, only the side of this piece.
      if (i > 0) dofs.row(mesh.slope_in(node)) = slope;
      if (i < axis.intervals()) dofs.row(mesh.slope_out(node)) = slope;
    }
    k += static_cast<size_t>(axis.intervals());
  }
  return {mesh, dofs};
}

HermiteCurve PartSpline::faired(double softness) const {
  const auto to_power = [](double a, int exponent) { return std::pow(a, exponent); };
  Points fairest = Points::Zero(poles_, 3);
  if (softness > 0) {
    // Q of fair_part()
    const double a = scale(4 * length_, 0);
    fairest = minimiser({1, 0, 0, to_power(a, 6)}, fairest);
  }
  const double a = scale(wavelength_, softness);
  return with_poles(minimiser(
      {1, 3 * softness * to_power(a, 2), 3 * softness * to_power(a, 4), to_power(a, 6)}, fairest));
}

}  // namespace

double part_length(const HermiteCurve& curve, const CurvePart& part) {
  static const SegmentRule rule = gauss_legendre(8);
  const double whole = curve.end() - curve.start();
  double length = 0;
  for (const double turn : {0.0, whole}) {
    if (turn > 0 && !curve.closed()) break;
    for (int s = 0; s < curve.segment_count(); ++s) {
      const double a = curve.parameters()[s], h = curve.mesh().length(s);
      const double low = std::max(part.from - turn, a), high = std::min(part.to - turn, a + h);
      for (long q = 0; low < high && q < rule.s.size(); ++q)
        length += (high - low) * rule.weights[q] *
                  curve.evaluate({s, (low - a + (high - low) * rule.s[q]) / h}, 1).norm();
    }
  }
  return length;
}

std::vector<CurvePart> parts_inside(const HermiteCurve& curve, const Vec3& centre, double radius) {
  const auto outside = [&](double u) { return (curve.evaluate(u) - centre).norm() - radius; };
  const auto border = [&](double in, double out) {
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (in + out);
      (outside(middle) < 0 ? in : out) = middle;
    }
    return in;
  };
  constexpr int samples = 32;
  std::vector<double> u;
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k < samples; ++k)
      u.push_back(curve.parameters()[s] + curve.mesh().length(s) * k / samples);
  u.push_back(curve.end());
  if (const CurvePoint nearest = curve.closest_point(centre); nearest.distance < radius)
    u.insert(std::upper_bound(u.begin(), u.end(), nearest.u), nearest.u);
  std::vector<CurvePart> parts;
  bool inside = false;
  for (size_t i = 0; i < u.size(); ++i) {
    const bool now = outside(u[i]) < 0;
    if (now && !inside) parts.push_back({i == 0 ? u[0] : border(u[i], u[i - 1]), u[i]});
    if (inside) parts.back().to = now ? u[i] : border(u[i - 1], u[i]);
    inside = now;
  }
  std::erase_if(parts, [](const CurvePart& part) { return !(part.from < part.to); });
  // Parts at both sides of the seam are one.
  if (curve.closed() && parts.size() > 1 && parts.front().from == curve.start() &&
      parts.back().to == curve.end()) {
    parts.back().to += parts.front().to - curve.start();
    parts.erase(parts.begin());
  }
  return parts;
}

HermiteCurve fair_part(const HermiteCurve& curve, CurvePart part, double wavelength) {
  if (!(wavelength > 0) || !std::isfinite(wavelength))
    throw InputError("local fairing: found the wavelength " + format_number(wavelength) +
                     ", expected a length above 0");
  if (!(part.from < part.to) || !std::isfinite(part.from) || !std::isfinite(part.to))
    throw InputError("local fairing: found a part from " + format_number(part.from) + " to " +
                     format_number(part.to) + ", expected ascending parameters");
  const double whole = curve.end() - curve.start();
  part.to = std::min(part.to, part.from + whole);
  if (!curve.closed()) part = {std::max(part.from, curve.start()), std::min(part.to, curve.end())};
  const double period =
      curve.closed() ? std::floor((part.from - curve.start()) / whole) * whole : 0;
  part = {part.from - period, part.to - period};
  // Too short for a node at each border.
  if (!(part.to - part.from > 4 * same_parameter(curve)) || !(part_length(curve, part) > 0))
    return curve;
  const Fairness before = fairness(curve);
  for (const double shorter : {1.0, 0.7, 0.5, 0.25}) {
    const PartSpline spline(curve, part, shorter * wavelength);
    for (const double softness : {0.0, 0.1, 0.2, 0.4, 0.7, 1.0}) {
      HermiteCurve result = spline.faired(softness);
      if (fairness(result, before.largest_curvature).extrema <= before.extrema) return result;
    }
  }
  return curve;
}

}  // namespace batten
