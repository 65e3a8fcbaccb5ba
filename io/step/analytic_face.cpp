// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/analytic_face.h"

#include <Eigen/Geometry>
#include <Geom_BSplineCurve.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Ax3.hxx>
#include <numbers>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/bspline.h"
#include "batten/fem/curves/cubic.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/trim.h"
#include "batten/io/cad/cad_primitive.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

using Closing = AnalyticFace::Closing;
using ShapeKind = FittedPrimitive::Kind;
using std::numbers::pi;

constexpr double kPoleMargin = 5 * pi / 180;  ///< least angle of a pole from the boundary, radians
/// Least angle of a seam from a patch that does not close.
constexpr double kSeamMargin = 2 * pi / 180;
/// Relative to the face's size: a seam this close to a vertex starts at the vertex.
constexpr double kOneVertex = 1e-7;
constexpr double kShortEdge = 0.02;  ///< least fraction of a boundary circle that a seam cuts off
constexpr int kSamplesPerSegment = 64;  ///< along a boundary segment

/// Sample points of a loop, in its direction.
std::vector<Vec3> loop_points(const FaceLoop& loop) {
  std::vector<Vec3> points;
  for (const FaceBoundarySegment& s : loop)
    for (int i = 0; i < kSamplesPerSegment; ++i)
      points.push_back(s.curve.evaluate(s.curve.start() + (s.curve.end() - s.curve.start()) * i /
                                                              kSamplesPerSegment));
  return points;
}

std::vector<Vec3> inner_points(const Surface& surface) {
  std::vector<Vec3> points;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    if (!surface.trim() || surface.trim()->side(t) == Trim::Side::Inside)
      points.push_back(surface.position({t, Vec3::Constant(1.0 / 3)}));
  return points;
}

/// The winding numbers of a closed polyline in u and v.
Eigen::Vector2i winding_of(const AnalyticSurface& surface, const std::vector<Vec3>& points) {
  const Vec2 begin = surface.parameters(points.front(), Vec2::Zero());
  Vec2 uv = begin;
  for (const Vec3& p : points) uv = surface.parameters(p, uv);
  uv = surface.parameters(points.front(), uv);
  Eigen::Vector2i winding = Eigen::Vector2i::Zero();
  for (const int k : {0, 1})
    if (surface.periods()[k] > 0)
      winding[k] = static_cast<int>(std::lround((uv[k] - begin[k]) / surface.periods()[k]));
  return winding;
}

/// The vector area of a loop: ½ ∮ (x - c) × dx.
Vec3 loop_area(const std::vector<Vec3>& points) {
  const Vec3 c = points.front();
  Vec3 area = Vec3::Zero();
  for (size_t i = 0; i < points.size(); ++i)
    area += (points[i] - c).cross(points[(i + 1) % points.size()] - c) / 2;
  return area;
}

