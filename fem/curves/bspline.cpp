// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/bspline.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

// Power coefficients in s of the four functions on interval k, by the Cox-de Boor recursion.
Mat4 powers_on(const std::vector<double>& t, size_t k) {
  const size_t m = k + 3;  // t[m] to t[m + 1] is the interval
  const double a = t[m], h = t[m + 1] - t[m];
  Mat4 N = Mat4::Zero();
  N(0, 3) = 1;  // column c: function that begins at t[m - 3 + c]
  for (int p = 1; p <= 3; ++p) {
    Mat4 next = Mat4::Zero();
    for (int c = 3 - p; c < 4; ++c) {
      const size_t i = m - 3 + static_cast<size_t>(c);
      const auto add = [&](const Vec4& f, double constant, double slope) {
        next.col(c) += constant * f;
        next.col(c).tail<3>() += slope * f.head<3>();
      };
      if (c > 3 - p) {
        const double width = t[i + p] - t[i];
        add(N.col(c), (a - t[i]) / width, h / width);
      }
      if (c < 3) {
        const double width = t[i + p + 1] - t[i + 1];
        add(N.col(c + 1), (t[i + p + 1] - a) / width, -h / width);
      }
    }
    N = next;
  }
  return N;
}

}  // namespace

SplineAxis::SplineAxis(std::vector<double> knots, bool periodic)
    : knots_(std::move(knots)), periodic_(periodic) {
  const int n = intervals();
  if (n < (periodic ? 4 : 1))
    throw InputError("found a B-spline with " + std::to_string(n) + " intervals, expected " +
                     (periodic ? "4" : "1") + " or more");
  for (int k = 0; k < n; ++k)
    if (!(length(k) > 0)) throw InputError("the knots of a B-spline must increase");
  std::vector<double> all;
  const double period = knots_.back() - knots_.front();
  for (int k = 3; k >= 1; --k) all.push_back(periodic ? knots_[n - k] - period : knots_[0]);
  all.insert(all.end(), knots_.begin(), knots_.end());
  for (int k = 1; k <= 3; ++k) all.push_back(periodic ? knots_[k] + period : knots_[n]);
  for (int k = 0; k < n; ++k) powers_.push_back(powers_on(all, static_cast<size_t>(k)));
}

double SplineAxis::wrapped(double t) const {
  const double low = knots_.front(), high = knots_.back();
  if (periodic_ && !(t >= low && t <= high))
    t -= std::floor((t - low) / (high - low)) * (high - low);
  return std::clamp(t, low, high);
}

int SplineAxis::interval(double t) const {
  const auto above = std::upper_bound(knots_.begin(), knots_.end(), wrapped(t));
  return std::clamp(static_cast<int>(above - knots_.begin()) - 1, 0, intervals() - 1);
}

Eigen::Vector4d SplineAxis::basis(int interval, double s, int derivative) const {
  Eigen::RowVector4d power;
  switch (derivative) {
    case 0:
      power << 1, s, s * s, s * s * s;
      break;
    case 1:
      power << 0, 1, 2 * s, 3 * s * s;
      break;
    case 2:
      power << 0, 0, 2, 6 * s;
      break;
    default:
      power << 0, 0, 0, 6;
  }
  return (power * powers_[interval]).transpose();
}

namespace {

// One segment, and its interval on the parameter line of the spline.
struct SmoothPiece {
  double begin = 0, end = 0;
  BezierCubic<Vec3> bezier;
  bool after_corner = false;

  double length() const { return end - begin; }
  Vec3 blossom(double u0, double u1, double u2) const {
    return bezier.blossom((u0 - begin) / length(), (u1 - begin) / length(),
                          (u2 - begin) / length());
  }
  Vec3 second(double s) const { return bezier.second(s) / (length() * length()); }
};

SmoothPiece piece_of(const HermiteCurve& curve, int segment, double shift) {
  return {curve.parameters()[segment] + shift, curve.parameters()[segment + 1] + shift,
          curve.bezier(segment), false};
}

// Required multiplicity of the knot between two segments.
int multiplicity(const SmoothPiece& before, const SmoothPiece& after, double size) {
  if (after.after_corner) return 3;
  const double h = std::max(before.length(), after.length());
  const Vec3 jump = after.second(0) - before.second(1);
  return jump.norm() * h * h <= 1e-13 * size ? 1 : 2;
}

CubicSpline spline_of(const std::vector<SmoothPiece>& pieces) {
  CubicSpline spline;
  Box3 box;
  for (const SmoothPiece& p : pieces)
    for (const Vec3& b : p.bezier.b) box.extend(b);
  spline.size = box.diagonal().norm();

  std::vector<double> all;  // knots, repeated by multiplicity
  std::vector<size_t> piece_after;
  const auto add = [&](double knot, int times, size_t piece) {
    spline.knots.push_back(knot);
    spline.multiplicities.push_back(times);
    all.insert(all.end(), static_cast<size_t>(times), knot);
    piece_after.insert(piece_after.end(), static_cast<size_t>(times), piece);
  };
  add(pieces.front().begin, 4, 0);
  for (size_t i = 1; i < pieces.size(); ++i)
    add(pieces[i].begin, multiplicity(pieces[i - 1], pieces[i], spline.size), i);
  add(pieces.back().end, 4, pieces.size());
  for (size_t i = 0; i + 4 < all.size(); ++i) {
    // Blossom at the three knots of the pole; any segment of positive length next to the middle
    // knot can be used.
    size_t interval = i + 1;
    if (all[interval] == all[interval + 1]) interval = i + 2;
    if (all[interval] == all[interval + 1]) interval = i == 0 ? 3 : i;
    spline.poles.push_back(
        pieces[piece_after[interval]].blossom(all[i + 1], all[i + 2], all[i + 3]));
  }
  return spline;
}

}  // namespace

std::vector<CubicSpline> cubic_splines(const std::string& name, const HermiteCurve& curve) {
  const int segments = curve.segment_count();
  const auto& corners = curve.mesh().corners();
  const int first = curve.closed() && !corners.empty() ? corners.front() : 0;
  std::vector<std::vector<SmoothPiece>> stretches(1);
  for (int k = 0; k < segments; ++k) {
    const int segment = (first + k) % segments;
    if (k > 0 && curve.mesh().is_corner(segment)) stretches.emplace_back();
    const double shift = first + k >= segments ? curve.end() - curve.start() : 0;
    stretches.back().push_back(piece_of(curve, segment, shift));
  }
  std::vector<CubicSpline> splines;
  for (const auto& pieces : stretches) {
    splines.push_back(spline_of(pieces));
    splines.back().name = name + (stretches.size() > 1 ? "." + std::to_string(splines.size()) : "");
  }
  splines.front().closed = curve.closed() && corners.empty();
  return splines;
}

CubicSpline whole_spline(const std::string& name, const HermiteCurve& curve) {
  std::vector<SmoothPiece> pieces;
  for (int segment = 0; segment < curve.segment_count(); ++segment) {
    pieces.push_back(piece_of(curve, segment, 0));
    pieces.back().after_corner = curve.mesh().is_corner(segment);
  }
  CubicSpline spline = spline_of(pieces);
  spline.name = name;
  spline.closed = curve.closed() && !curve.mesh().is_corner(0);
  return spline;
}

}  // namespace batten
