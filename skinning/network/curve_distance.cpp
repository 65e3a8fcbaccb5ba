#include "batten/skinning/network/curve_distance.h"

#include <algorithm>
#include <cmath>

namespace batten::detail {
namespace {

// Newton's steps at the end: distances near the least one differ by rounding only, while their
// slopes still say where it is. Not where the curves run along each other.
void polish(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
            const SampledCurve& b, const std::array<double, 2>& range_b, double& tb) {
  for (int step = 0; step < 3; ++step) {
    const Vec3 d = a.point(ta) - b.point(tb);
    const Vec3 da = a.curve->evaluate(ta, 1), db = b.curve->evaluate(tb, 1);
    const double haa = da.squaredNorm() + d.dot(a.curve->evaluate(ta, 2)),
                 hbb = db.squaredNorm() - d.dot(b.curve->evaluate(tb, 2)), hab = -da.dot(db),
                 det = haa * hbb - hab * hab;
    const double ga = da.dot(d), gb = -db.dot(d);
    const bool at_a = ta <= range_a[0] || ta >= range_a[1],
               at_b = tb <= range_b[0] || tb >= range_b[1];
    double move_a = 0, move_b = 0;
    if (at_a && at_b) return;
    if (at_a && hbb > 0)
      move_b = -gb / hbb;
    else if (at_b && haa > 0)
      move_a = -ga / haa;
    else if (!at_a && !at_b && haa > 0 && det > 1e-8 * haa * hbb)
      move_a = -(hbb * ga - hab * gb) / det, move_b = -(haa * gb - hab * ga) / det;
    constexpr double kSmall = 1e-6;
    if (!(std::abs(move_a) <= kSmall * (a.t.back() - a.t.front())) ||
        !(std::abs(move_b) <= kSmall * (b.t.back() - b.t.front())))
      return;
    ta = std::clamp(ta + move_a, range_a[0], range_a[1]);
    tb = std::clamp(tb + move_b, range_b[0], range_b[1]);
  }
}

}  // namespace

double chord_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double& s,
                      double& t) {
  const Vec3 da = a1 - a0, db = b1 - b0, r = a0 - b0;
  const double a = da.squaredNorm(), e = db.squaredNorm(), f = db.dot(r), c = da.dot(r),
               b = da.dot(db), det = a * e - b * b;
  s = det > 1e-14 * a * e ? std::clamp((b * f - c * e) / det, 0.0, 1.0) : 0.5;
  t = e > 0 ? std::clamp((b * s + f) / e, 0.0, 1.0) : 0.5;
  s = a > 0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0.5;
  t = e > 0 ? std::clamp((b * s + f) / e, 0.0, 1.0) : 0.5;
  return (a0 + s * da - b0 - t * db).norm();
}

std::array<double, 2> bracket(const SampledCurve& sampled_curve, int segment) {
  const double a = sampled_curve.t[segment], b = sampled_curve.t[segment + 1],
               more = 0.25 * (b - a);
  return {std::max(a - more, sampled_curve.t.front()), std::min(b + more, sampled_curve.t.back())};
}

double nearest(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
               const SampledCurve& b, const std::array<double, 2>& range_b, double& tb) {
  double damping = 1e-9;
  Vec3 d = a.point(ta) - b.point(tb);
  for (int step = 0; step < 30; ++step) {
    const Vec3 da = a.curve->evaluate(ta, 1), db = b.curve->evaluate(tb, 1);
    const double ga = da.dot(d), gb = -db.dot(d);
    const bool fixed_a = (ta <= range_a[0] && ga > 0) || (ta >= range_a[1] && ga < 0),
               fixed_b = (tb <= range_b[0] && gb > 0) || (tb >= range_b[1] && gb < 0);
    if (fixed_a && fixed_b) break;
    const double haa = da.squaredNorm() * (1 + damping), hbb = db.squaredNorm() * (1 + damping),
                 hab = -da.dot(db), det = haa * hbb - hab * hab;
    if (!(haa > 0) || !(hbb > 0)) break;
    double move_a = 0, move_b = 0;
    if (fixed_a)
      move_b = -gb / hbb;
    else if (fixed_b)
      move_a = -ga / haa;
    else
      move_a = -(hbb * ga - hab * gb) / det, move_b = -(haa * gb - hab * ga) / det;
    const double next_a = std::clamp(ta + move_a, range_a[0], range_a[1]),
                 next_b = std::clamp(tb + move_b, range_b[0], range_b[1]);
    const Vec3 next = a.point(next_a) - b.point(next_b);
    if (!(next.norm() <= d.norm())) {
      damping = std::max(10 * damping, 1e-3);
      if (damping > 1e6) break;
      continue;
    }
    const bool settled = std::abs(next_a - ta) <= 1e-15 * (a.t.back() - a.t.front()) &&
                         std::abs(next_b - tb) <= 1e-15 * (b.t.back() - b.t.front());
    ta = next_a;
    tb = next_b;
    d = next;
    damping *= 0.1;
    if (settled) break;
  }
  polish(a, range_a, ta, b, range_b, tb);
  return (a.point(ta) - b.point(tb)).norm();
}

}  // namespace batten::detail