class AnalyticPlanner {
 public:
  AnalyticPlanner(const SkinnedRegion& region, const FittedPrimitive& shape, StepPlan& plan)
      : plan_(plan),
        shape_(shape),
        boundary_(region, &plan, FaceBoundary::AnnulusBoundary::Whole),
        inner_(inner_points(region.surface)) {
    for (const FaceLoop& loop : boundary_.loops) {
      loops_.push_back(loop_points(loop));
      all_.insert(all_.end(), loops_.back().begin(), loops_.back().end());
    }
    all_.insert(all_.end(), inner_.begin(), inner_.end());
    Box3 box;
    for (const Vec3& p : all_) box.extend(p);
    size_ = box.diagonal().norm();
    middle_ = box.center();
    int out = 0;
    const Surface& surface = region.surface;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      if (surface.trim() && surface.trim()->side(t) != Trim::Side::Inside) continue;
      const Location where{t, Vec3::Constant(1.0 / 3)};
      out += surface.area_vector(where).dot(shape.normal(surface.position(where))) > 0 ? 1 : -1;
    }
    flipped_ = out < 0;
  }

  std::optional<AnalyticFace> face() {
    if (inner_.empty() || has_two_sided_line()) return std::nullopt;
    switch (shape_.kind) {
      case ShapeKind::Plane:
        return open_face(Vec3::UnitX());
      case ShapeKind::Sphere: {
        if (auto found = open_sphere()) return found;
        for (const std::vector<Vec3>& loop : loops_) {
          shape_.axis = loop_area(loop).normalized();
          if (auto found = closed_face()) return found;
        }
        return std::nullopt;
      }
      default:
        if (auto found = open_face(-mean_out())) return found;
        return closed_face();
    }
  }

 private:
  // A curve with the model face on both sides would become two coincident edges.
  bool has_two_sided_line() const {
    std::map<std::string, int> uses;
    for (const FaceLoop& loop : boundary_.loops)
      for (const FaceBoundarySegment& s : loop)
        if (++uses[s.line + " " +
                   std::to_string(std::min(s.line_parameter(s.curve.start()),
                                           s.line_parameter(s.curve.end())))] > 1)
          return true;
    return false;
  }

  Vec3 mean_out() const {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : all_) {
      const Vec3 q = p - shape_.origin;
      sum += (q - q.dot(shape_.axis) * shape_.axis).normalized();
    }
    return sum;
  }

  AnalyticFace made(const Vec3& reference) const {
    AnalyticFace face{
        AnalyticSurface(shape_, reference, middle_), Closing::None, 0, flipped_, Vec2::Zero(),
        std::vector<int>(loops_.size(), 0)};
    return face;
  }

  /// A face without winding loops; u = 0 is opposite to its middle.
  std::optional<AnalyticFace> open_face(const Vec3& reference) const {
    if (!(reference.norm() > 0)) return std::nullopt;
    AnalyticFace face = made(reference);
    const Vec2 periods = face.surface.periods();
    for (const std::vector<Vec3>& loop : loops_)
      if (!winding_of(face.surface, loop).isZero()) return std::nullopt;
    if (periods.x() <= 0) return face;
    face.near.x() = pi;
    double around = 0, ahead = 0;  // components of the mean direction in v
    for (const Vec3& p : all_) {
      const Vec2 uv = face.surface.parameters(p, face.near);
      if (uv.x() < kSeamMargin || uv.x() > 2 * pi - kSeamMargin) {
        if (!face.surface.singular(p, 1e-3 * size_)) return std::nullopt;
      }
      around += std::sin(uv.y());
      ahead += std::cos(uv.y());
    }
    if (periods.y() > 0) {
      face.near.y() = std::atan2(around, ahead);
      for (const Vec3& p : all_)
        if (std::abs(face.surface.parameters(p, face.near).y() - face.near.y()) > pi - kSeamMargin)
          return std::nullopt;
    }
    return face;
  }

  /// A patch of a sphere without a pole in it. Chooses the axis whose poles are farthest from the
  /// patch.
  std::optional<AnalyticFace> open_sphere() {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : all_) middle += (p - shape_.origin).normalized();
    if (!(middle.norm() > 1e-3 * static_cast<double>(all_.size()))) return std::nullopt;
    middle.normalize();
    const Vec3 e = middle.unitOrthogonal(), f = middle.cross(e);
    constexpr int directions = 24;
    double best = std::sin(2 * kPoleMargin);
    Vec3 axis = Vec3::Zero();
    for (int k = 0; k < directions; ++k) {
      const Vec3 a = std::cos(pi * k / directions) * e + std::sin(pi * k / directions) * f;
      double margin = 1;
      for (const Vec3& p : all_)
        margin = std::min(margin, a.cross((p - shape_.origin).normalized()).norm());
      if (margin <= best) continue;
      best = margin;
      axis = a;
    }
    if (axis.isZero()) return std::nullopt;
    const Vec3 before = shape_.axis;
    shape_.axis = axis;
    auto found = open_face(-middle);
    if (!found) shape_.axis = before;
    return found;
  }

  /// A face with a seam. Its boundary circles are the loops that wind around.
  std::optional<AnalyticFace> closed_face() {
    AnalyticFace face = made(shape_.axis.unitOrthogonal());
    std::vector<size_t> wound_loops;
    Eigen::Vector2i sum = Eigen::Vector2i::Zero();
    int wound = -1;
    for (size_t k = 0; k < loops_.size(); ++k) {
      const Eigen::Vector2i winding = winding_of(face.surface, loops_[k]);
      if (winding.isZero()) continue;
      if (winding.cwiseAbs().sum() != 1) return std::nullopt;
      const int along = winding[0] != 0 ? 0 : 1;
      if (wound >= 0 && wound != along) return std::nullopt;
      wound = along;
      wound_loops.push_back(k);
      face.winding[k] = winding[along];
      sum += winding;
    }
    if (wound_loops.size() == 2 && sum.isZero()) {
      face.closing = wound == 0 ? Closing::AroundU : Closing::AroundV;
      if (shape_.kind == ShapeKind::Sphere &&
          !(pole_distance(1) > kPoleMargin && pole_distance(-1) > kPoleMargin))
        return std::nullopt;
    } else if (wound_loops.size() == 1 && shape_.kind == ShapeKind::Sphere) {
      face.closing = Closing::Pole;
      // The face lies to the left of its loop: around the north pole, seen from outside.
      if ((flipped_ ? -1 : 1) * face.winding[wound_loops[0]] < 0) {
        shape_.axis = -shape_.axis;
        AnalyticFace turned = made(shape_.axis.unitOrthogonal());
        turned.closing = Closing::Pole;
        turned.winding = face.winding;
        turned.winding[wound_loops[0]] = -face.winding[wound_loops[0]];
        face = turned;
      }
      if (!(pole_distance(-1) > kPoleMargin)) return std::nullopt;
      for (const Vec3& p : loops_[wound_loops[0]])
        if (shape_.axis.cross((p - shape_.origin).normalized()).norm() < std::sin(kPoleMargin))
          return std::nullopt;
    } else {
      return std::nullopt;
    }
    return with_seam(std::move(face), wound_loops, wound);
  }

  /// The smallest angle between a pole and the points of the face.
  double pole_distance(int side) const {
    double least = pi;
    for (const Vec3& p : all_)
      least = std::min(
          least, std::acos(std::clamp(side * shape_.axis.dot((p - shape_.origin).normalized()),
                                      -1.0, 1.0)));
    return least;
  }

  struct Cut {
    const FaceBoundarySegment* segment;
    double t;
  };

  /// True if a boundary circle meets the seam properly: at one vertex (no cut), or at one point
  /// between vertices, which is added to `cuts`.
  bool meets(const AnalyticSurface& surface, int wound, const FaceLoop& rim, double seam,
             std::vector<Cut>& cuts) const {
    const auto angle = [&](const Vec3& p) {
      const double a = surface.parameters(p, Vec2::Zero())[wound] - seam;
      return a - 2 * pi * std::round(a / (2 * pi));
    };
    const auto lever = [&](const Vec3& p) {
      return wound == 1 ? shape_.radius : (p - shape_.origin).cross(shape_.axis).norm();
    };
    double length = 0;
    int vertices = 0;
    std::vector<Vec3> ends;
    for (const FaceBoundarySegment& s : rim) {
      ends.push_back(s.curve.position(0));
      length += s.curve.length();
      vertices += std::abs(angle(ends.back())) * lever(ends.back()) <= kOneVertex * size_;
    }
    if (vertices > 1) return false;
    std::vector<Cut> found;
    for (const FaceBoundarySegment& s : rim) {
      const double start = s.curve.start(), end = s.curve.end();
      const auto at = [&](double t) { return angle(s.curve.evaluate(t)); };
      double a = start, of_a = at(a);
      for (int i = 1; i <= kSamplesPerSegment; ++i) {
        double b = start + (end - start) * i / kSamplesPerSegment, of_b = at(b);
        const double next = b, of_next = of_b;
        if ((of_a < 0) != (of_b < 0) && std::abs(of_a) + std::abs(of_b) < pi) {
          for (int k = 0; k < 60; ++k) {
            const double c = (a + b) / 2, of_c = at(c);
            ((of_c < 0) == (of_a < 0) ? a : b) = c;
          }
          found.push_back({&s, (a + b) / 2});
        }
        a = next;
        of_a = of_next;
      }
    }
    std::erase_if(found, [&](const Cut& cut) {
      const Vec3 p = cut.segment->curve.evaluate(cut.t);
      return std::any_of(ends.begin(), ends.end(),
                         [&](const Vec3& q) { return (p - q).norm() <= 10 * kOneVertex * size_; });
    });
    if (vertices == 1) return found.empty();
    if (found.size() != 1) return false;
    const Vec3 p = found[0].segment->curve.evaluate(found[0].t);
    for (const Vec3& q : ends)
      if ((p - q).norm() < kShortEdge * length) return false;
    cuts.push_back(found[0]);
    return true;
  }

  bool crosses(const AnalyticSurface& surface, int wound, const std::vector<Vec3>& loop,
               double seam) const {
    double before = 0;
    for (size_t i = 0; i <= loop.size(); ++i) {
      const double a = surface.parameters(loop[i % loop.size()], Vec2::Zero())[wound] - seam;
      const double here = a - 2 * pi * std::round(a / (2 * pi));
      if (std::abs(here) < kSeamMargin) return true;
      if (i > 0 && (here < 0) != (before < 0) && std::abs(here) + std::abs(before) < pi)
        return true;
      before = here;
    }
    return false;
  }

  std::optional<AnalyticFace> with_seam(AnalyticFace face, const std::vector<size_t>& wound_loops,
                                        int wound) {
    std::vector<double> candidates;
    if (wound == 1) candidates.push_back(0);
    for (const size_t k : wound_loops)
      for (const FaceBoundarySegment& s : boundary_.loops[k])
        candidates.push_back(face.surface.parameters(s.curve.position(0), Vec2::Zero())[wound]);
    constexpr int candidate_count = 16;
    for (int k = 0; k < candidate_count; ++k) candidates.push_back(2 * pi * k / candidate_count);
    bool found = false;
    std::vector<Cut> fewest;
    for (const double seam : candidates) {
      std::vector<Cut> cuts;
      bool good = true;
      for (size_t k = 0; k < loops_.size() && good; ++k)
        good = std::count(wound_loops.begin(), wound_loops.end(), k) > 0
                   ? meets(face.surface, wound, boundary_.loops[k], seam, cuts)
                   : !crosses(face.surface, wound, loops_[k], seam);
      if (!good || (found && cuts.size() >= fewest.size())) continue;
      found = true;
      fewest = cuts;
      face.seam = seam;
      if (wound == 1) break;
    }
    if (!found) return std::nullopt;
    for (const Cut& cut : fewest) {
      std::vector<double>& of_line = plan_.lines.at(cut.segment->line).cuts;
      of_line.push_back(cut.segment->line_parameter(cut.t));
      std::sort(of_line.begin(), of_line.end());
    }
    if (wound == 0) {  // make the seam u = 0
      const Vec3 p = face.surface.position({face.seam, 0}) - shape_.origin;
      face.surface = AnalyticSurface(shape_, p - p.dot(shape_.axis) * shape_.axis, middle_);
      face.seam = 0;
      face.near = {pi, 0};
    } else {
      const Vec3 out = mean_out();
      face.surface = AnalyticSurface(shape_, -out, middle_);
      face.near = {pi, face.seam + pi};
      for (const Vec3& p : all_)
        if (const double u = face.surface.parameters(p, face.near).x();
            u < kSeamMargin || u > 2 * pi - kSeamMargin)
          return std::nullopt;
    }
    return face;
  }

  StepPlan& plan_;
  FittedPrimitive shape_;
  FaceBoundary boundary_;
  std::vector<Vec3> inner_, all_;
  std::vector<std::vector<Vec3>> loops_;
  double size_ = 0;
  Vec3 middle_ = Vec3::Zero();
  bool flipped_ = false;
};

}  // namespace

