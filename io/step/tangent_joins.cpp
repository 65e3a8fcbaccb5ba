// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/tangent_joins.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {
namespace {

constexpr int kPieces = 256;      // samples per segment
constexpr double kNearby = 0.03;  // half-width of the smoothing window, as a fraction of a segment

/// A piece of a curve with its two sides.
struct Join {
  std::array<FaceBoundarySegment*, 2> segments;
  std::array<const TangentSide*, 2> sides;
  double same = 1;                               // -1: the normals of the two sides are opposite
  std::vector<std::array<Vec3, 2>> of_surfaces;  // at points along the curve; zero: not tangent
  std::vector<Vec3> along;                       // unit tangents of the curve
  std::vector<Vec3> common;                      // common normals, oriented as on the first side

  /// Converts the index of a point along the curve to the index along the segment of a side.
  int index(int side, int k) const {
    return segments[static_cast<size_t>(side)]->reversed ? kPieces - k : k;
  }
  double sign(int side) const { return side == 0 ? 1 : same; }  // of a side's normal
  /// The position of a point along the curve.
  Vec3 position(int k) const {
    const HermiteCurve& curve = segments[0]->curve;
    const int i = index(0, k);
    return i == kPieces
               ? curve.evaluate({curve.segment_count() - 1, 1.0})
               : curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kPieces);
  }
  Vec3 unit_tangent(int k) const {
    const HermiteCurve& curve = segments[0]->curve;
    const int i = index(0, k);
    const Vec3 slope =
        i == kPieces
            ? curve.evaluate({curve.segment_count() - 1, 1.0}, 1)
            : curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kPieces, 1);
    if (!(slope.norm() > 0)) {  // a curve may start or end with a slope of zero
      const Vec3 chord = position(std::min(k + 1, kPieces)) - position(std::max(k - 1, 0));
      return chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3(Vec3::UnitX());
    }
    return (segments[0]->reversed ? -1 : 1) * slope.normalized();
  }
  bool tangent(int k) const { return !of_surfaces[static_cast<size_t>(k)][0].isZero(); }
};

Vec3 normal_at(const FaceBoundarySegment& segment, const TangentSide& side, int k) {
  const double fraction = double(k) / kPieces;
  return side.normal(k == kPieces
                         ? segment.last()
                         : segment.uv(segment.curve.start() +
                                      fraction * (segment.curve.end() - segment.curve.start())));
}

void compare_sides(Join& join) {
  for (int k = 0; k <= kPieces; ++k) {
    const Vec3 one = normal_at(*join.segments[0], *join.sides[0], join.index(0, k)),
               other = normal_at(*join.segments[1], *join.sides[1], join.index(1, k));
    const bool tangent =
        !one.isZero() && !other.isZero() && angle_between_planes(one, other) <= kTangentDeg;
    join.of_surfaces.push_back({tangent ? one : Vec3::Zero(), tangent ? other : Vec3::Zero()});
    if (tangent) join.same = one.dot(other) < 0 ? -1 : 1;  // shells need not be orientable
  }
}

/// Discards short tangent stretches: surfaces that meet at a crease may pass through a common plane
/// where the sign of the angle changes.
void drop_crossings(Join& join) {
  constexpr int shortest = kPieces / 16;
  for (int k = 0, first = 0; k <= kPieces + 1; ++k) {
    if (k <= kPieces && join.tangent(k)) continue;
    if (k - first < shortest)
      for (int i = first; i < k; ++i) join.of_surfaces[static_cast<size_t>(i)][0].setZero();
    first = k + 1;
  }
}

/// Computes the common normals. They are perpendicular to the curve; their angles about it, from a
/// parallel transported frame, are smoothed by local quadratic regression, which removes features
/// shorter than the knots of a face can follow. (A surface that bends sharply at a corner has the
/// tip of its bend in one element.) The regression of the normals themselves would also remove the
/// curvature of the curve, such as that of the nose of an aerofoil.
void smooth(Join& join) {
  const int reach = static_cast<int>(kNearby * kPieces);
  join.common.assign(kPieces + 1, Vec3::Zero());
  std::vector<std::array<Vec3, 2>> frame;  // perpendicular to the curve
  std::vector<double> angle;
  for (int k = 0; k <= kPieces; ++k) {
    join.along.push_back(join.unit_tangent(k));
    const Vec3& t = join.along.back();
    Vec3 first = t.unitOrthogonal();
    if (k > 0)
      first = Eigen::Quaterniond::FromTwoVectors(join.along[static_cast<size_t>(k) - 1], t) *
              frame.back()[0];
    first = (first - first.dot(t) * t).normalized();
    frame.push_back({first, t.cross(first)});
    const double before = angle.empty() ? 0 : angle.back();
    angle.push_back(before);
    if (!join.tangent(k)) continue;
    const auto& [one, other] = join.of_surfaces[static_cast<size_t>(k)];
    const Vec3 mean = one + join.same * other;
    constexpr double turn = 2 * std::numbers::pi;
    const double here = std::atan2(mean.dot(frame.back()[1]), mean.dot(first));
    angle.back() = here + turn * std::round((before - here) / turn);  // continuous
  }
  for (int k = 0; k <= kPieces; ++k) {
    if (!join.tangent(k)) continue;
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (int i = std::max(0, k - reach); i <= std::min(kPieces, k + reach); ++i) {
      if (!join.tangent(i)) continue;
      const double s = double(i - k) / (reach + 1), w = std::pow(1 - std::abs(s * s * s), 3);
      const Vec3 powers(1, s, s * s);
      A += w * powers * powers.transpose();
      b += w * angle[static_cast<size_t>(i)] * powers;
    }
    const double found = Eigen::CompleteOrthogonalDecomposition<Mat3>(A).solve(b)[0];
    const auto& [first, second] = frame[static_cast<size_t>(k)];
    join.common[static_cast<size_t>(k)] = std::cos(found) * first + std::sin(found) * second;
  }
}

