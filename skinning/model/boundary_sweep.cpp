// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/boundary_sweep.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

constexpr double kFlat = 1e-4;  // of the size: a boundary this flat counts as planar
// Of the squared mismatch: the level left by curves through points.
constexpr double kMismatchFloor = 1e-6;
constexpr double kMinWeight = 1e-3;  // of the largest weight: sweeps below it are skipped
constexpr double kRadians = std::numbers::pi / 180;
constexpr int kGrid = 8;         // samples of the map along each parameter
constexpr double kBeyond = 0.1;  // how far (s, t) may leave [0, 1]

std::vector<Vec3> samples_of(const std::vector<BoundarySide>& sides) {
  constexpr int kCount = 16;
  std::vector<Vec3> points;
  for (const BoundarySide& side : sides)
    for (int k = 0; k < kCount; ++k) points.push_back(side.at(k / double(kCount)).x);
  return points;
}

bool is_plane(const std::vector<Vec3>& points, double tolerance) {
  const PrincipalAxes axes = principal_axes(points);
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    return std::abs((p - axes.mean).dot(axes.axes.col(0))) <= tolerance;
  });
}

// The name of a line without the number of its segment: "rib" for "rib.3".
std::string without_piece_number(const std::string& name) {
  const size_t dot = name.find_last_of('.');
  const bool number = dot != std::string::npos && dot > 0 && dot + 1 < name.size() &&
                      name.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return number ? name.substr(0, dot) : name;
}

// Splits the outline of a region, in its direction, into sides at corners. If that gives more than
// four, corners inside of one line, such as those of a polyline, are ignored. A corner angle above
// the default is capped at it: it tells which kinks of one line's points are smooth, not which
// corners between lines are.
std::vector<BoundarySide> sides_of(const RegionLayout& region) {
  struct Piece {
    HermiteCurve curve, pcurve;
    Vec3 first, last;  // tangents at the ends
    std::string name;
  };
  std::vector<Piece> pieces;
  for (const BoundarySegment& of : region.boundary().front()) {
    const auto i = static_cast<size_t>(of.index);
    const bool aligned_line = of.kind == BoundarySegment::Kind::EdgeAligned;
    HermiteCurve curve =
        aligned_line ? region.edge_aligned()[i].fitted : region.embedded()[i].fitted;
    HermiteCurve pcurve = aligned_line
                              ? edge_aligned_pcurve(*region.mesh(), region.edge_aligned()[i])
                              : region.embedded()[i].pcurve;
    if (curve.closed()) return {};
    if (of.reversed) curve = curve.backwards(), pcurve = pcurve.backwards();
    const Vec3 first = curve.evaluate(curve.start(), 1), last = curve.evaluate(curve.end(), 1);
    pieces.push_back({std::move(curve), std::move(pcurve), first, last,
                      without_piece_number(aligned_line ? region.edge_aligned()[i].line.name
                                                        : region.embedded()[i].line.name)});
  }
  const size_t n = pieces.size();
  const double corner = std::min(region.corner_angle(), SkinOptions{}.corner_angle);
  std::vector<size_t> starts;  // curves that begin at a corner
  for (size_t i = 0; i < n; ++i)
    if (degrees_between(pieces[(i + n - 1) % n].last, pieces[i].first) > corner)
      starts.push_back(i);
  if (starts.size() > 4)
    std::erase_if(starts, [&](size_t i) { return pieces[(i + n - 1) % n].name == pieces[i].name; });
  std::vector<BoundarySide> sides(starts.size());
  for (size_t k = 0; k < starts.size(); ++k) {
    const size_t end = starts[(k + 1) % starts.size()];
    size_t i = starts[k];
    do {
      sides[k].add(pieces[i].curve, pieces[i].pcurve);
      i = (i + 1) % n;
    } while (i != end);
  }
  return sides;
}

}  // namespace

std::optional<BoundarySweep> BoundarySweep::of(const RegionLayout& region) {
  if (region.boundary().empty() || region.mesh()->period() > 0) return std::nullopt;
  std::vector<BoundarySide> sides = sides_of(region);
  if (sides.size() < 2 || sides.size() > 4) return std::nullopt;
  if (is_plane(samples_of(sides), kFlat * region.size())) return std::nullopt;
  BoundarySweep sweep(region, std::move(sides));
  if (!sweep.compute_weights()) return std::nullopt;
  sweep.use_projection();
  return sweep;
}

