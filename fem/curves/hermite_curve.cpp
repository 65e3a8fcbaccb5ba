// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/hermite_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/hermite_segment.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

Points interleaved(const std::vector<double>& parameters, const Points& positions,
                   const Points& derivatives) {
  const auto n = static_cast<long>(parameters.size());
  if (n < 2) throw InputError("a curve needs at least two nodes");
  if (positions.rows() != n || derivatives.rows() != n)
    throw InputError("found a curve with " + std::to_string(n) + " parameters, " +
                     std::to_string(positions.rows()) + " positions and " +
                     std::to_string(derivatives.rows()) + " derivatives, expected equal numbers");
  Points dofs(2 * n, 3);
  for (long i = 0; i < n; ++i) {
    dofs.row(2 * i) = positions.row(i);
    dofs.row(2 * i + 1) = derivatives.row(i);
  }
  return dofs;
}

}  // namespace

HermiteCurve::HermiteCurve(CurveMesh mesh, Points dofs)
    : mesh_(std::move(mesh)), dofs_(std::move(dofs)) {
  if (dofs_.rows() != mesh_.dof_count())
    throw InputError("found " + std::to_string(dofs_.rows()) + " dofs of a curve, expected " +
                     std::to_string(mesh_.dof_count()));
  if (!dofs_.allFinite()) throw InputError("a curve node is not finite");
}

HermiteCurve::HermiteCurve(std::vector<double> parameters, const Points& positions,
                           const Points& derivatives)
    : HermiteCurve(CurveMesh(parameters), interleaved(parameters, positions, derivatives)) {}

Vec3 HermiteCurve::evaluate(CurveMesh::SegmentPoint at, int order) const {
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, order);
  const auto dof = mesh_.segment_dofs(at.segment);
  return (H[0] * dofs_.row(dof[0]) + H[1] * dofs_.row(dof[1]) + H[2] * dofs_.row(dof[2]) +
          H[3] * dofs_.row(dof[3]))
      .transpose();
}

Vec3 HermiteCurve::evaluate(double u, int order) const { return evaluate(mesh_.locate(u), order); }

BezierCubic<Vec3> HermiteCurve::bezier(int segment) const {
  const int next = (segment + 1) % node_count();
  const double third = mesh_.length(segment) / 3;
  return BezierCubic<Vec3>::between(position(segment), third * slope_out(segment),
                                    third * slope_in(next), position(next));
}

double HermiteCurve::curvature(double u) const {
  const Vec3 d1 = evaluate(u, 1), d2 = evaluate(u, 2);
  const double speed = d1.norm();
  return speed > 0 ? d1.cross(d2).norm() / (speed * speed * speed) : 0;
}

double HermiteCurve::length() const {
  static const SegmentRule rule = gauss_legendre(8);
  double length = 0;
  for (int i = 0; i < segment_count(); ++i)
    for (long p = 0; p < rule.s.size(); ++p)
      length += mesh_.length(i) * rule.weights[p] *
                evaluate(CurveMesh::SegmentPoint{i, rule.s[p]}, 1).norm();
  return length;
}

namespace {

using Quintic = std::array<double, 6>;  // Bernstein coefficients

// Zero of the polynomial in [low, high], where its sign changes once.
double zero_between(const Quintic& power, double low, double high, bool rising) {
  double s = 0.5 * (low + high);
  for (int step = 0; step < 80; ++step) {
    double g = power[5], slope = 0;
    for (int k = 4; k >= 0; --k) {
      slope = slope * s + g;
      g = g * s + power[k];
    }
    ((g > 0) == rising ? high : low) = s;
    double next = s - g / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - s) <= 1e-16) break;
    s = next;
  }
  return s;
}

// Calls visit(s) at every zero of the polynomial in [0, 1]; double zeros may be visited twice.
template <class Visit>
void zeros(const Quintic& power, Quintic b, double low, double high, int depth,
           const Visit& visit) {
  int changes = 0;
  for (int i = 0; i < 5; ++i) changes += (b[i] > 0) != (b[i + 1] > 0);
  if (changes == 0) return;
  if (changes == 1 || depth == 50) {
    visit(changes == 1 ? zero_between(power, low, high, b[5] > 0) : 0.5 * (low + high));
    return;
  }
  // De Casteljau subdivision at the middle: `first` half, and the second half in place.
  Quintic first = b;
  for (int k = 1; k < 6; ++k) {
    for (int i = 0; i < 6 - k; ++i) b[i] = 0.5 * (b[i] + b[i + 1]);
    first[k] = b[0];
  }
  const double middle = 0.5 * (low + high);
  zeros(power, first, low, middle, depth + 1, visit);
  zeros(power, b, middle, high, depth + 1, visit);
}

}  // namespace