/// Ends of joins that meet at one point and whose tangent planes agree, except for changes by
/// smoothing.
struct Corner {
  Vec3 sum = Vec3::Zero();
  std::vector<std::pair<Join*, int>> ends;
};
using EndPointId =
    std::pair<std::string, int>;  // a cut of a curve, or "" and a point index of the plan

EndPointId end_point_of(const StepPlan& plan, const LineSegmentId& piece, bool end) {
  const StepLine& line = plan.lines.at(piece.first);
  const int cut = piece.second + (end ? 1 : 0);
  if (cut == 0 || cut == isize(line.cuts) + 1) return {"", line.places[cut > 0]};
  return {piece.first, cut};
}

/// The normal of the tangent plane at a corner: perpendicular to the curves that end there or, if
/// these have one direction only, the mean of their normals.
Vec3 normal_of(const Corner& corner) {
  Mat3 tangents = Mat3::Zero();
  for (const auto& [join, k] : corner.ends) {
    const Vec3& t = join->along[static_cast<size_t>(k)];
    tangents += t * t.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(tangents);
  constexpr double other_direction = 0.03;  // curves that meet at 14 degrees
  if (!(axes.eigenvalues()[1] > other_direction)) return corner.sum.normalized();
  const Vec3 normal = axes.eigenvectors().col(0);
  return (normal.dot(corner.sum) < 0 ? -1 : 1) * normal;
}

/// Gives all joins at a corner the same normal, because a face has one tangent plane there: rotates
/// the normals about the curves. The rotation fades out along each join.
void unify_normals(const Corner& corner) {
  constexpr double fade = 0.3;  // of a join
  const Vec3 normal = normal_of(corner);
  for (const auto& [join, k] : corner.ends) {
    const Vec3 end = join->common[static_cast<size_t>(k)], t = join->along[static_cast<size_t>(k)];
    const Vec3 to = (end.dot(normal) < 0 ? -1 : 1) * normal;
    const double angle = std::atan2(t.dot(end.cross(to)), end.dot(to));
    for (int i = 0; i <= kPieces; ++i) {
      const double s = std::abs(i - k) / (fade * kPieces);
      if (!(s < 1) || !join->tangent(i)) continue;
      Vec3& n = join->common[static_cast<size_t>(i)];
      n = Eigen::AngleAxisd((1 - s) * (1 - s) * (1 + 2 * s) * angle,
                            join->along[static_cast<size_t>(i)]) *
          n;
    }
    join->common[static_cast<size_t>(k)] = to;
  }
}

void unify_normals_at_corners(const StepPlan& plan, std::map<LineSegmentId, Join>& joins) {
  constexpr double alike_deg = 5;
  std::map<EndPointId, std::vector<Corner>> corners;
  for (auto& [piece, join] : joins)
    for (const bool end : {false, true}) {
      const int k = end ? kPieces : 0;
      if (!join.tangent(k)) continue;
      const Vec3& n = join.common[static_cast<size_t>(k)];
      auto& here = corners[end_point_of(plan, piece, end)];
      auto corner = std::find_if(here.begin(), here.end(), [&](const Corner& c) {
        return angle_between_planes(c.sum, n) < alike_deg;
      });
      if (corner == here.end()) corner = here.emplace(here.end());
      corner->sum += n.dot(corner->sum) < 0 ? -n : n;
      corner->ends.emplace_back(&join, k);
    }
  for (const auto& [place, here] : corners)
    for (const Corner& corner : here) unify_normals(corner);
}

/// The first or last end of a join, with derivatives by quadratic interpolation; nullopt if the
/// surfaces are not tangent there.
std::optional<TwistEnd> end_of(const Join& join, bool last) {
  constexpr int step = 4;
  const auto at = [&](int i) { return last ? kPieces - i : i; };
  for (const int i : {0, step, 2 * step})
    if (!join.tangent(at(i))) return std::nullopt;
  const auto normal = [&](int i) { return join.common[static_cast<size_t>(at(i))].normalized(); };
  const Vec3 x = join.position(at(0)), a = join.position(at(step)) - x,
             b = join.position(at(2 * step)) - x, n = normal(0);
  const double s = a.norm(), t = b.norm(), of_a = t / (s * (t - s)), of_b = -s / (t * (t - s));
  const Vec3 along = of_a * a + of_b * b,
             slope = of_a * (normal(step) - n) + of_b * (normal(2 * step) - n);
  return TwistEnd{(along - along.dot(n) * n).normalized(), n, slope - slope.dot(n) * n};
}

/// Rotates the normals near an end about the curve, by rate · s (1 - s/S)² at arc length s from the
/// end. This moves the face off its surface by about rate S² / 25, which may be up to a third of
/// the tolerance.
void twist(Join& join, bool last, double rate, double tolerance) {
  constexpr double part = 8, longest = 0.4;  // longest: fraction of the join
  const double reach = std::min(longest * (join.position(0) - join.position(kPieces)).norm(),
                                std::sqrt(part * tolerance / std::abs(rate)));
  const auto at = [&](int i) { return last ? kPieces - i : i; };
  double s = 0;
  for (int i = 1; i < kPieces && join.tangent(at(i)); ++i) {
    const Vec3 step = join.position(at(i)) - join.position(at(i - 1));
    s += step.norm();
    if (s >= reach) return;
    Vec3& n = join.common[static_cast<size_t>(at(i))];
    n = n.normalized() + rate * s * std::pow(1 - s / reach, 2) * n.cross(step.normalized());
  }
}

/// Rotates the normals along joins so that each face can have a single twist in its corners.
void match_twists(const std::vector<TangentSide>& sides, std::map<LineSegmentId, Join>& joins,
                  double tolerance) {
  std::map<const FaceBoundarySegment*, std::pair<Join*, int>> join_of;
  std::map<std::pair<const Join*, bool>, int> number;
  std::vector<TwistEnd> ends;
  for (auto& [piece, join] : joins) {
    for (const int side : {0, 1}) join_of[join.segments[static_cast<size_t>(side)]] = {&join, side};
    for (const bool last : {false, true})
      if (const auto end = end_of(join, last)) {
        number[{&join, last}] = isize(ends);
        ends.push_back(*end);
      }
  }
  std::vector<TwistCorner> corners;
  for (const TangentSide& side : sides)
    for (const FaceLoop& loop : side.boundary->loops)
      for (size_t k = 0; k < loop.size(); ++k) {
        const auto one = join_of.find(&loop[k]), other = join_of.find(&loop[(k + 1) % loop.size()]);
        if (one == join_of.end() || other == join_of.end()) continue;
        const auto& [join, of] = one->second;
        const auto& [next, of_next] = other->second;
        const auto a = number.find({join, join->index(of, kPieces) > 0}),
                   b = number.find({next, next->index(of_next, 0) > 0});
        if (a == number.end() || b == number.end()) continue;
        corners.push_back({{a->second, b->second}, {join->sign(of), next->sign(of_next)}});
      }
  const std::vector<double> rates = matching_twists(ends, corners);
  for (auto& [piece, join] : joins)
    for (const bool last : {false, true})
      if (const auto found = number.find({&join, last}); found != number.end())
        twist(join, last, rates[static_cast<size_t>(found->second)], tolerance);
}

void set_normal_corrections(Join& join) {
  for (const size_t side : {0, 1}) {
    auto& normal_corrections = join.segments[side]->normal_corrections;
    normal_corrections.assign(kPieces + 1, std::nullopt);
    for (int k = 0; k <= kPieces; ++k) {
      if (!join.tangent(k)) continue;
      const auto at = static_cast<size_t>(k);
      const Vec3 common = join.sign(static_cast<int>(side)) * join.common[at].normalized();
      normal_corrections[static_cast<size_t>(join.index(static_cast<int>(side), k))] =
          common - join.of_surfaces[at][side];
    }
  }
}

}  // namespace

