#include "batten/io/lines/named_curve.h"

namespace batten {

std::vector<Vec3> NamedCurve::written_points() const {
  if (!has_curve()) return points;
  std::vector<Vec3> on_curve;
  for (const double u : parameters) on_curve.push_back(curve.evaluate(u));
  return on_curve;
}

}  // namespace batten