size_t AnalyticFace::seam_segment(const FaceLoop& loop) const {
  const int wound = closing == Closing::AroundV ? 1 : 0;
  size_t best = 0;
  double nearest = 2 * pi;
  for (size_t k = 0; k < loop.size(); ++k) {
    const double a = surface.parameters(loop[k].curve.position(0), Vec2::Zero())[wound] - seam;
    const double distance = std::abs(a - 2 * pi * std::round(a / (2 * pi)));
    if (distance >= nearest) continue;
    nearest = distance;
    best = k;
  }
  return best;
}

AnalyticFaces analytic_faces(StepPlan& plan, MeasuredShapes& shapes) {
  AnalyticFaces faces;
  for (const SkinnedRegion* region : plan.regions) {
    const auto shape = shapes.find(region);
    if (shape == shapes.end()) continue;
    if (auto face = AnalyticPlanner(*region, shape->second, plan).face())
      faces.emplace(region, std::move(*face));
    else
      shapes.erase(shape);
  }
  return faces;
}

namespace {

double nearest_period(double angle, double near) {
  constexpr double whole = 2 * std::numbers::pi;
  return angle + whole * std::round((near - angle) / whole);
}

/// A C1 cubic through points with given derivatives, as a B-spline with double knots.
Handle(Geom2d_BSplineCurve)
    hermite_spline(const std::vector<double>& t, const std::vector<Vec2>& uv,
                   const std::vector<Vec2>& slopes) {
  CubicSpline spline;
  spline.knots = t;
  spline.multiplicities.assign(t.size(), 2);
  spline.multiplicities.front() = spline.multiplicities.back() = 4;
  for (size_t i = 0; i < t.size(); ++i) {
    const double before = i > 0 ? t[i] - t[i - 1] : 0,
                 after = i + 1 < t.size() ? t[i + 1] - t[i] : 0;
    const Vec2 low = uv[i] - before / 3 * slopes[i], high = uv[i] + after / 3 * slopes[i];
    spline.poles.insert(spline.poles.end(), {{low.x(), low.y(), 0}, {high.x(), high.y(), 0}});
  }
  return to_flat_occ(spline);
}

}  // namespace

