#include "batten/io/meshes/node_coordinate_systems.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace batten {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr int kDeepestSystem = 200;

/// Cosine and sine, exact at the multiples of 90 degrees.
std::array<double, 2> direction(double degrees) {
  int quarter = 0;
  const double rest = std::remquo(degrees, 90, &quarter) * kDegree;
  const double c = std::cos(rest), s = std::sin(rest);
  switch (quarter & 3) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case 2:
      return {-c, -s};
    default:
      return {s, -c};
  }
}

double degrees_of(double y, double x, double near) {
  if (x == 0 && y == 0) return near;
  const double angle = std::atan2(y, x) / kDegree;
  return angle + 360 * std::round((near - angle) / 360);
}

/// (r, polar, around) of local coordinates, where `polar` is measured from z.
Vec3 sphere(const Vec3& p, const Vec3& near) {
  const double flat = std::hypot(p.x(), p.y());
  const Vec3 direct(p.norm(), degrees_of(flat, p.z(), near[1]), degrees_of(p.y(), p.x(), near[2])),
      turned(p.norm(), degrees_of(-flat, p.z(), near[1]), degrees_of(-p.y(), -p.x(), near[2]));
  const auto away = [&](const Vec3& a) {
    return std::abs(a[1] - near[1]) + std::abs(a[2] - near[2]);
  };
  return away(turned) < away(direct) ? turned : direct;
}

}  // namespace

Vec3 CoordinateFrame::position(const Vec3& n) const {
  Vec3 local = n;
  if (kind == Kind::Cylindrical) {
    const auto [c, s] = direction(n[1]);
    local = {n[0] * c, n[0] * s, n[2]};
  } else if (kind != Kind::Rectangular) {
    const bool polar = kind == Kind::Spherical;
    const auto [c, s] = direction(polar ? n[2] : n[1]);
    const auto [up, flat] = direction(polar ? n[1] : 90 - n[2]);
    local = {n[0] * flat * c, n[0] * flat * s, n[0] * up};
  }
  return origin + axes * local;
}

Vec3 CoordinateFrame::local_coordinates(const Vec3& position, const Vec3& near) const {
  const Vec3 p = axes.transpose() * (position - origin);
  switch (kind) {
    case Kind::Rectangular:
      return p;
    case Kind::Cylindrical: {
      // A radius below zero is read as one on the other side.
      const double sign = near[0] < 0 ? -1 : 1;
      return {sign * std::hypot(p.x(), p.y()), degrees_of(sign * p.y(), sign * p.x(), near[1]),
              p.z()};
    }
    case Kind::Spherical:
      return near[0] < 0 ? Vec3(sphere(-p, near).cwiseProduct(Vec3(-1, 1, 1))) : sphere(p, near);
    default: {
      const Vec3 polar(near[0], 90 - near[2], near[1]);
      const Vec3 a =
          near[0] < 0 ? Vec3(sphere(-p, polar).cwiseProduct(Vec3(-1, 1, 1))) : sphere(p, polar);
      return {a[0], a[2], 90 - a[1]};
    }
  }
}

Vec3 CoordinateFrame::rounding(const Vec3& position, double length) const {
  const Vec3 p = axes.transpose() * (position - origin);
  length += 16 * kEps * (position.cwiseAbs().maxCoeff() + origin.cwiseAbs().maxCoeff() + p.norm());
  const auto angle = [&](double arm) {
    return std::min(360., length / (kDegree * std::max(arm, 1e-300)) + 360 * kEps);
  };
  const double around = angle(std::hypot(p.x(), p.y())), polar = angle(p.norm());
  switch (kind) {
    case Kind::Rectangular:
      return Vec3::Constant(length);
    case Kind::Cylindrical:
      return {length, around, length};
    case Kind::Spherical:
      return {length, polar, around};
    default:
      return {length, around, polar};
  }
}

const CoordinateFrame& CoordinateFrameResolver::of(int system) {
  const CoordinateSystemDefinition& plan = systems_.plans[system];
  if (state_[system] == 2) return frames_[system];
  const std::string name = "coordinate system " + std::to_string(plan.label);
  if (!plan.unsupported_name.empty())
    file_.fail(plan.where, "found nodes in " + name + ", a " + plan.unsupported_name +
                               ", expected rectangular, cylindrical or spherical systems");
  if (state_[system] == 1) file_.fail(plan.where, "found " + name + ", which is defined by itself");
  if (depth_ > kDeepestSystem)
    file_.fail(plan.where, "found more than " + std::to_string(kDeepestSystem) +
                               " coordinate systems that are defined by one another");
  state_[system] = 1;
  ++depth_;
  frames_[system] = make(plan);
  --depth_;
  state_[system] = 2;
  return frames_[system];
}

CoordinateFrame CoordinateFrameResolver::make(const CoordinateSystemDefinition& plan) {
  if (plan.given) return *plan.given;
  std::array<Vec3, 3> points = plan.points;
  for (int k = 0; k < 3; ++k) {
    if (plan.nodes[k] >= 0)
      points[k] = position_(plan.nodes[k]);
    else if (plan.in >= 0)
      points[k] = of(plan.in).position(plan.points[k]);
  }
  CoordinateFrame frame{plan.kind, points[0], {}};
  const Vec3 z = points[1] - points[0], y = z.cross(points[2] - points[0]);
  const double length = z.norm(), area = y.norm();
  if (!(area > 1e-12 * length * (points[2] - points[0]).norm()))
    file_.fail(plan.where, "found coordinate system " + std::to_string(plan.label) +
                               " whose three points lie on a line");
  frame.axes.col(2) = z / length;
  frame.axes.col(1) = y / area;
  frame.axes.col(0) = frame.axes.col(1).cross(frame.axes.col(2));
  return frame;
}

}  // namespace batten
