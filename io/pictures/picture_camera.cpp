// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/picture_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace batten::detail {

ViewAxes::ViewAxes(double azimuth, double elevation, int up_axis) {
  const double degree = std::numbers::pi / 180;
  const double a = azimuth * degree, e = elevation * degree;
  const auto turned = [&](double x, double y, double z) {
    Vec3 v;
    v[(up_axis + 1) % 3] = x;
    v[(up_axis + 2) % 3] = y;
    v[up_axis] = z;
    return v;
  };
  right = turned(std::cos(a), std::sin(a), 0);
  towards = turned(std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e));
  up = towards.cross(right);
}

ViewAxes::ViewAxes(const Vec3& towards_camera) : towards(towards_camera.normalized()) {
  const Vec3 above = std::abs(towards.z()) > std::sqrt(0.5) ? Vec3::UnitY() : Vec3::UnitZ();
  right = above.cross(towards).normalized();
  up = towards.cross(right);
}

ViewAxes best_view(const std::vector<Vec3>& points) {
  const PrincipalAxes plane = principal_axes(points);
  Vec3 normal = plane.axes.col(0);
  // A straight line defines no plane: use the default view, made perpendicular to the line.
  if (plane.values[1] <= 1e-9 * plane.values[2]) {
    const Vec3 along = plane.axes.col(2), usual = ViewAxes(-30, 30).towards;
    normal = usual - usual.dot(along) * along;
    if (normal.norm() < 1e-6) normal = along.unitOrthogonal();
  }
  // From above; from the front (-y) if the plane is steep, from the right if it faces sideways.
  const double side = std::abs(normal.z()) > std::sqrt(0.5) ? normal.z()
                      : std::abs(normal.y()) > 0.3          ? -normal.y()
                                                            : normal.x();
  return ViewAxes(side < 0 ? Vec3(-normal) : normal);
}

Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& p : points) {
    const Vec3 q(axes.right.dot(p), axes.up.dot(p), axes.towards.dot(p));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  const double margin = 0.06;
  const double width = viewport.width * (1 - 2 * margin);
  const double height = (viewport.height - viewport.top - viewport.bottom) * (1 - 2 * margin);
  const Vec3 extent = high - low;
  double pixel = std::max(extent.x() / width, extent.y() / height);
  if (!(pixel > 0)) pixel = 1 / width;
  pixel /= zoom;
  const Vec3 middle = (low + high) / 2;
  const double shift = pixel * (viewport.top - viewport.bottom) / 2;
  return {middle.x() * axes.right + (middle.y() + shift) * axes.up + middle.z() * axes.towards,
          pixel};
}

}  // namespace batten::detail