double BoundarySweep::mismatch() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Patch& patch : patches_)
    for (const auto* sweep : {&patch.along_t, &patch.along_s})
      if (*sweep) least = std::min(least, (*sweep)->mismatch());
  return least;
}

bool BoundarySweep::has_many_sides(const RegionLayout& region) {
  if (region.boundary().empty() || region.mesh()->period() > 0) return false;
  const std::vector<BoundarySide> sides = sides_of(region);
  return sides.size() > 4 && !is_plane(samples_of(sides), kFlat * region.size());
}

BoundarySweep::BoundarySweep(const RegionLayout& region, std::vector<BoundarySide> sides)
    : region_(&region), sides_(std::move(sides)) {
  const int n = isize(sides_);
  const auto corner = [&](int k) {
    const BoundarySide::Point p = sides_[static_cast<size_t>(k % n)].at(0);
    return Edge{-1, false, p.x, p.uv};
  };
  const auto side = [&](int k, bool backwards = false) { return Edge{k % n, backwards, {}, {}}; };
  if (n == 4) {
    add(side(0), side(2, true), side(3, true), side(1), true);
  } else if (n == 3) {
    for (int k = 0; k < 3; ++k) add(side(k, true), side(k + 2), side(k + 1), corner(k), false);
  } else {
    add(side(0), side(1, true), corner(0), corner(1), false);
  }
  Vec2 low = sides_[0].at(0).uv, high = low;
  for (const Patch& patch : patches_)
    for (const Vec2& uv : patch.uv) low = low.cwiseMin(uv), high = high.cwiseMax(uv);
  extent_ = (high - low).norm();
}

BoundarySide::Point BoundarySweep::point(const Edge& edge, double f) const {
  if (edge.side < 0) return {edge.x, Vec3::Zero(), edge.uv, Vec2::Zero()};
  BoundarySide::Point p = sides_[static_cast<size_t>(edge.side)].at(edge.backwards ? 1 - f : f);
  if (edge.backwards) p.x_f = -p.x_f, p.uv_f = -p.uv_f;
  return p;
}

void BoundarySweep::add(Edge bottom, Edge top, Edge left, Edge right, bool both) {
  Patch patch;
  patch.bottom = bottom, patch.top = top, patch.left = left, patch.right = right;
  const auto curve = [this](const Edge& edge) {
    return [this, &edge](double f) {
      const BoundarySide::Point p = point(edge, f);
      return Sweep::PointAndSlope{p.x, p.x_f};
    };
  };
  const auto b = curve(patch.bottom), t = curve(patch.top), l = curve(patch.left),
             r = curve(patch.right);
  patch.along_t.emplace(b, t, l, r);
  if (both) patch.along_s.emplace(l, r, b, t);
  for (const bool at_right : {false, true}) {
    if ((at_right ? right : left).side >= 0) continue;
    const double s = at_right ? 1 : 0, sign = at_right ? -1 : 1;
    Fan fan{sign * b(s).slope, sign * t(s).slope, 0};
    fan.angle = degrees_between(fan.bottom, fan.top) * kRadians;
    constexpr double least = 1 * kRadians, kWidest = 150 * kRadians;
    if (fan.angle > least && fan.angle < kWidest)
      (at_right ? patch.fan_right : patch.fan_left) = fan;
  }
  sample(patch);
  patches_.push_back(std::move(patch));
}

void BoundarySweep::sample(Patch& patch) const {
  patch.at.clear();
  patch.uv.clear();
  for (int i = 0; i <= kGrid; ++i)
    for (int j = 0; j <= kGrid; ++j) {
      patch.at.emplace_back(i / double(kGrid), j / double(kGrid));
      patch.uv.push_back(evaluate_map(patch, patch.at.back()).uv);
    }
}