AnalyticSurface::AnalyticSurface(const FittedPrimitive& shape, const Vec3& reference,
                                 const Vec3& middle)
    : shape_(shape), origin_(shape.origin) {
  const Vec3& z = shape.axis;
  x_ = reference - reference.dot(z) * z;
  x_ = x_.norm() > 1e-9 * reference.norm() ? Vec3(x_.normalized()) : Vec3(z.unitOrthogonal());
  y_ = z.cross(x_);
  if (shape.kind == ShapeKind::Cone) {
    const double height = (middle - shape.origin).dot(z);
    origin_ += height * z;
    radius_ = height * std::tan(shape.half_angle);
  }
  if (shape.kind == ShapeKind::Cylinder) origin_ += (middle - shape.origin).dot(z) * z;
  const gp_Ax3 frame(to_occ(origin_), gp_Dir(z.x(), z.y(), z.z()), gp_Dir(x_.x(), x_.y(), x_.z()));
  switch (shape.kind) {
    case ShapeKind::Cylinder:
      geometry_ = new Geom_CylindricalSurface(frame, shape.radius);
      break;
    case ShapeKind::Sphere:
      geometry_ = new Geom_SphericalSurface(frame, shape.radius);
      break;
    case ShapeKind::Cone:
      geometry_ = new Geom_ConicalSurface(frame, shape.half_angle, radius_);
      break;
    case ShapeKind::Torus:
      geometry_ = new Geom_ToroidalSurface(frame, shape.major_radius, shape.radius);
      break;
    default:
      geometry_ = new Geom_Plane(frame);
  }
}

