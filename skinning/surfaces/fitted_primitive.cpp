// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/fitted_primitive.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"

namespace batten {
namespace {

using ShapeKind = FittedPrimitive::Kind;

constexpr double kMinNormalSpreadDeg =
    3;  ///< spread of the normals; a flatter patch fits any large radius
constexpr double kMinTorusNormalSpreadDeg =
    30;  ///< a patch of 10° with two curvatures is a torus within 4e-5 of its size
constexpr double kMinRelief =
    20;  ///< deviation from the plane over that from the primitive; radius to about 5 %
constexpr double kMaxNormalDeg = 1;  ///< RMS angle between the normals of surface and primitive
constexpr double kMaxRadius =
    1e4;  ///< of the patch size; beyond it, sag and rounding errors are similar
constexpr double kBetterFitRatio =
    5;  ///< ratio of deviations at which a less simple primitive is preferred
constexpr double kRounding = 1e-6;    ///< of the patch size; smaller deviations are not compared
constexpr size_t kFitSamples = 2000;  ///< fits take every k-th sample only; deviations take all

/// Samples in normalised coordinates: the centroid is the origin, the RMS distance from it is 1.
struct PrimitiveSamples {
  std::vector<Vec3> p, n;      // positions; normals, zero if undefined
  std::vector<size_t> fitted;  // samples with a normal, thinned out
  Vec3 mean_normal = Vec3::Zero();