// The affine map from space of which all sides' pcurves are images, if there is one.
std::optional<BoundarySweep::Projection> BoundarySweep::projection_of_sides() const {
  constexpr int kSamples = 16;  // per side
  const long n = kSamples * isize(sides_);
  MatX x(n, 3), uv(n, 2);
  for (long i = 0; i < n; ++i) {
    const BoundarySide::Point p =
        sides_[static_cast<size_t>(i / kSamples)].at((i % kSamples) / double(kSamples));
    x.row(i) = p.x;
    uv.row(i) = p.uv;
  }
  const Eigen::RowVector3d middle = x.colwise().mean();
  x.rowwise() -= middle;
  // Least squares of minimum norm: the normal of a plane boundary has no image.
  const Svd svd = thin_svd(x);
  MatX solution = MatX::Zero(3, 2);
  for (int k = 0; k < 3; ++k)
    if (svd.values[k] > 1e-6 * svd.values[0])
      solution += svd.V.col(k) * (svd.U.col(k).transpose() * uv) / svd.values[k];
  Projection found;
  found.linear = solution.transpose();
  const Vec2 mean = uv.colwise().mean();
  found.offset = mean - found.linear * middle.transpose();
  constexpr double kSameTolerance = 1e-7;
  const MatX miss = (x * found.linear.transpose()).rowwise() + mean.transpose() - uv;
  if (!(miss.cwiseAbs().maxCoeff() < kSameTolerance * extent_)) return std::nullopt;
  return found;
}

// True if the sweeps are inclined by less than 70 degrees to the plane of the map everywhere.
bool BoundarySweep::is_graph() const {
  constexpr double kSteepest = 0.34;
  const double scale =
      std::sqrt((projection_->linear * projection_->linear.transpose()).determinant());
  double sign = 0;
  for (const Patch& patch : patches_)
    for (int i = 0; i < kGrid; ++i)
      for (int j = 0; j < kGrid; ++j) {
        const PatchPoint here = evaluate_map(patch, {(i + 0.5) / kGrid, (j + 0.5) / kGrid});
        const Jet x = jet(patch, here);
        const double shadow = here.jacobian.determinant();
        const double area = scale * x.by_u.cross(x.by_v).norm();
        // The patches of a triangle have the same orientation.
        if (sign == 0) sign = shadow > 0 ? 1 : -1;
        if (!(sign * shadow > kSteepest * area)) return false;
      }
  return true;
}

void BoundarySweep::use_projection() {
  projection_ = projection_of_sides();
  if (projection_ && !is_graph()) projection_.reset();
  if (!projection_) return;
  for (Patch& patch : patches_) sample(patch);
}

// Sets the weights of all sweeps and drops patches without any. Returns false if none is left.
bool BoundarySweep::compute_weights() {
  double most = 0;
  const auto raw = [](const std::optional<Sweep>& sweep) {
    return sweep && std::isfinite(sweep->mismatch())
               ? 1 / (sweep->mismatch() * sweep->mismatch() + kMismatchFloor)
               : 0;
  };
  for (const Patch& patch : patches_)
    most = std::max({most, raw(patch.along_t), raw(patch.along_s)});
  double sum = 0;
  const auto left = [&](const std::optional<Sweep>& sweep) {
    const double weight = std::max(0.0, raw(sweep) - kMinWeight * most);
    sum += weight;
    return weight;
  };
  for (Patch& patch : patches_) {
    patch.weight_t = left(patch.along_t);
    patch.weight_s = left(patch.along_s);
  }
  for (Patch& patch : patches_) {
    patch.weight_t /= sum;
    patch.weight_s /= sum;
  }
  std::erase_if(patches_, [](const Patch& p) { return !(p.weight_t + p.weight_s > 0); });
  return !patches_.empty();
}

// Evaluates the map at (s, t): the Coons patch of the pcurves, or the projection of the sweeps.
BoundarySweep::PatchPoint BoundarySweep::evaluate_map(const Patch& patch, const Vec2& st) const {
  const double s = st[0], t = st[1];
  PatchPoint q{st, {}, {}, edges(patch, st)};
  if (projection_) {
    const Jet x = jet(patch, st, q.edges);
    q.uv = projection_->linear * x.x + projection_->offset;
    q.jacobian << projection_->linear * x.by_u, projection_->linear * x.by_v;
    return q;
  }
  const auto& [bottom, top, left, right] = q.edges;
  const Vec2 c00 = point(patch.left, 0).uv, c01 = point(patch.left, 1).uv,
             c10 = point(patch.right, 0).uv, c11 = point(patch.right, 1).uv;
  q.uv = (1 - t) * bottom.uv + t * top.uv + (1 - s) * left.uv + s * right.uv -
         ((1 - s) * ((1 - t) * c00 + t * c01) + s * ((1 - t) * c10 + t * c11));
  q.jacobian.col(0) = (1 - t) * bottom.uv_f + t * top.uv_f + right.uv - left.uv -
                      ((1 - t) * (c10 - c00) + t * (c11 - c01));
  q.jacobian.col(1) = top.uv - bottom.uv + (1 - s) * left.uv_f + s * right.uv_f -
                      ((1 - s) * (c01 - c00) + s * (c11 - c10));
  return q;
}