Vec2 AnalyticSurface::periods() const {
  constexpr double whole = 2 * std::numbers::pi;
  if (shape_.kind == ShapeKind::Plane) return {0, 0};
  return {whole, shape_.kind == ShapeKind::Torus ? whole : 0};
}

Vec2 AnalyticSurface::parameters(const Vec3& p, const Vec2& near) const {
  const Vec3 q = p - origin_;
  const double x = q.dot(x_), y = q.dot(y_), h = q.dot(shape_.axis);
  if (shape_.kind == ShapeKind::Plane) return {x, y};
  const double rho = std::hypot(x, y);
  constexpr double rounding = 1e-12;
  const bool on_axis = rho <= rounding * (shape_.radius + std::abs(h));
  const double u = on_axis ? near.x() : nearest_period(std::atan2(y, x), near.x());
  switch (shape_.kind) {
    case ShapeKind::Sphere:
      return {u, std::atan2(h, rho)};
    case ShapeKind::Cone:
      return {u, (rho - radius_) * std::sin(shape_.half_angle) + h * std::cos(shape_.half_angle)};
    case ShapeKind::Torus:
      return {u, nearest_period(std::atan2(h, rho - shape_.major_radius), near.y())};
    default:
      return {u, h};
  }
}

Vec3 AnalyticSurface::position(const Vec2& uv) const {
  return from_occ(geometry_->Value(uv.x(), uv.y()));
}

bool AnalyticSurface::singular(const Vec3& p, double distance) const {
  if (shape_.kind == ShapeKind::Cone) return (p - shape_.origin).norm() <= distance;
  return shape_.kind == ShapeKind::Sphere &&
         (p - shape_.origin).cross(shape_.axis).norm() <= distance;
}

