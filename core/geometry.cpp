#include "batten/core/geometry.h"

namespace batten {

Vec3 to_rotation_vector(const Mat3& R) {
  const Eigen::AngleAxisd rotation(R);
  return to_rotation_vector(rotation.axis(), rotation.angle());
}

std::string format_point(const Vec3& p) {
  const double rounding = 1e-14 * p.cwiseAbs().maxCoeff();
  const auto word = [&](double x) { return format_number(std::abs(x) <= rounding ? 0.0 : x); };
  return "(" + word(p.x()) + ", " + word(p.y()) + ", " + word(p.z()) + ")";
}

}  // namespace batten