// A start value for inverting the map: the sample nearest to uv.
Vec2 BoundarySweep::start(const Patch& patch, const Vec2& uv) const {
  size_t nearest = 0;
  for (size_t i = 1; i < patch.uv.size(); ++i)
    if ((patch.uv[i] - uv).squaredNorm() < (patch.uv[nearest] - uv).squaredNorm()) nearest = i;
  Vec2 st = patch.at[nearest];
  // On an edge that is a corner all samples coincide: those next to it provide the direction.
  const bool at_left = patch.left.side < 0 && st[0] == 0,
             at_right = patch.right.side < 0 && st[0] == 1;
  if (at_left || at_right) {
    const double in = at_left ? 1.0 / kGrid : 1 - 1.0 / kGrid;
    double least = std::numeric_limits<double>::infinity();
    for (int j = 0; j <= kGrid; ++j) {
      const Vec2 beside = evaluate_map(patch, {in, j / double(kGrid)}).uv;
      const Vec2 corner = at_left ? patch.left.uv : patch.right.uv;
      const Vec2 direction = (beside - corner).normalized();
      const double off = (uv - corner - direction.dot(uv - corner) * direction).norm();
      if (off < least) least = off, st = {in, j / double(kGrid)};
    }
  }
  return st;
}

BoundarySweep::PatchPoint BoundarySweep::invert_map(const Patch& patch, const Vec2& uv) const {
  return invert_map(patch, uv, start(patch, uv));
}

// Inverts the map by damped Newton iterations: the (s, t) whose image is uv or, failing that,
// closest to it.
BoundarySweep::PatchPoint BoundarySweep::invert_map(const Patch& patch, const Vec2& uv,
                                                    const Vec2& from) const {
  const Vec2 low(patch.left.side < 0 ? 1e-9 : -kBeyond, -kBeyond),
      high(patch.right.side < 0 ? 1 - 1e-9 : 1 + kBeyond, 1 + kBeyond);
  PatchPoint here = evaluate_map(patch, from);
  for (int round = 0; round < 25; ++round) {
    const Vec2 miss = uv - here.uv;
    if (miss.norm() < 1e-14 * extent_) break;
    const double det = here.jacobian.determinant();
    if (!(std::abs(det) > 0)) break;
    const Vec2 step = here.jacobian.inverse() * miss;
    bool better = false;
    for (double f = 1; f > 1e-3 && !better; f /= 2) {
      const Vec2 next = (here.st + f * step).cwiseMax(low).cwiseMin(high);
      PatchPoint there = evaluate_map(patch, next);
      if (!((uv - there.uv).norm() < miss.norm())) continue;
      here = std::move(there);
      better = true;
    }
    if (!better) break;
  }
  return here;
}

double BoundarySweep::Fan::warped(double t) const {
  const Vec3 direction = (1 - t) * bottom + t * top;
  // Defined beyond the sides too, so that the surface continues smoothly there.
  return std::atan2(bottom.cross(direction).dot(bottom.cross(top).normalized()),
                    bottom.dot(direction)) /
         angle;
}

double BoundarySweep::Fan::length_scale(double t) const {
  return ((1 - t) * bottom + t * top).norm() / ((1 - t) * bottom.norm() + t * top.norm());
}

Vec2 BoundarySweep::warped(const Patch& patch, const Vec2& st) {
  const double s = st[0], t = st[1];
  Vec2 warped = st;
  // Cubics of s with slope 1 at the corner and 0 at the other end; they vanish at both.
  if (patch.fan_left) {
    warped[0] += (patch.fan_left->length_scale(t) - 1) * s * (1 - s) * (1 - s);
    warped[1] += (patch.fan_left->warped(t) - t) * (1 - s) * (1 - s);
  }
  if (patch.fan_right) {
    warped[0] += (patch.fan_right->length_scale(t) - 1) * s * s * (s - 1);
    warped[1] += (patch.fan_right->warped(t) - t) * s * s;
  }
  return warped;
}

BoundarySweep::Edges BoundarySweep::edges(const Patch& patch, const Vec2& st) const {
  return {point(patch.bottom, st[0]), point(patch.top, st[0]), point(patch.left, st[1]),
          point(patch.right, st[1])};
}