// The derivative of parameters() along a curve; on the axis that of u is 0.
Vec2 AnalyticSurface::slopes(const Vec3& p, const Vec3& slope) const {
  const Vec3 q = p - origin_;
  const double x = q.dot(x_), y = q.dot(y_), h = q.dot(shape_.axis);
  const double dx = slope.dot(x_), dy = slope.dot(y_), dh = slope.dot(shape_.axis);
  if (shape_.kind == ShapeKind::Plane) return {dx, dy};
  const double rho = std::hypot(x, y);
  constexpr double beside = 1e-7;
  if (rho <= beside * (shape_.radius + std::abs(h))) {
    const double drho = std::hypot(dx, dy);
    if (shape_.kind == ShapeKind::Sphere) return {0, (h > 0 ? -1 : 1) * drho / shape_.radius};
    return {0, 0};
  }
  const double du = (x * dy - y * dx) / (rho * rho), drho = (x * dx + y * dy) / rho;
  switch (shape_.kind) {
    case ShapeKind::Sphere:
      return {du, (rho * dh - h * drho) / (rho * rho + h * h)};
    case ShapeKind::Cone:
      return {du, drho * std::sin(shape_.half_angle) + dh * std::cos(shape_.half_angle)};
    case ShapeKind::Torus: {
      const double s = rho - shape_.major_radius;
      return {du, (s * dh - h * drho) / (s * s + h * h)};
    }
    default:
      return {du, dh};
  }
}

Handle(Geom2d_BSplineCurve) AnalyticSurface::pcurve(const Geom_Curve& curve, double first,
                                                    double last, bool backwards, double tolerance,
                                                    Vec2& near) const {
  std::vector<double> t;
  if (const auto* spline = dynamic_cast<const Geom_BSplineCurve*>(&curve)) {
    for (int k = 1; k <= spline->NbKnots(); ++k) t.push_back(spline->Knot(k));
    std::erase_if(t, [&](double at) { return at <= first || at >= last; });
  }
  t.insert(t.begin(), first);
  t.push_back(last);
  // Steps of less than half a revolution, also on a circle given as one piece.
  constexpr int fewest = 8;
  const int pieces_each = (fewest + isize(t) - 2) / (isize(t) - 1);
  std::vector<double> split;
  for (size_t i = 0; i + 1 < t.size(); ++i)
    for (int k = 0; k < pieces_each; ++k)
      split.push_back(t[i] + (t[i + 1] - t[i]) * k / pieces_each);
  split.push_back(last);
  t = std::move(split);
  const auto at = [&](double parameter) { return from_occ(curve.Value(parameter)); };
  std::vector<Vec2> uv, d;
  const auto evaluate = [&] {
    uv.assign(t.size(), Vec2::Zero());
    d.assign(t.size(), Vec2::Zero());
    Vec2 before = near;
    // If the curve starts at a pole or apex, take u from a point slightly further along it.
    const double start = backwards ? last : first, end = backwards ? first : last;
    constexpr double little = 1e-4;
    const double apex = little * (shape_.radius + shape_.major_radius);
    if (singular(at(start), apex)) before = parameters(at(start + little * (end - start)), near);
    for (size_t k = 0; k < t.size(); ++k) {
      const size_t i = backwards ? t.size() - 1 - k : k;
      gp_Pnt p;
      gp_Vec slope;
      curve.D1(t[i], p, slope);
      const bool ends = k == 0 || k + 1 == t.size();
      uv[i] = parameters(from_occ(p), before);
      d[i] = slopes(from_occ(p), from_occ(slope.XYZ()));
      if (ends && singular(from_occ(p), apex)) {
        uv[i].x() = k == 0 ? before.x() : parameters(at(end + little * (start - end)), before).x();
        d[i].x() = 0;
      }
      before = uv[i];
    }
    return before;
  };
  Vec2 after = evaluate();
  constexpr int most_halvings = 6;
  for (int round = 0; round < most_halvings; ++round) {
    std::vector<double> finer;
    for (size_t i = 0; i + 1 < t.size(); ++i) {
      finer.push_back(t[i]);
      const double length = t[i + 1] - t[i];
      bool far = false;
      for (const double s : {0.25, 0.5, 0.75}) {
        const Vec2 cubic = hermite_value(uv[i], d[i], uv[i + 1], d[i + 1], length, s);
        const Vec2 exact = parameters(at(t[i] + s * length), cubic);
        far = far || (position(cubic) - position(exact)).norm() > tolerance;
      }
      if (far) finer.push_back(t[i] + length / 2);
    }
    finer.push_back(t.back());
    if (finer.size() == t.size()) break;
    t = std::move(finer);
    after = evaluate();
  }
  near = after;
  return hermite_spline(t, uv, d);
}

}  // namespace batten
