#include "batten/io/lines/named_curve.h"

namespace batten {

std::vector<Vec3> NamedCurve::written_points() const {
  if (!has_curve()) return points;
  std::vector<Vec3> on_curve;
  constexpr double one_place = 1e-12;  // of the range of u, which is the length to a few digits
  for (const double u : parameters) {
    const Vec3 p = curve.evaluate(u);
    if (on_curve.empty() ||
        (p - on_curve.back()).norm() > one_place * (curve.end() - curve.start()))
      on_curve.push_back(p);
  }
  return on_curve;
}

}  // namespace batten
