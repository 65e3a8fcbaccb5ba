// The point of a curve that is nearest to another point.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

struct CurvePoint {
  double u = 0;
  double distance = 0;
};

/// The nearest point of a curve. It is looked for from each parameter of `u` (ascending; the curve
/// is smooth between neighbours) at which the distance is a local minimum: by Newton's method on
/// (X - p)·X' = 0, by bisection where it leaves the two neighbours. `evaluate(u, order)` takes
/// orders 0 to 2. A minimum narrower than the samples is missed. `at_u`: the points there, for
/// many calls.
template <class Evaluate>
CurvePoint closest_on_curve(const Evaluate& evaluate, const std::vector<double>& u,
                            const std::vector<Vec3>& at_u, const Vec3& p) {
  std::vector<double> distance(u.size());
  for (size_t i = 0; i < u.size(); ++i) distance[i] = (at_u[i] - p).norm();
  CurvePoint best{u.front(), std::numeric_limits<double>::infinity()};
  const size_t last = u.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    const size_t below = i == 0 ? 0 : i - 1, above = std::min(i + 1, last);
    if (distance[i] < best.distance) best = {u[i], distance[i]};
    if (distance[i] > distance[below] || distance[i] > distance[above]) continue;
    double low = u[below], high = u[above], x = u[i];
    for (int step = 0; step < 60; ++step) {
      const Vec3 d = evaluate(x, 0) - p, d1 = evaluate(x, 1);
      const double g = d.dot(d1), slope = d1.squaredNorm() + d.dot(evaluate(x, 2));
      (g > 0 ? high : low) = x;
      if (const double reached = d.norm(); reached < best.distance) best = {x, reached};
      double next = x - g / slope;
      // Rounding may put the last steps a hair outside of the bracket: those end the search.
      const bool done = slope > 0 && std::abs(next - x) <= 1e-14 * (u.back() - u.front());
      if (!(slope > 0) || !(next >= low) || !(next <= high)) next = 0.5 * (low + high);
      if (done || next == x) break;
      x = next;
    }
  }
  return best;
}
template <class Evaluate>
CurvePoint closest_on_curve(const Evaluate& evaluate, const std::vector<double>& u, const Vec3& p) {
  std::vector<Vec3> at_u;
  at_u.reserve(u.size());
  for (const double t : u) at_u.push_back(evaluate(t, 0));
  return closest_on_curve(evaluate, u, at_u, p);
}

}  // namespace batten