LineSegmentId segment_id_of(const StepPlan& plan, const FaceBoundarySegment& segment) {
  const double middle = segment.line_parameter((segment.curve.start() + segment.curve.end()) / 2);
  const std::vector<double>& cuts = plan.lines.at(segment.line).cuts;
  return {segment.line,
          static_cast<int>(std::lower_bound(cuts.begin(), cuts.end(), middle) - cuts.begin())};
}

double angle_between_planes(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / std::numbers::pi;
}

void find_tangent_joins(const StepPlan& plan, const std::vector<TangentSide>& sides,
                        double tolerance) {
  std::map<LineSegmentId, std::vector<std::pair<FaceBoundarySegment*, const TangentSide*>>> beside;
  for (const TangentSide& side : sides)
    for (FaceLoop& loop : side.boundary->loops)
      for (FaceBoundarySegment& segment : loop)
        if (segment.shared) beside[segment_id_of(plan, segment)].emplace_back(&segment, &side);
  std::map<LineSegmentId, Join> joins;
  for (const auto& [piece, two] : beside) {
    if (two.size() != 2) continue;
    Join join;
    join.segments = {two[0].first, two[1].first};
    join.sides = {two[0].second, two[1].second};
    compare_sides(join);
    drop_crossings(join);
    int tangent = 0;
    for (int k = 0; k <= kPieces; ++k) tangent += join.tangent(k);
    if (2 * tangent < kPieces) continue;  // a crease that is tangent at its beginning or end only
    smooth(join);
    joins.emplace(piece, std::move(join));
  }
  unify_normals_at_corners(plan, joins);
  match_twists(sides, joins, tolerance);
  for (auto& [piece, join] : joins) set_normal_corrections(join);
}

