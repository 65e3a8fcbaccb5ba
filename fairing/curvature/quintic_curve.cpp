// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curvature/quintic_curve.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "batten/core/errors.h"
#include "batten/elements/hermite_segment.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

// Coefficients of s⁰ … s⁵ on [0, 1], one row per basis function.
constexpr double kCoefficients[6][6] = {
    {1, 0, 0, -10, 15, -6}, {0, 1, 0, -6, 8, -3}, {0, 0, 0.5, -1.5, 1.5, -0.5},
    {0, 0, 0, 10, -15, 6},  {0, 0, 0, -4, 7, -3}, {0, 0, 0, 0.5, -1, 0.5},
};

// Largest distance between a piece of a quintic segment and its cubic Hermite interpolant.
double cubic_error(const QuinticCurve& curve, int segment, double from, double to) {
  const HermiteSegment cubic((to - from) * curve.length(segment));
  const Vec3 x0 = curve.evaluate({segment, from}), x1 = curve.evaluate({segment, to});
  const Vec3 d0 = curve.evaluate({segment, from}, 1), d1 = curve.evaluate({segment, to}, 1);
  double error = 0;
  constexpr int samples = 16;
  for (int k = 1; k < samples; ++k) {
    const double t = static_cast<double>(k) / samples;
    const auto H = cubic.evaluate(t);
    const Vec3 x = H[0] * x0 + H[1] * d0 + H[2] * x1 + H[3] * d1;
    error = std::max(error, (x - curve.evaluate({segment, from + t * (to - from)})).norm());
  }
  return error;
}

// The samples may miss up to 2 % of the true maximum.
constexpr double kBetweenSamples = 0.98;

int pieces_needed(const QuinticCurve& curve, int segment, double tolerance) {
  constexpr int most = 10000;
  for (int pieces = 1; pieces <= most;) {
    double error = 0;
    for (int i = 0; i < pieces; ++i)
      error = std::max(error, cubic_error(curve, segment, static_cast<double>(i) / pieces,
                                          static_cast<double>(i + 1) / pieces));
    if (error <= kBetweenSamples * tolerance) return pieces;
    // The error falls with the fourth power of the length; the first guesses are deliberately low.
    const double guess = pieces * std::pow(error / tolerance, 0.25);
    pieces = std::max(pieces + 1, static_cast<int>(std::min(0.9 * guess, most + 1.0)));
  }
  throw InputError("the tolerance " + format_number(tolerance) + " is too small: a segment needs " +
                   "more than " + std::to_string(most) + " cubics");
}

}  // namespace

Eigen::Matrix<double, 6, 1> quintic_functions(double h, double s, int order) {
  if (!(h > 0))
    throw InputError("found a quintic segment of length " + format_number(h) +
                     ", expected a length above 0");
  if (order < 0 || order > 3)
    throw InputError("a quintic segment has derivatives of order 0 to 3, not " +
                     std::to_string(order));
  Eigen::Matrix<double, 6, 1> H;
  const double scale[3] = {1, h, h * h};
  for (int f = 0; f < 6; ++f) {
    double sum = 0;
    for (int p = 5; p >= order; --p) {
      double factor = kCoefficients[f][p];
      for (int k = 0; k < order; ++k) factor *= p - k;
      sum = sum * s + factor;
    }
    H[f] = sum * scale[f % 3] / std::pow(h, order);
  }
  return H;
}

QuinticCurve::QuinticCurve(std::vector<double> parameters, Points dofs, bool closed)
    : mesh_(std::move(parameters), closed), dofs_(std::move(dofs)) {
  if (dofs_.rows() != 3 * node_count())
    throw InputError("found " + std::to_string(dofs_.rows()) + " dofs of a quintic curve with " +
                     std::to_string(node_count()) + " nodes, expected three for each");
  if (!dofs_.allFinite()) throw InputError("a curve node is not finite");
}

Vec3 QuinticCurve::evaluate(CurveMesh::SegmentPoint at, int order) const {
  const auto H = quintic_functions(length(at.segment), at.s, order);
  const auto a = dofs_.middleRows<3>(3 * at.segment);
  const auto b = dofs_.middleRows<3>(3 * node_after(at.segment));
  return a.transpose() * H.head<3>() + b.transpose() * H.tail<3>();
}

double QuinticCurve::arc_length(int segment) const {
  static const SegmentRule rule = gauss_legendre(16);
  double sum = 0;
  for (long p = 0; p < rule.s.size(); ++p)
    sum += rule.weights[p] * evaluate({segment, rule.s[p]}, 1).norm();
  return length(segment) * sum;
}

HermiteCurve QuinticCurve::cubics(double tolerance) const {
  if (!(tolerance > 0))
    throw InputError("found the tolerance " + format_number(tolerance) +
                     ", expected a length above 0");
  std::vector<double> u = {parameters().front()};
  std::vector<Vec3> rows;
  for (int i = 0; i < segment_count(); ++i) {
    const int pieces = pieces_needed(*this, i, tolerance);
    for (int k = 0; k < pieces; ++k) {
      const double s = static_cast<double>(k) / pieces;
      rows.push_back(evaluate({i, s}));
      rows.push_back(evaluate({i, s}, 1));
      u.push_back(k + 1 == pieces ? parameters()[i + 1]
                                  : parameters()[i] + (k + 1.0) / pieces * length(i));
    }
  }
  if (!closed()) {
    rows.push_back(evaluate({segment_count() - 1, 1}));
    rows.push_back(evaluate({segment_count() - 1, 1}, 1));
  }
  Points dofs(static_cast<long>(rows.size()), 3);
  for (size_t r = 0; r < rows.size(); ++r) dofs.row(static_cast<long>(r)) = rows[r];
  return {CurveMesh(std::move(u), closed()), std::move(dofs)};
}

}  // namespace batten
