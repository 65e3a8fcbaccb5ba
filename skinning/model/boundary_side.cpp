#include "batten/skinning/model/boundary_side.h"

#include <algorithm>
#include <cmath>

#include "batten/core/isize.h"
#include "batten/core/planar_geometry.h"

namespace batten {

// Gauss-Legendre, three points: exact for the speed of quintics.
double BoundarySide::Part::length_to(double t) const {
  static const double offset = std::sqrt(0.6);
  const double half = 0.5 * t;
  const auto speed = [&](double x) { return slope(half + half * x).norm(); };
  return half * (5 * speed(-offset) + 8 * speed(0) + 5 * speed(offset)) / 9;
}

void BoundarySide::add(HermiteCurve curve, HermiteCurve pcurve) {
  constexpr int kParts = 4;  // of a segment: lengths are then good to 1e-9 on quarter circles
  const auto& at = curve.parameters();
  double length = this->length();
  for (size_t i = 0; i + 1 < at.size(); ++i)
    for (int k = 0; k < kParts; ++k) {
      const double step = (at[i + 1] - at[i]) / kParts;
      Part part;
      part.piece = isize(pcurves_);
      part.from = at[i] + k * step;
      part.to = k + 1 == kParts ? at[i + 1] : part.from + step;
      // The cubic through four of its places.
      Vec3 x[4];
      for (int n = 0; n < 4; ++n)
        x[n] = curve.evaluate(n < 3 ? part.from + (part.to - part.from) * n / 3 : part.to);
      part.c[0] = x[0];
      part.c[1] = -5.5 * x[0] + 9 * x[1] - 4.5 * x[2] + x[3];
      part.c[2] = 9 * x[0] - 22.5 * x[1] + 18 * x[2] - 4.5 * x[3];
      part.c[3] = -4.5 * x[0] + 13.5 * x[1] - 13.5 * x[2] + 4.5 * x[3];
      const double own = part.length_to(1);
      for (const int end : {0, 1}) {
        const double speed = part.slope(end).norm();
        part.rates[end] = speed > 0 ? own / speed : 1;
      }
      length += own;
      parts_.push_back(part);
      lengths_.push_back(length);
    }
  pcurves_.push_back(std::move(pcurve));
}

BoundarySide::Point BoundarySide::on(double length) const {
  const auto it = std::lower_bound(lengths_.begin(), lengths_.end() - 1, length);
  const auto k = static_cast<size_t>(it - lengths_.begin());
  const Part& part = parts_[k];
  const double before = k == 0 ? 0 : lengths_[k - 1], inside = lengths_[k] - before;
  const double wanted = std::clamp(length - before, 0.0, inside);
  // Hermite's cubic of t(s) is good to the fourth power of the part's turn; Newton's steps mend it.
  const double s = inside > 0 ? wanted / inside : 0;
  double t = s * (1 + (1 - s) * ((1 - s) * (part.rates[0] - 1) - s * (part.rates[1] - 1)));
  t = std::clamp(t, 0.0, 1.0);
  for (int round = 0; round < 3 && wanted > 0 && wanted < inside; ++round) {
    const double speed = part.slope(t).norm();
    if (!(speed > 0)) break;
    const double step = (wanted - part.length_to(t)) / speed;
    t = std::clamp(t + step, 0.0, 1.0);
    if (std::abs(step) < 1e-7) break;  // of which the next one would be the square
  }
  const double range = part.to - part.from;
  const Vec3 slope = part.slope(t);
  const double speed = slope.norm(), rate = speed > 0 ? this->length() / speed : 0;
  const HermiteCurve& pcurve = pcurves_[static_cast<size_t>(part.piece)];
  // A node belongs to the segment that begins there: at its end a part asks just before it.
  const double u = part.from + t * range, inner = std::min(u, part.to - 1e-9 * range);
  return {part.position(t), slope * rate, drop_z(pcurve.evaluate(u)),
          drop_z(pcurve.evaluate(inner, 1)) * (rate * range)};
}

BoundarySide::Point BoundarySide::at(double f) const {
  const double inside = std::clamp(f, 0.0, 1.0);
  Point point = on(inside * length());
  if (f != inside) {
    point.x += (f - inside) * point.x_f;
    point.uv += (f - inside) * point.uv_f;
  }
  return point;
}

}  // namespace batten