Vec2 BoundarySweep::parameters(const Patch& patch, const Vec2& st) const {
  return projection_ ? st : warped(patch, st);
}

BoundarySweep::Jet BoundarySweep::jet(const Patch& patch, const PatchPoint& evaluate_map) const {
  if (projection_ || (!patch.fan_left && !patch.fan_right))
    return jet(patch, evaluate_map.st, evaluate_map.edges);
  const Vec2 st = warped(patch, evaluate_map.st);
  const Jet j = jet(patch, st, edges(patch, st));
  constexpr double h = 1e-5;
  const Vec2 by_s =
      (warped(patch, evaluate_map.st + Vec2(h, 0)) - warped(patch, evaluate_map.st - Vec2(h, 0))) /
      (2 * h);
  const Vec2 by_t =
      (warped(patch, evaluate_map.st + Vec2(0, h)) - warped(patch, evaluate_map.st - Vec2(0, h))) /
      (2 * h);
  return {j.x, by_s[0] * j.by_u + by_s[1] * j.by_v, by_t[0] * j.by_u + by_t[1] * j.by_v};
}

BoundarySweep::Jet BoundarySweep::jet(const Patch& patch, const Vec2& st, const Edges& edges) {
  const auto as = [](const BoundarySide::Point& p) { return Sweep::PointAndSlope{p.x, p.x_f}; };
  const auto& [bottom, top, left, right] = edges;
  Jet sum{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  if (patch.weight_t > 0) {
    const Jet j = patch.along_t->at(st[1], as(bottom), as(top), as(left), as(right));
    sum = {patch.weight_t * j.x, patch.weight_t * j.by_u, patch.weight_t * j.by_v};
  }
  if (patch.weight_s > 0) {
    const Jet j = patch.along_s->at(st[0], as(left), as(right), as(bottom), as(top));
    sum.x += patch.weight_s * j.x;
    sum.by_u += patch.weight_s * j.by_v;
    sum.by_v += patch.weight_s * j.by_u;
  }
  const double weight = patch.weight_t + patch.weight_s;
  return {sum.x / weight, sum.by_u / weight, sum.by_v / weight};
}

// Position and gradient of one patch's sweeps with respect to (u, v).
FirstOrderJet BoundarySweep::slopes_at(const Patch& patch, const PatchPoint& evaluate_map) const {
  const Jet j = jet(patch, evaluate_map);
  Eigen::Matrix<double, 3, 2> by_st;
  by_st << j.by_u, j.by_v;
  return {j.x, by_st * evaluate_map.jacobian.inverse()};
}

// The point of one patch's sweeps closest to the mean of all, starting from (s, t), and its
// gradient. With J the sweep's own derivatives, the gradient of the foot point follows from Jᵀ
// (mean - x) = 0:
//
//     (Jᵀ J - (mean - x)ᵀ x_ij) st_uv = Jᵀ mean_uv,   x_uv = J st_uv.
FirstOrderJet BoundarySweep::projected(const Patch& patch, Vec2 st,
                                       const FirstOrderJet& mean) const {
  using Slopes = Eigen::Matrix<double, 3, 2>;
  const auto jet_at = [&](const Vec2& at) { return jet(patch, at, edges(patch, at)); };
  const auto slopes_of = [](const Jet& j) {
    Slopes J;
    J << j.by_u, j.by_v;
    return J;
  };
  const auto singular = [](const Mat2& A) {
    return !(std::abs(A.determinant()) > 1e-12 * A.squaredNorm());
  };
  Jet j = jet_at(st);
  for (int round = 0; round < 4; ++round) {
    const Slopes J = slopes_of(j);
    const Mat2 metric = J.transpose() * J;
    if (singular(metric)) break;
    const Vec2 step = metric.inverse() * (J.transpose() * (mean.x - j.x));
    st = (st + step).cwiseMax(-kBeyond).cwiseMin(1 + kBeyond);
    if (patch.right.side < 0) st[0] = std::min(st[0], 1.0);
    j = jet_at(st);
    if ((J * step).norm() < 1e-10 * region_->size()) break;
  }
  const Slopes J = slopes_of(j);
  Mat2 curved;
  constexpr double h = 1e-4;
  for (const int k : {0, 1}) {
    const Vec2 step = h * Vec2::Unit(k);
    const Slopes by_k = (slopes_of(jet_at(st + step)) - slopes_of(jet_at(st - step))) / (2 * h);
    curved.col(k) = by_k.transpose() * (mean.x - j.x);
  }
  const Mat2 A = J.transpose() * J - 0.5 * (curved + curved.transpose());
  if (singular(A)) return {j.x, mean.gradient};
  return {j.x, J * (A.inverse() * (J.transpose() * mean.gradient))};
}

// At a corner the two sides determine the tangent plane and the gradient.
std::optional<FirstOrderJet> BoundarySweep::at_corner(const Vec2& uv) const {
  constexpr double kSamePoint = 1e-9;
  for (size_t k = 0; k < sides_.size(); ++k) {
    const BoundarySide::Point out = sides_[k].at(0);
    if ((out.uv - uv).norm() > kSamePoint * extent_) continue;
    const BoundarySide::Point in = sides_[(k + sides_.size() - 1) % sides_.size()].at(1);
    Mat2 uv_tangents;
    uv_tangents << out.uv_f, in.uv_f;
    Eigen::Matrix<double, 3, 2> slopes;
    slopes << out.x_f, in.x_f;
    if (!(std::abs(uv_tangents.determinant()) > 1e-6 * out.uv_f.norm() * in.uv_f.norm()))
      return std::nullopt;
    return FirstOrderJet{out.x, slopes * uv_tangents.inverse()};
  }
  return std::nullopt;
}

FirstOrderJet BoundarySweep::at(const Vec2& uv) const {
  if (const auto corner = at_corner(uv)) return *corner;
  if (patches_.size() > 1) {
    // Beyond the boundary the surface is continued linearly.
    constexpr double kInside = 1e-9;
    if (const Vec2 near = invert_map(patches_.front(), uv).uv;
        (uv - near).norm() > kInside * extent_) {
      FirstOrderJet s = slopes_of_blend(near);
      s.x += s.gradient * (uv - near);
      return s;
    }
    return slopes_of_blend(uv);
  }
  const Patch& patch = patches_.front();
  const PatchPoint evaluate_map = invert_map(patch, uv);
  constexpr double kOutside = 1e-9, kAtCorner = 1e-3;
  if ((uv - evaluate_map.uv).norm() > kOutside * extent_)
    // Also beyond a corner that is a degenerate rail, where (s, t) end.
    for (const bool right : {false, true}) {
      const Edge& edge = right ? patch.right : patch.left;
      const double from = right ? 1 - evaluate_map.st[0] : evaluate_map.st[0];
      if (edge.side >= 0 || from > kAtCorner) continue;
      if (auto corner = at_corner(edge.uv)) {
        corner->x += corner->gradient * (uv - edge.uv);
        return *corner;
      }
    }
  FirstOrderJet s = slopes_at(patch, evaluate_map);
  s.x += s.gradient * (uv - evaluate_map.uv);
  return s;
}

FirstOrderJet BoundarySweep::slopes_of_blend(const Vec2& uv) const {
  FirstOrderJet mean, blend;
  std::vector<Vec2> st;
  const auto add = [](FirstOrderJet& sum, double weight, const FirstOrderJet& of) {
    sum.x += weight * of.x;
    sum.gradient += weight * of.gradient;
  };
  for (const Patch& patch : patches_) {
    const PatchPoint at = invert_map(patch, uv);
    st.push_back(parameters(patch, at.st));
    add(mean, patch.weight_t, slopes_at(patch, at));
  }
  for (size_t k = 0; k < patches_.size(); ++k)
    add(blend, patches_[k].weight_t, projected(patches_[k], st[k], mean));
  return blend;
}

std::optional<Points> BoundarySweep::dofs() const {
  const ParametricMesh& mesh = *region_->mesh();
  Points q = interpolate_surface(mesh, [this](const Vec2& uv) { return at(uv); });
  if (!q.allFinite()) return std::nullopt;
  const Surface surface(region_->mesh(), region_->element(), q, region_->trim());
  const Trim* trim = region_->trim().get();
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<2048>(t);
    if (trim && trim->side(t) != Trim::Side::Inside) continue;
    const Vec3 middle = surface.area_vector({t, Vec3::Constant(1.0 / 3)});
    for (int k = 0; k < 3; ++k)
      if (!(surface.area_vector({t, Vec3::Unit(k)}).dot(middle) > 0)) return std::nullopt;
  }
  return q;
}