CurvePoint HermiteCurve::closest_point(const Vec3& p) const {
  CurvePoint best{start(), std::numeric_limits<double>::infinity()};
  for (int n = 0; n < node_count(); ++n)
    if (const double d = (position(n) - p).norm(); d < best.distance) best = {parameters()[n], d};
  for (int s = 0; s < segment_count(); ++s) {
    const auto dof = mesh_.segment_dofs(s);
    const double h = mesh_.length(s);
    const Vec3 a = dofs_.row(dof[0]).transpose() - p, b = dofs_.row(dof[2]).transpose() - p,
               da = h * dofs_.row(dof[1]), db = h * dofs_.row(dof[3]);
    // The segment lies in the convex hull of its Bézier points.
    const Vec3 q = a + da / 3, r = b - db / 3, middle = 0.25 * (a + q + r + b);
    double reach = 0;
    for (const Vec3& c : {a, q, r, b}) reach = std::max(reach, (c - middle).squaredNorm());
    if (middle.norm() - std::sqrt(reach) >= best.distance) continue;
    // (X - p)·X' in powers of s, and its zeros.
    const auto [c0, c1, c2, c3] = PowerCubic<Vec3>::of_hermite(a, da, b, db);
    const Quintic power = {c0.dot(c1),
                           c1.dot(c1) + 2 * c0.dot(c2),
                           3 * c1.dot(c2) + 3 * c0.dot(c3),
                           2 * c2.dot(c2) + 4 * c1.dot(c3),
                           5 * c2.dot(c3),
                           3 * c3.dot(c3)};
    constexpr double over_binomial[6] = {1, 1 / 5.0, 1 / 10.0, 1 / 10.0, 1 / 5.0, 1};
    constexpr int pascal[6][6] = {{1},          {1, 1},          {1, 2, 1},
                                  {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}};
    Quintic bernstein{};
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k <= i; ++k) bernstein[i] += pascal[i][k] * over_binomial[k] * power[k];
    zeros(power, bernstein, 0, 1, 0, [&](double x) {
      const double d = (evaluate(CurveMesh::SegmentPoint{s, x}) - p).norm();
      if (d < best.distance) best = {parameters()[s] + x * h, d};
    });
  }
  return best;
}

HermiteCurve HermiteCurve::with_nodes(std::vector<double> added) const {
  std::erase_if(added, [&](double u) { return !(u > start()) || !(u < end()); });
  std::sort(added.begin(), added.end());
  std::vector<double> u = {start()};
  std::vector<int> corners, old_node;  // old node of each new node, or -1
  auto next = added.begin();
  old_node.push_back(0);
  for (int i = 0; i < segment_count(); ++i) {
    for (; next != added.end() && *next < parameters()[i + 1]; ++next)
      if (*next > u.back()) {
        u.push_back(*next);
        old_node.push_back(-1);
      }
    u.push_back(parameters()[i + 1]);
    old_node.push_back(i + 1);
  }
  for (size_t i = 0; i + closed() < old_node.size(); ++i)
    if (old_node[i] >= 0 && mesh_.is_corner(old_node[i])) corners.push_back(static_cast<int>(i));
  CurveMesh mesh(std::move(u), closed(), std::move(corners));
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < mesh.node_count(); ++i) {
    const int old = old_node[i];
    const double at = mesh.parameters()[i];
    dofs.row(mesh.position_dof(i)) = old < 0 ? evaluate(at) : position(old);
    dofs.row(mesh.slope_in(i)) = old < 0 ? evaluate(at, 1) : slope_in(old);
    dofs.row(mesh.slope_out(i)) = old < 0 ? evaluate(at, 1) : slope_out(old);
  }
  return {std::move(mesh), std::move(dofs)};
}

HermiteCurve HermiteCurve::with_scaled_parameter(double factor) const {
  std::vector<double> u = parameters();
  for (double& x : u) x *= factor;
  Points dofs = dofs_;
  for (int n = 0; n < node_count(); ++n) {
    dofs.row(mesh_.slope_out(n)) /= factor;
    if (mesh_.is_corner(n)) dofs.row(mesh_.slope_in(n)) /= factor;
  }
  return {CurveMesh(std::move(u), closed(), mesh_.corners()), std::move(dofs)};
}

HermiteCurve HermiteCurve::backwards() const {
  std::vector<double> u;
  for (auto it = parameters().rbegin(); it != parameters().rend(); ++it)
    u.push_back(start() + end() - *it);
  const auto other = [&](int node) {
    return closed() ? (node_count() - node) % node_count() : node_count() - 1 - node;
  };
  std::vector<int> corners;
  for (const int c : mesh_.corners()) corners.push_back(other(c));
  std::sort(corners.begin(), corners.end());
  const CurveMesh mesh(u, closed(), corners);
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < mesh.node_count(); ++i) {
    dofs.row(mesh.position_dof(i)) = position(other(i)).transpose();
    dofs.row(mesh.slope_in(i)) = -slope_out(other(i)).transpose();
    dofs.row(mesh.slope_out(i)) = -slope_in(other(i)).transpose();
  }
  return {mesh, dofs};
}

}  // namespace batten
