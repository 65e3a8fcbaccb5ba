#include "batten/skinning/model/boundary_side.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/index.h"
#include "batten/core/plane.h"

namespace batten {
namespace {

// Gauss-Legendre, three points: exact for the speed of quintics.
double arc_length(const HermiteCurve& curve, double from, double to) {
  static const double offset = std::sqrt(0.6);
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const auto speed = [&](double x) { return curve.evaluate(middle + half * x, 1).norm(); };
  return half * (5 * speed(-offset) + 8 * speed(0) + 5 * speed(offset)) / 9;
}

}  // namespace

void BoundarySide::add(HermiteCurve curve, HermiteCurve image) {
  constexpr int kParts = 4;  // of a segment: lengths are then good to 1e-9 on quarter circles
  const auto& at = curve.parameters();
  double length = this->length();
  for (size_t i = 0; i + 1 < at.size(); ++i)
    for (int k = 0; k < kParts; ++k) {
      const double step = (at[i + 1] - at[i]) / kParts;
      const double from = at[i] + k * step, to = k + 1 == kParts ? at[i + 1] : from + step;
      length += arc_length(curve, from, to);
      knots_.push_back({count_of(pieces_), from, to});
      lengths_.push_back(length);
    }
  pieces_.push_back({std::move(curve), std::move(image)});
}

BoundarySide::Point BoundarySide::on(double length) const {
  const auto it = std::lower_bound(lengths_.begin(), lengths_.end() - 1, length);
  const auto k = static_cast<size_t>(it - lengths_.begin());
  const Knot& knot = knots_[k];
  const double before = k == 0 ? 0 : lengths_[k - 1], inside = lengths_[k] - before;
  const auto& [curve, image] = pieces_[static_cast<size_t>(knot.piece)];
  const double wanted = std::clamp(length - before, 0.0, inside);
  double u = inside > 0 ? knot.from + (knot.to - knot.from) * wanted / inside : knot.from;
  // At the ends of the knot the table has the parameter already.
  for (int round = 0; round < 3 && wanted > 0 && wanted < inside; ++round) {
    const double speed = curve.evaluate(u, 1).norm();
    if (!(speed > 0)) break;
    const double step = (wanted - arc_length(curve, knot.from, u)) / speed;
    u = std::clamp(u + step, knot.from, knot.to);
    if (std::abs(step) < 1e-13 * (knot.to - knot.from)) break;
  }
  // A node belongs to the segment that begins there: at its end a knot asks just before it.
  const double inner = std::min(u, knot.to - 1e-9 * (knot.to - knot.from));
  const Vec3 slope = curve.evaluate(inner, 1);
  const double speed = slope.norm(), rate = speed > 0 ? this->length() / speed : 0;
  return {curve.evaluate(u), slope * rate, flat(image.evaluate(u)),
          flat(image.evaluate(inner, 1)) * rate};
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