// Three-point Gauss-Legendre quadrature: exact if the speed is a polynomial up to degree five.
double BoundarySide::Part::length_to(double t) const {
  static const double offset = std::sqrt(0.6);
  const double half = 0.5 * t;
  const auto speed = [&](double x) { return slope(half + half * x).norm(); };
  return half * (5 * speed(-offset) + 8 * speed(0) + 5 * speed(offset)) / 9;
}

void BoundarySide::add(HermiteCurve curve, HermiteCurve pcurve) {
  constexpr int kParts = 4;  // per segment; lengths are then accurate to 1e-9 on quarter circles
  const auto& at = curve.parameters();
  double length = this->length();
  for (size_t i = 0; i + 1 < at.size(); ++i)
    for (int k = 0; k < kParts; ++k) {
      const double step = (at[i + 1] - at[i]) / kParts;
      Part part;
      part.piece = isize(pcurves_);
      part.from = at[i] + k * step;
      part.to = k + 1 == kParts ? at[i + 1] : part.from + step;
      // The cubic through four points of the part.
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
  // The cubic Hermite interpolant of t(s) has an error of fourth order in the part's change of
  // direction; Newton steps correct it.
  const double s = inside > 0 ? wanted / inside : 0;
  double t = s * (1 + (1 - s) * ((1 - s) * (part.rates[0] - 1) - s * (part.rates[1] - 1)));
  t = std::clamp(t, 0.0, 1.0);
  for (int round = 0; round < 3 && wanted > 0 && wanted < inside; ++round) {
    const double speed = part.slope(t).norm();
    if (!(speed > 0)) break;
    const double step = (wanted - part.length_to(t)) / speed;
    t = std::clamp(t + step, 0.0, 1.0);
    if (std::abs(step) < 1e-7) break;  // the next step would be of the order of its square
  }
  const double range = part.to - part.from;
  const Vec3 slope = part.slope(t);
  const double speed = slope.norm(), rate = speed > 0 ? this->length() / speed : 0;
  const HermiteCurve& pcurve = pcurves_[static_cast<size_t>(part.piece)];
  // Derivatives at the end of a part are evaluated just before it, because a node belongs to the
  // segment that begins there.
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

namespace {

double length_of(const ParametricMesh& mesh, const ParametricMesh::Edge& edge) {
  const auto& corner = mesh.shape(edge.triangle[0]).vertex;
  const int i = edge.local[0];
  return (corner[(i + 1) % 3] - corner[(i + 2) % 3]).norm();
}

}  // namespace

RestShapeError rest_shape_error(const RegionLayout& region, double tolerance,
                                const SizeField* before) {
  const auto sweep = BoundarySweep::of(region);
  if (!sweep) return {};
  const ParametricMesh& mesh = *region.mesh();
  Points edge_midpoints;
  // It may be inverted, where the elements are too large for it, or even in the limit.
  const Surface surface(region.mesh(), region.element(),
                        interpolate_surface(
                            mesh, [&](const Vec2& uv) { return sweep->at(uv); }, &edge_midpoints));
  double longest = 0;
  for (const auto& edge : mesh.edges()) longest = std::max(longest, length_of(mesh, edge));
  std::vector<double> lengths(static_cast<size_t>(mesh.vertex_count()), longest);
  if (before)
    for (int v = 0; v < mesh.vertex_count(); ++v) lengths[v] = before->at(mesh.vertices()[v]);
  RestShapeError found;
  double& largest = found.largest;
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const int t = edge.triangle[0], i = edge.local[0];
    Vec3 L = Vec3::Constant(0.5);
    L[i] = 0;
    const double error = (surface.position({t, L}) - edge_midpoints.row(e).transpose()).norm();
    largest = std::max(largest, error);
    if (!(error > tolerance)) continue;
    const double shorter = std::clamp(std::pow(0.1 * tolerance / error, 0.25), 0.5, 0.7);
    for (const int beside : edge.triangle) {
      if (beside < 0) continue;
      for (const int v : mesh.triangles()[beside]) {
        // Edges may be longer than requested.
        const double asked = before ? before->at(mesh.vertices()[v]) : longest;
        lengths[v] = std::min(lengths[v], shorter * std::min(asked, length_of(mesh, edge)));
      }
    }
  }
  if (largest > tolerance)
    found.size_field = std::make_shared<const SizeField>(region.mesh(), std::move(lengths));
  return found;
}

}  // namespace batten