  /// Σ over the fitted samples.
  template <class Value, class Function>
  Value sum(Value zero, const Function& value) const {
    for (const size_t i : fitted) zero += value(p[i], n[i]);
    return zero;
  }
  double count() const { return static_cast<double>(fitted.size()); }
};

/// Opening angle in degrees of the cone about the mean normal that contains 99 % of the normals.
double normal_spread_deg(const PrimitiveSamples& s) {
  if (!(s.mean_normal.norm() > 1e-6)) return 180;
  const Vec3 mean = s.mean_normal.normalized();
  std::vector<double> cosines;
  for (const size_t i : s.fitted) cosines.push_back(mean.dot(s.n[i]));
  const auto most = cosines.begin() + static_cast<long>(cosines.size() / 100);
  std::nth_element(cosines.begin(), most, cosines.end());
  return 2 * std::acos(std::clamp(*most, -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// Two unit vectors perpendicular to a unit vector and to each other.
std::array<Vec3, 2> across(const Vec3& axis) {
  const Vec3 e = axis.unitOrthogonal();
  return {e, axis.cross(e)};
}

/// Cylindrical coordinates of a point about the axis of a primitive.
struct AxisPoint {
  Vec3 out;       // radial unit vector
  double rho, h;  // distance from the axis, height along it
};
AxisPoint from_axis(const FittedPrimitive& s, const Vec3& p) {
  const Vec3 q = p - s.origin;
  const double h = q.dot(s.axis);
  const Vec3 off = q - h * s.axis;
  const double rho = off.norm();
  return {rho > 0 ? Vec3(off / rho) : Vec3(s.axis.unitOrthogonal()), rho, h};
}

using Parameters =
    Eigen::Matrix<double, 8,
                  1>;  // centre, rotation of the axis about across(), radius, major radius, angle

/// Signed distance of p and its derivatives with respect to the parameters.
double distance_and_slopes(const FittedPrimitive& s, const Vec3& p, Parameters& slopes) {
  slopes.setZero();
  Vec3 n = s.axis;
  double by_rotation = 0, distance = 0;  // derivative by a rotation of the axis towards `out`
  const AxisPoint at = from_axis(s, p);
  switch (s.kind) {
    case ShapeKind::Cylinder:
      n = at.out;
      by_rotation = -at.h;
      distance = at.rho - s.radius;
      slopes[5] = -1;
      break;
    case ShapeKind::Sphere:
      distance = (p - s.origin).norm() - s.radius;
      n = (p - s.origin).normalized();
      slopes[5] = -1;
      break;
    case ShapeKind::Cone: {
      const double c = std::cos(s.half_angle), w = std::sin(s.half_angle);
      n = c * at.out - w * s.axis;
      by_rotation = -(at.h * c + at.rho * w);
      distance = at.rho * c - at.h * w;
      slopes[7] = -at.rho * w - at.h * c;
      break;
    }
    case ShapeKind::Torus: {
      const double g = std::max(std::hypot(at.rho - s.major_radius, at.h), 1e-12);
      n = ((at.rho - s.major_radius) * at.out + at.h * s.axis) / g;
      by_rotation = at.h * s.major_radius / g;
      distance = g - s.radius;
      slopes[5] = -1;
      slopes[6] = -(at.rho - s.major_radius) / g;
      break;
    }
    default:
      distance = (p - s.origin).dot(s.axis);
      by_rotation = 0;
  }
  slopes.head<3>() = -n;
  const auto [e, f] = across(s.axis);
  slopes[3] = by_rotation * at.out.dot(e);
  slopes[4] = by_rotation * at.out.dot(f);
  return distance;
}

FittedPrimitive stepped(FittedPrimitive s, const Parameters& step) {
  const auto [e, f] = across(s.axis);
  s.origin += step.head<3>();
  s.axis = (s.axis + step[3] * e + step[4] * f).normalized();
  s.radius += step[5];
  s.major_radius += step[6];
  s.half_angle += step[7];
  return s;
}

double sum_of_squares(const FittedPrimitive& s, const PrimitiveSamples& samples) {
  return samples.sum(0.0, [&](const Vec3& p, const Vec3&) {
    const double d = s.distance(p);
    return d * d;
  });
}

bool sensible(const FittedPrimitive& s) {
  constexpr double kMinAngle = 1e-3, kRing = 1.001;
  const double size = std::max(s.radius, s.major_radius);
  if (!s.origin.allFinite() || !s.axis.allFinite() || !(size <= kMaxRadius)) return false;
  if (s.kind == ShapeKind::Cone)
    return s.half_angle > kMinAngle && s.half_angle < std::numbers::pi / 2 - kMinAngle &&
           s.origin.norm() <= kMaxRadius;
  if (s.kind == ShapeKind::Torus) return s.radius > 0 && s.major_radius > kRing * s.radius;
  return s.radius > 0;
}

/// Minimises the sum of squared distances by Levenberg–Marquardt.
void minimise(FittedPrimitive& s, const PrimitiveSamples& samples) {
  constexpr int kMaxSteps = 30;
  double lambda = 1e-6, error = sum_of_squares(s, samples);
  for (int i = 0; i < kMaxSteps && sensible(s); ++i) {
    Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
    Parameters b = Parameters::Zero(), slopes;
    for (const size_t k : samples.fitted) {
      const double d = distance_and_slopes(s, samples.p[k], slopes);
      A.selfadjointView<Eigen::Lower>().rankUpdate(slopes);
      b += d * slopes;
    }
    A.triangularView<Eigen::StrictlyUpper>() = A.transpose();
    bool better = false;
    for (int tries = 0; tries < 6 && !better; ++tries, lambda *= 10) {
      // Parameters that a kind does not have, and shifts along the axis, have zero derivatives and
      // stay constant.
      Eigen::Matrix<double, 8, 8> damped = A;
      damped.diagonal() += lambda * A.diagonal();
      damped.diagonal().array() += 1e-12 * samples.count();
      const FittedPrimitive next = stepped(s, solve_symmetric(damped, -b));
      const double found = sum_of_squares(next, samples);
      if (!(found < error)) continue;
      better = true;
      const bool settled = error - found <= 1e-6 * error;
      s = next;
      error = found;
      lambda = std::max(1e-2 * lambda, 1e-14);
      if (settled) return;
    }
    if (!better) return;
  }
}

/// R and c that minimise Σ |p - R n - c|², in any dimension.
template <class Vector>
std::pair<double, Vector> circle_from_normals(const std::vector<Vector>& p,
                                              const std::vector<Vector>& n) {
  const double count = static_cast<double>(p.size());
  Vector mean_p = Vector::Zero(), mean_n = Vector::Zero();
  for (size_t i = 0; i < p.size(); ++i) {
    mean_p += p[i] / count;
    mean_n += n[i] / count;
  }
  double over = 0, under = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    over += (p[i] - mean_p).dot(n[i] - mean_n);
    under += (n[i] - mean_n).squaredNorm();
  }
  const double radius = over / under;
  return {radius, mean_p - radius * mean_n};
}

Mat3 normal_moments(const PrimitiveSamples& s, const Vec3& about) {
  return s.sum(Mat3(Mat3::Zero()), [&](const Vec3&, const Vec3& n) -> Mat3 {
    return (n - about) * (n - about).transpose();
  });
}

Vec3 least_direction(const Mat3& A) { return symmetric_eigen(A).vectors.col(0); }

FittedPrimitive plane_of(const PrimitiveSamples& s) {
  FittedPrimitive shape;
  shape.kind = ShapeKind::Plane;
  for (const Vec3& p : s.p) shape.origin += p / static_cast<double>(s.p.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : s.p) spread += (p - shape.origin) * (p - shape.origin).transpose();
  shape.axis = least_direction(spread);
  if (shape.axis.dot(s.mean_normal) < 0) shape.axis = -shape.axis;
  return shape;
}

FittedPrimitive cylinder_of(const PrimitiveSamples& s) {
  FittedPrimitive shape;
  shape.kind = ShapeKind::Cylinder;
  shape.axis = least_direction(normal_moments(s, Vec3::Zero()));
  const auto [e, f] = across(shape.axis);
  std::vector<Vec2> p, n;
  for (const size_t i : s.fitted) {
    p.emplace_back(e.dot(s.p[i]), f.dot(s.p[i]));
    n.emplace_back(e.dot(s.n[i]), f.dot(s.n[i]));
  }
  const auto [radius, centre] = circle_from_normals(p, n);
  shape.radius = std::abs(radius);
  shape.origin = centre.x() * e + centre.y() * f;
  return shape;
}

FittedPrimitive sphere_of(const PrimitiveSamples& s) {
  FittedPrimitive shape;
  shape.kind = ShapeKind::Sphere;
  std::vector<Vec3> p, n;
  for (const size_t i : s.fitted) {
    p.push_back(s.p[i]);
    n.push_back(s.n[i]);
  }
  const auto [radius, centre] = circle_from_normals(p, n);
  shape.radius = std::abs(radius);
  shape.origin = centre;
  return shape;
}

FittedPrimitive cone_of(const PrimitiveSamples& s) {
  FittedPrimitive shape;
  shape.kind = ShapeKind::Cone;
  shape.axis = least_direction(normal_moments(s, s.mean_normal));
  const Vec3 b =
      s.sum(Vec3(Vec3::Zero()), [](const Vec3& p, const Vec3& n) -> Vec3 { return n.dot(p) * n; });
  shape.origin = least_squares(normal_moments(s, Vec3::Zero()), b);
  if (shape.origin.dot(shape.axis) > 0)
    shape.axis = -shape.axis;  // the centroid of the samples is 0
  shape.half_angle = std::asin(std::min(std::abs(s.mean_normal.dot(shape.axis)), 1.0));
  return shape;
}

// Axis that meets all normal lines: with lines (n, m = p × n) and the axis (a, b), n·b + m·a = 0
// and |a| = 1.
FittedPrimitive torus_of(const PrimitiveSamples& s) {
  FittedPrimitive shape;
  shape.kind = ShapeKind::Torus;
  Mat3 nn = Mat3::Zero(), nm = Mat3::Zero(), mm = Mat3::Zero();
  for (const size_t i : s.fitted) {
    const Vec3 &n = s.n[i], m = s.p[i].cross(n);
    nn += n * n.transpose();
    nm += n * m.transpose();
    mm += m * m.transpose();
  }
  const Mat3 solved = least_squares(nn, nm);
  const Vec3 a = least_direction(mm - nm.transpose() * solved);
  shape.axis = a;
  shape.origin = a.cross(Vec3(-solved * a));
  std::vector<Vec2> p, n;
  for (const size_t i : s.fitted) {
    const AxisPoint at = from_axis(shape, s.p[i]);
    p.emplace_back(at.rho, at.h);
    n.emplace_back(at.out.dot(s.n[i]), a.dot(s.n[i]));
  }
  const auto [radius, centre] = circle_from_normals(p, n);
  shape.radius = std::abs(radius);
  shape.major_radius = std::abs(centre.x());
  shape.origin += centre.y() * a;
  return shape;
}

/// The number with the fewest decimals within `error` of a length.
double shortest_decimal(double length, double error) {
  if (!(error > 0)) return length;
  const double step = std::pow(10, std::floor(std::log10(2 * error)));
  for (const double coarse : {10 * step, 5 * step, 2 * step, step}) {
    // Use quotients for negative powers of ten: 20.3, not 203 · 0.1.
    const double inverse = std::round(1 / coarse);
    const double rounded = coarse < 1 && inverse > 0 ? std::round(length * inverse) / inverse
                                                     : std::round(length / coarse) * coarse;
    if (rounded > 0 && std::abs(rounded - length) <= error) return rounded;
  }
  return length;
}

double largest_distance(const FittedPrimitive& s, const PrimitiveSamples& samples) {
  double most = 0;
  for (const Vec3& p : samples.p) {
    const double d = std::abs(s.distance(p));
    most = std::isfinite(d) ? std::max(most, d) : std::numeric_limits<double>::infinity();
  }
  return most;
}

/// RMS angle in degrees between the normals of samples and primitive, over the best 98 % (a surface
/// may be singular in a corner).
double normal_deg(const FittedPrimitive& s, const PrimitiveSamples& samples) {
  std::vector<double> squares;
  for (const size_t i : samples.fitted) {
    const Vec3 n = s.normal(samples.p[i]);
    const double angle = std::atan2(n.cross(samples.n[i]).norm(), std::abs(n.dot(samples.n[i])));
    squares.push_back(angle * angle);
  }
  const size_t counted = squares.size() - squares.size() / 50;
  std::nth_element(squares.begin(), squares.begin() + static_cast<long>(counted) - 1,
                   squares.end());
  double sum = 0;
  for (size_t i = 0; i < counted; ++i) sum += squares[i];
  return std::sqrt(sum / static_cast<double>(counted)) * 180 / std::numbers::pi;
}

FittedPrimitive simplest_primitive(const PrimitiveSamples& samples, double tolerance) {
  FittedPrimitive plane = plane_of(samples);
  plane.deviation = largest_distance(plane, samples);
  if (plane.deviation <= tolerance && normal_deg(plane, samples) <= kMaxNormalDeg) return plane;
  const double normal_spread = normal_spread_deg(samples);
  if (normal_spread < kMinNormalSpreadDeg) return {};
  const auto fitted = [&](FittedPrimitive shape) {
    minimise(shape, samples);
    shape.deviation = sensible(shape) ? largest_distance(shape, samples)
                                      : std::numeric_limits<double>::infinity();
    const bool determined = kMinRelief * shape.deviation <= plane.deviation;
    if (!(shape.deviation <= tolerance) || !determined ||
        normal_deg(shape, samples) > kMaxNormalDeg)
      shape.kind = ShapeKind::Free;
    return shape;
  };
  std::vector<FittedPrimitive> shapes = {fitted(cylinder_of(samples)), fitted(sphere_of(samples))};
  if (shapes[1].deviation < shapes[0].deviation) std::swap(shapes[0], shapes[1]);
  shapes.push_back(fitted(cone_of(samples)));
  if (normal_spread >= kMinTorusNormalSpreadDeg) shapes.push_back(fitted(torus_of(samples)));
  std::erase_if(shapes, [](const FittedPrimitive& shape) { return shape.kind == ShapeKind::Free; });
  // A narrow band of a cone also fits a sphere within the tolerance, but fits its own cone much
  // better.
  FittedPrimitive best;
  for (const FittedPrimitive& shape : shapes)
    if (best.kind == ShapeKind::Free ||
        (best.deviation > kRounding && kBetterFitRatio * shape.deviation < best.deviation))
      best = shape;
  return best;
}

/// Rounds radii as a designer would specify them: to the fewest decimals within the deviation, if
/// the surface then is still within the tolerance. (The radius of a cone is that of its end.)
void round_radii(FittedPrimitive& s, const Points& positions, double tolerance) {
  if (s.kind == ShapeKind::Plane || s.kind == ShapeKind::Cone) return;
  FittedPrimitive rounded = s;
  rounded.radius = shortest_decimal(s.radius, s.deviation);
  if (s.kind == ShapeKind::Torus)
    rounded.major_radius = shortest_decimal(s.major_radius, s.deviation);
  rounded.deviation = 0;
  for (long i = 0; i < positions.rows(); ++i)
    rounded.deviation =
        std::max(rounded.deviation, std::abs(rounded.distance(positions.row(i).transpose())));
  if (rounded.deviation <= tolerance) s = rounded;
}

/// Directs the axis so that its largest component is positive: equal surfaces get equal axes. Axes
/// of cones and planes already have a direction.
void canonicalize_axis(FittedPrimitive& s) {
  if (s.kind == ShapeKind::Plane || s.kind == ShapeKind::Cone) return;
  long largest = 0;
  s.axis.cwiseAbs().maxCoeff(&largest);
  if (s.axis[largest] < 0) s.axis = -s.axis;
}

}  // namespace

double FittedPrimitive::distance(const Vec3& p) const {
  const AxisPoint at = from_axis(*this, p);
  switch (kind) {
    case Kind::Cylinder:
      return at.rho - radius;
    case Kind::Sphere:
      return (p - origin).norm() - radius;
    case Kind::Cone:
      return at.rho * std::cos(half_angle) - at.h * std::sin(half_angle);
    case Kind::Torus:
      return std::hypot(at.rho - major_radius, at.h) - radius;
    default:
      return at.h;
  }
}

Vec3 FittedPrimitive::normal(const Vec3& p) const {
  const AxisPoint at = from_axis(*this, p);
  switch (kind) {
    case Kind::Cylinder:
      return at.out;
    case Kind::Sphere:
      return (p - origin).normalized();
    case Kind::Cone:
      return std::cos(half_angle) * at.out - std::sin(half_angle) * axis;
    case Kind::Torus:
      return ((at.rho - major_radius) * at.out + at.h * axis).normalized();
    default:
      return axis;
  }
}

const char* primitive_name(FittedPrimitive::Kind kind) {
  switch (kind) {
    case ShapeKind::Plane:
      return "plane";
    case ShapeKind::Cylinder:
      return "cylinder";
    case ShapeKind::Sphere:
      return "sphere";
    case ShapeKind::Cone:
      return "cone";
    case ShapeKind::Torus:
      return "torus";
    default:
      return "";
  }
}

FittedPrimitive fit_primitive(const Points& positions, const Points& normals, double tolerance) {
  const long count = positions.rows();
  constexpr long kFewest = 12;
  if (count < kFewest || !positions.allFinite()) return {};
  const Vec3 centroid = positions.colwise().mean().transpose();
  const double size =
      std::sqrt((positions.rowwise() - centroid.transpose()).rowwise().squaredNorm().mean());
  if (!(size > 0)) return {};
  PrimitiveSamples samples;
  std::vector<size_t> with_normal;
  for (long i = 0; i < count; ++i) {
    samples.p.emplace_back((positions.row(i).transpose() - centroid) / size);
    samples.n.emplace_back(normals.row(i).transpose());
    if (samples.n.back().squaredNorm() > 0.5) with_normal.push_back(static_cast<size_t>(i));
  }
  if (isize(with_normal) < kFewest) return {};
  const size_t step = (with_normal.size() + kFitSamples - 1) / kFitSamples;
  for (size_t i = 0; i < with_normal.size(); i += step) samples.fitted.push_back(with_normal[i]);
  samples.mean_normal = samples.sum(Vec3(Vec3::Zero()), [](const Vec3&, const Vec3& n) {
    return n;
  }) / samples.count();
  FittedPrimitive shape = simplest_primitive(samples, tolerance / size);
  if (shape.kind == ShapeKind::Free) return {};
  // The point of the axis that is closest to the centroid of the surface.
  if (shape.kind == ShapeKind::Cylinder) shape.origin -= shape.origin.dot(shape.axis) * shape.axis;
  if (shape.kind == ShapeKind::Cone)
    for (const Vec3& p : samples.p) shape.radius = std::max(shape.radius, from_axis(shape, p).rho);
  shape.origin = centroid + size * shape.origin;
  shape.radius *= size;
  shape.major_radius *= size;
  shape.deviation *= size;
  canonicalize_axis(shape);
  round_radii(shape, positions, tolerance);
  return shape;
}

double primitive_tolerance(const SkinnedRegion& region, double model_size) {
  constexpr double kOfModel = 1e-4, kOfRegion = 5e-4;
  return std::min(kOfModel * model_size, kOfRegion * region.size);
}

FittedPrimitive fit_primitive(const SkinnedRegion& region, double tolerance) {
  const Surface& surface = region.surface;
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  std::vector<Vec3> x, n;
  const auto add = [&](const Location& where) {
    const SurfaceJet jet = surface.jet(where);
    // Normals are undefined at a singular point.
    const bool regular = jet.area_vector().norm() > 1e-3 * jet.x_u.norm() * jet.x_v.norm();
    x.push_back(jet.x);
    n.push_back(regular ? jet.normal() : Vec3(Vec3::Zero()));
  };
  constexpr double kNear = 2.0 / 3, kFar = 1.0 / 6;
  const std::array<Vec3, 4> points{Vec3::Constant(1.0 / 3), Vec3(kNear, kFar, kFar),
                                   Vec3(kFar, kNear, kFar), Vec3(kFar, kFar, kNear)};
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<2048>(t);
    const auto side = trim ? trim->side(t) : Trim::Side::Inside;
    if (side == Trim::Side::Outside) continue;
    for (const Vec3& L : points)
      if (side == Trim::Side::Inside || trim->loops().contains(mesh.shape(t).point(L))) add({t, L});
  }
  // Add vertices, because they reach the boundary.
  std::vector<char> done(static_cast<size_t>(mesh.vertex_count()), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.triangles()[static_cast<size_t>(t)][static_cast<size_t>(k)];
      if ((trim && trim->side(t) != Trim::Side::Inside) || done[static_cast<size_t>(vertex)])
        continue;
      done[static_cast<size_t>(vertex)] = 1;
      x.emplace_back(surface.dofs().row(surface.dof_map().vertex(vertex)).transpose());
      n.emplace_back(Vec3::Zero());
    }
  Points positions(isize(x), 3), normals(isize(x), 3);
  for (int i = 0; i < isize(x); ++i) {
    positions.row(i) = x[static_cast<size_t>(i)];
    normals.row(i) = n[static_cast<size_t>(i)];
  }
  return fit_primitive(positions, normals, tolerance);
}

}  // namespace batten