void follow_neighbours(
    const TangentSide& side,
    const std::map<std::string, std::shared_ptr<const NeighbourEdge>>& neighbours) {
  for (FaceLoop& loop : side.boundary->loops)
    for (FaceBoundarySegment& segment : loop) {
      const auto found = neighbours.find(segment.line);
      if (found == neighbours.end()) continue;
      segment.normal_corrections.assign(kPieces + 1, std::nullopt);
      for (int k = 0; k <= kPieces; ++k) {
        const double t =
            segment.curve.start() + k * (segment.curve.end() - segment.curve.start()) / kPieces;
        const Vec3 own = normal_at(segment, side, k),
                   given = found->second->normal_near(segment.curve.evaluate(t));
        if (own.isZero() || angle_between_planes(own, given) > kNeighbourDeg) continue;
        segment.normal_corrections[static_cast<size_t>(k)] =
            (given.dot(own) < 0 ? -1 : 1) * given - own;
      }
    }
}

namespace {

/// Rows of the least-squares problem: coefficients of the unknowns, and right-hand sides.
struct TwistEquations {
  std::vector<Triplet> entries;
  std::vector<double> rhs;
  int count() const { return isize(rhs); }
  void set(int unknown, double value) { entries.emplace_back(count(), unknown, value); }
  void close(double value) { rhs.push_back(value); }
};

/// Adds n' + c n × t + B t = 0 for both ends, in a frame of the corner's tangent plane; B = (p q; q
/// r).
void add_corner(TwistEquations& equations, const std::vector<TwistEnd>& ends,
                const TwistCorner& corner, int p) {
  const TwistEnd& first = ends[corner.ends[0]];
  const Vec3 e1 = first.along, e2 = corner.sign[0] * first.normal.cross(e1);
  for (const size_t k : {0, 1}) {
    const TwistEnd& end = ends[corner.ends[k]];
    const Vec3 slope = corner.sign[k] * end.slope,
               across = corner.sign[k] * end.normal.cross(end.along);
    const Vec2 t = Vec2(end.along.dot(e1), end.along.dot(e2));
    for (const int row : {0, 1}) {
      const Vec3& e = row == 0 ? e1 : e2;
      equations.set(corner.ends[k], across.dot(e));
      equations.set(p + row, t.x());
      equations.set(p + row + 1, t.y());
      equations.close(-slope.dot(e));
    }
  }
}

}  // namespace

std::vector<double> matching_twists(const std::vector<TwistEnd>& ends,
                                    const std::vector<TwistCorner>& corners) {
  TwistEquations equations;
  for (size_t k = 0; k < corners.size(); ++k)
    add_corner(equations, ends, corners[k], isize(ends) + 3 * static_cast<int>(k));
  const int unknowns = isize(ends) + 3 * isize(corners);
  constexpr double small = 1e-2;
  for (int k = 0; k < unknowns; ++k) {
    equations.set(k, k < isize(ends) ? small : 1e-4 * small);
    equations.close(0);
  }
  SparseMatrix A(equations.count(), unknowns);
  A.setFromTriplets(equations.entries.begin(), equations.entries.end());
  MatX x =
      A.transpose() * Eigen::Map<const Eigen::VectorXd>(equations.rhs.data(), equations.count());
  const SparseMatrix K = SparseMatrix(A.transpose() * A).triangularView<Eigen::Lower>();
  SparseCholesky cholesky;
  cholesky.analyze(K);
  if (!cholesky.factorize(K)) return std::vector<double>(ends.size(), 0.0);
  cholesky.solve_in_place(x);
  return {x.data(), x.data() + ends.size()};
}

}  // namespace batten
