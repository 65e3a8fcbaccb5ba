// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/domains/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/hole_triangulation.h"

namespace batten {
namespace {

using std::numbers::pi;

void require_not_on_one_line(const std::vector<SmoothSegment>& segments, double size) {
  std::vector<Vec3> points;
  for (const auto& s : segments)
    for (const Vec3& p : polyline(*s.curve)) points.push_back(p);
  const double across = principal_axes(points).values[1] / static_cast<double>(points.size());
  if (std::sqrt(std::max(0.0, across)) < 1e-7 * size)
    throw InputError("all outline curves lie on one straight line and enclose no area");
}

// Unit tangents just before and just after the start of a segment.
std::pair<Vec3, Vec3> directions_at(const Outline& outline, size_t piece) {
  const size_t n = outline.segments.size();
  const InputCurve &in = *outline.segments[(piece + n - 1) % n].segment.curve,
                   &out = *outline.segments[piece].segment.curve;
  return {in.evaluate(in.end(), 1).normalized(), out.evaluate(out.start(), 1).normalized()};
}

double turning_angle_at(const Outline& outline, size_t piece) {
  const auto [a, b] = directions_at(outline, piece);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The partner of each end if each segment of the list, all around, ends where the next one begins;
// otherwise all -1. Two segments may have two such orders, a single one has one.
std::vector<int> partners_in_listed_order(const std::vector<Vec3>& point, double gap_tolerance) {
  const int n = isize(point) / 2;
  const auto meet = [&](int a, int b) { return (point[a] - point[b]).norm() <= gap_tolerance; };
  for (const int first : {0, 1}) {
    std::vector<int> partner(point.size(), -1);
    int entry = first;  // the end at which the loop enters segment i
    bool whole = true;
    for (int i = 0; i < n && whole; ++i) {
      const int exit = entry ^ 1, next = (i + 1) % n;
      entry = -1;
      for (const int e : {2 * next, 2 * next + 1})
        if (entry < 0 && meet(exit, e) && (next != 0 || e == first) && (n > 1 || e != exit))
          entry = e;
      whole = entry >= 0;
      if (whole) {
        partner[exit] = entry;
        partner[entry] = exit;
      }
    }
    if (whole) return partner;
  }
  return std::vector<int>(point.size(), -1);
}

// True if the prescribed curve that ends at the start of a segment has the same slope there as the
// segment's own prescribed curve.
bool continues_smoothly(const Outline& outline, size_t piece) {
  const size_t n = outline.segments.size();
  const auto &before = outline.segments[(piece + n - 1) % n], &after = outline.segments[piece];
  const HermiteCurve &a = before.segment.prescribed->curve, &b = after.segment.prescribed->curve;
  const Vec3 in =
                 before.flipped ? Vec3(-a.slope_out(0)) : a.evaluate({a.segment_count() - 1, 1}, 1),
             out =
                 after.flipped ? Vec3(-b.evaluate({b.segment_count() - 1, 1}, 1)) : b.slope_out(0);
  constexpr double same = 1e-12;
  return (in - out).norm() <= same * in.norm();
}

void require_all_or_none_prescribed(const std::vector<SmoothSegment>& segments) {
  for (const SmoothSegment& s : segments)
    if (static_cast<bool>(s.prescribed) != static_cast<bool>(segments[0].prescribed))
      throw InputError("found curves '" + segments[0].name + "' and '" + s.name +
                       "' around one face, of which only one is prescribed, expected all or none");
}

// Joins segments at their ends. End 2i is the start of segment i, end 2i + 1 its end.
class LoopBuilder {
 public:
  LoopBuilder(const std::vector<SmoothSegment>& segments, double size, double gap_tolerance)
      : segments_(segments), size_(size), gap_tolerance_(gap_tolerance) {
    for (const SmoothSegment& s : segments) {
      point_.push_back(s.curve->evaluate(s.curve->start()));
      point_.push_back(s.curve->evaluate(s.curve->end()));
    }
  }

  void require_no_crossings() const {
    const double near = 1e-7 * size_;
    std::vector<BoxedCurve> boxed;
    for (const SmoothSegment& s : segments_) boxed.emplace_back(*s.curve);
    for (size_t i = 0; i < segments_.size(); ++i) {
      if (const auto c = boxed[i].self_crossing(near); c.found)
        throw OutlineIntersection(
            "curve '" + segments_[i].name + "' intersects itself near " + format_point(c.where),
            {segments_[i].name});
      for (size_t j = i + 1; j < segments_.size(); ++j)
        if (const auto c = boxed[i].crossing(boxed[j], near, common_ends(i, j), 0.02 * size_);
            c.found)
          throw OutlineIntersection("the outline intersects itself: curves '" + segments_[i].name +
                                        "' and '" + segments_[j].name +
                                        "' intersect or touch near " + format_point(c.where),
                                    {segments_[i].name, segments_[j].name});
    }
  }

  // For each end, the end that it is joined to.
  std::vector<int> partners() const {
    std::vector<int> partner = segments_[0].prescribed
                                   ? partners_in_listed_order(point_, gap_tolerance_)
                                   : std::vector<int>(point_.size(), -1);
    for (int e = 0; e < isize(point_) && partner[e] < 0; ++e) partner[e] = unique_partner(e);
    return partner;
  }

  // Builds the loop that begins at an end.
  Outline loop(int begin, const std::vector<int>& partner, std::vector<char>& used) const {
    Outline outline;
    outline.size = size_;
    int end = begin;
    do {
      const bool flipped = end % 2 == 1;
      const SmoothSegment& s = segments_[end / 2];
      used[end / 2] = 1;
      Outline::OrientedSegment piece{s, flipped, 0, 0.5 * (point_[end] + point_[partner[end]])};
      if (flipped) {
        piece.segment.curve = reversed(s.curve);
        std::swap(piece.segment.at_corner[0], piece.segment.at_corner[1]);
      }
      piece.length = ArcLength(piece.segment.curve).total();
      if (piece.length < 1e-9 * size_) throw InputError("curve '" + s.name + "' has zero length");
      outline.segments.push_back(std::move(piece));
      end = partner[end ^ 1];
    } while (end != begin);
    return outline;
  }

 private:
  std::string name_of(int end) const {
    return std::string(end % 2 ? "the end of '" : "the start of '") + segments_[end / 2].name + "'";
  }

  std::vector<Vec3> common_ends(size_t i, size_t j) const {
    std::vector<Vec3> common;
    for (const Vec3& p : {point_[2 * i], point_[2 * i + 1]})
      for (const Vec3& q : {point_[2 * j], point_[2 * j + 1]})
        if ((p - q).norm() <= gap_tolerance_) common.push_back(p);
    return common;
  }

  int unique_partner(int end) const {
    std::vector<int> near;
    int nearest = -1;
    double nearest_gap = std::numeric_limits<double>::infinity();
    for (int other = 0; other < isize(point_); ++other) {
      if (other == end) continue;
      const double gap = (point_[end] - point_[other]).norm();
      if (gap <= gap_tolerance_) near.push_back(other);
      if (gap < nearest_gap) {
        nearest_gap = gap;
        nearest = other;
      }
    }
    if (near.empty())
      throw InputError(
          "the outline is open at " + name_of(end) + ", " + format_point(point_[end]) + ": " +
          (nearest < 0
               ? "there is no other curve"
               : "the nearest end, " + name_of(nearest) + ", is " + format_number(nearest_gap) +
                     " away (ends are joined within " + format_number(gap_tolerance_) + ")"));
    if (near.size() > 1)
      throw InputError("more than two outline curves end at " + format_point(point_[end]) + ": " +
                       name_of(end) + ", " + name_of(near[0]) + ", " + name_of(near[1]) +
                       "; use role = \"inner\" for inner curves, or reduce fit_tolerance (ends "
                       "are joined within " +
                       format_number(gap_tolerance_) + ")");
    return near[0];
  }

  const std::vector<SmoothSegment>& segments_;
  double size_, gap_tolerance_;
  std::vector<Vec3> point_;  // position of each end
};

}  // namespace

std::vector<Outline> make_loops(const std::vector<SmoothSegment>& segments, double size,
                                double gap_tolerance, double corner_angle,
                                bool reverse_orientation) {
  if (segments.empty()) throw InputError("found no outline curves of a face, expected one or more");
  require_not_on_one_line(segments, size);
  require_all_or_none_prescribed(segments);
  const LoopBuilder builder(segments, size, gap_tolerance);
  // Crossings are tested first: a crossing explains a broken loop better than the gap does.
  builder.require_no_crossings();
  const std::vector<int> partner = builder.partners();

  std::vector<Outline> loops;
  std::vector<char> used(segments.size(), 0);
  for (size_t first = 0; first < segments.size(); ++first) {
    if (used[first]) continue;
    const int begin = 2 * static_cast<int>(first) + (reverse_orientation && first == 0 ? 1 : 0);
    Outline outline = builder.loop(begin, partner, used);
    for (size_t i = 0, n = outline.segments.size(); i < n; ++i) {
      const SmoothSegment& before = outline.segments[(i + n - 1) % n].segment;
      const SmoothSegment& behind = outline.segments[i].segment;
      if (behind.prescribed ? !continues_smoothly(outline, i)
                            : turning_angle_at(outline, i) > corner_angle * pi / 180 ||
                                  (before.at_corner[1] && behind.at_corner[0]))
        outline.corners.push_back(static_cast<int>(i));
    }
    loops.push_back(std::move(outline));
  }
  return loops;
}

bool Outline::is_corner(size_t piece) const {
  return std::find(corners.begin(), corners.end(), static_cast<int>(piece)) != corners.end();
}

std::vector<size_t> Outline::side(size_t c) const {
  std::vector<size_t> found;
  size_t p = static_cast<size_t>(corners[c]);
  do {
    found.push_back(p);
    p = (p + 1) % segments.size();
  } while (!is_corner(p));
  return found;
}

double Outline::side_length(size_t c) const {
  double length = 0;
  for (const size_t p : side(c)) length += segments[p].length;
  return length;
}

LoopVertex loop_vertex_at(const Outline& outline, size_t p) {
  const auto [in, out] = directions_at(outline, p);
  LoopVertex vertex{outline.segments[p].start, out, in};
  if (!outline.is_corner(p)) vertex.outgoing = vertex.incoming = (in + out).normalized();
  return vertex;
}

void warn_about_rounded_kinks(const Outline& outline, double corner_angle,
                              std::vector<std::string>& warnings) {
  const size_t n = outline.segments.size();
  for (size_t p = 0; p < n; ++p) {
    if (outline.is_corner(p)) continue;
    const double turning_angle = turning_angle_at(outline, p) * 180 / pi;
    constexpr double noticeable = 1;
    if (turning_angle > noticeable)
      warnings.push_back("curves '" + outline.segments[(p + n - 1) % n].segment.name + "' and '" +
                         outline.segments[p].segment.name + "' meet at a kink of " +
                         format_number(turning_angle) + " degrees, which is below corner_angle = " +
                         format_number(corner_angle) + " and is rounded within the tolerance");
  }
}

Outline reversed(const Outline& outline) {
  const size_t n = outline.segments.size();
  Outline back;
  back.size = outline.size;
  for (size_t i = n; i-- > 0;) {
    Outline::OrientedSegment piece = outline.segments[i];
    piece.start = outline.end_of(i);
    piece.flipped = !piece.flipped;
    piece.segment.curve = reversed(piece.segment.curve);
    back.segments.push_back(std::move(piece));
  }
  // Segment i began where segment n-1-i now ends.
  for (const int c : outline.corners)
    back.corners.push_back(static_cast<int>((n - static_cast<size_t>(c)) % n));
  std::sort(back.corners.begin(), back.corners.end());
  return back;
}

namespace {

// Estimate of how far a curve may lie from a chord of its polyline.
double sag(const Vec3& a0, const Vec3& a1) { return 0.1 * (a1 - a0).norm(); }

double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 da = a1 - a0, db = b1 - b0, r = a0 - b0;
  const double a = da.squaredNorm(), e = db.squaredNorm(), f = db.dot(r), c = da.dot(r),
               b = da.dot(db);
  const double det = a * e - b * b;
  double s = det > 1e-14 * a * e ? std::clamp((b * f - c * e) / det, 0.0, 1.0) : 0;
  double t = e > 0 ? (b * s + f) / e : 0;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = a > 0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0;
  }
  return (Vec3(a0 + s * da) - Vec3(b0 + t * db)).norm();
}

// Distance of two curves near the given chords of their polylines, and the midpoint of the two
// nearest points. Gauss-Newton iteration in both parameters.
std::pair<double, Vec3> curve_distance(const InputCurve& a, int i, const InputCurve& b, int j) {
  const double step_a = (a.end() - a.start()) / kCurveChords,
               step_b = (b.end() - b.start()) / kCurveChords;
  const double low_a = a.start() + i * step_a, low_b = b.start() + j * step_b;
  double s = low_a + 0.5 * step_a, t = low_b + 0.5 * step_b;
  for (int k = 0; k < 20; ++k) {
    const Vec3 d = a.evaluate(s) - b.evaluate(t), da = a.evaluate(s, 1), db = b.evaluate(t, 1);
    Mat2 H;
    H << da.dot(da), -da.dot(db), -da.dot(db), db.dot(db);
    H.diagonal() *= 1 + 1e-12;
    const Vec2 move = H.inverse() * Vec2(da.dot(d), -db.dot(d));
    if (!move.allFinite()) break;
    s = std::clamp(s - move[0], low_a - 0.5 * step_a, low_a + 1.5 * step_a);
    t = std::clamp(t - move[1], low_b - 0.5 * step_b, low_b + 1.5 * step_b);
    s = std::clamp(s, a.start(), a.end());
    t = std::clamp(t, b.start(), b.end());
  }
  const Vec3 p = a.evaluate(s), q = b.evaluate(t);
  return {(p - q).norm(), 0.5 * (p + q)};
}

}  // namespace

std::vector<Vec3> polyline(const InputCurve& curve) {
  std::vector<Vec3> points;
  for (int i = 0; i <= kCurveChords; ++i)
    points.push_back(
        curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kCurveChords));
  return points;
}

bool BoxedCurve::Box::meets(const Box& other, double distance) const {
  return (low.array() <= other.high.array() + distance).all() &&
         (other.low.array() <= high.array() + distance).all();
}

void BoxedCurve::Box::add(const Vec3& p, double around) {
  low = low.cwiseMin((p.array() - around).matrix());
  high = high.cwiseMax((p.array() + around).matrix());
}

BoxedCurve::BoxedCurve(const InputCurve& curve) : curve_(&curve), points_(polyline(curve)) {
  for (int i = 0; i < kCurveChords; ++i)
    for (const int k : {i, i + 1}) {
      const double around = sag(points_[i], points_[i + 1]);
      parts_[i / kChordsInBox].add(points_[k], around);
      all_.add(points_[k], around);
    }
}

bool BoxedCurve::chords_meet(int i, const BoxedCurve& other, int j, double distance) const {
  const Vec3 &a0 = points_[i], &a1 = points_[i + 1], &b0 = other.points_[j],
             &b1 = other.points_[j + 1];
  return segment_distance(a0, a1, b0, b1) <= distance + (sag(a0, a1) + sag(b0, b1));
}

CurveCrossing BoxedCurve::crossing(const BoxedCurve& other, double distance,
                                   const std::vector<Vec3>& common_ends, double skip) const {
  if (!all_.meets(other.all_, distance)) return {};
  for (int i = 0; i < kCurveChords; ++i) {
    const Box& part = parts_[i / kChordsInBox];
    if (!part.meets(other.all_, distance)) {
      i += kChordsInBox - 1 - i % kChordsInBox;
      continue;
    }
    for (int j = 0; j < kCurveChords; ++j) {
      if (j % kChordsInBox == 0 && !part.meets(other.parts_[j / kChordsInBox], distance)) {
        j += kChordsInBox - 1;
        continue;
      }
      if (!chords_meet(i, other, j, distance)) continue;
      const auto [d, where] = curve_distance(*curve_, i, *other.curve_, j);
      if (d > distance) continue;
      const Vec3 place = where;
      if (std::none_of(common_ends.begin(), common_ends.end(),
                       [&](const Vec3& e) { return (place - e).norm() < skip; }))
        return {true, place};
    }
  }
  return {};
}

CurveCrossing BoxedCurve::self_crossing(double distance) const {
  const bool closed = (points_.front() - points_.back()).norm() <= distance;
  for (int i = 0; i < kCurveChords; ++i)
    for (int j = i + 4; j < kCurveChords; ++j) {
      if (closed && i + kCurveChords - j < 4) continue;
      if (!chords_meet(i, *this, j, distance)) continue;
      if (const auto [d, where] = curve_distance(*curve_, i, *curve_, j); d <= distance)
        return {true, where};
    }
  return {};
}

namespace {

Vec3 area_vector(const Outline& outline) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = outline.segments[0].start;
  for (const auto& piece : outline.segments) {
    const auto p = polyline(*piece.segment.curve);
    for (size_t i = 0; i + 1 < p.size(); ++i)
      area += 0.5 * (p[i] - origin).cross(p[i + 1] - origin);
  }
  return area;
}

// Sampled points of a loop, the same number on each segment.
struct LoopPoints {
  std::vector<Vec3> x;  // relative to the start of the loop, over its size
  int each;             // number per segment
  double height;        // extent of all points along the loop's normal
};

LoopPoints sample_loop(const Outline& outline, const Vec3& normal) {
  LoopPoints points;
  points.each = static_cast<int>(std::clamp<size_t>(64 / outline.segments.size(), 2, 24));
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& piece : outline.segments) {
    const InputCurve& c = *piece.segment.curve;
    for (int k = 0; k < points.each; ++k) {
      const Vec3 x = c.evaluate(c.start() + (c.end() - c.start()) * k / points.each) -
                     outline.segments[0].start;
      points.x.push_back(x / outline.size);
      low = std::min(low, points.x.back().dot(normal));
      high = std::max(high, points.x.back().dot(normal));
    }
  }
  points.height = high - low;
  return points;
}

// The difference between the sum of the interior angles and that of a polygon, radians.
double angle_sum_error(const Outline& outline, const std::vector<char>& left) {
  double sum = 2 * pi;
  for (size_t i = 0; i < left.size(); ++i)
    sum -= (left[i] ? 1 : -1) * turning_angle_at(outline, static_cast<size_t>(outline.corners[i]));
  return std::abs(sum);
}

// Tests whether the loop turns left at each of its corners. It is decided in projection along the
// loop's normal if the loop is nearly planar, and the corner is not nearly perpendicular to its
// plane, as it is at the nose of a wing section. Otherwise it is decided on a triangulation,
// because, for example, a strip around a cylinder faces all directions.
std::vector<char> left_at_corners(const Outline& outline) {
  const Vec3 normal = loop_normal(outline);
  const LoopPoints points = sample_loop(outline, normal);
  constexpr double nearly_plane = 0.2;  // of the size
  constexpr double upright = 0.5;       // cosine of 60 degrees
  constexpr size_t max_points = 400;
  std::vector<double> facing;  // cosine of the angle between a corner's axis and the normal
  for (const int c : outline.corners) {
    const LoopVertex vertex = loop_vertex_at(outline, static_cast<size_t>(c));
    facing.push_back(vertex.incoming.cross(vertex.outgoing).stableNormalized().dot(normal));
  }
  const auto needs_triangulation = [&](double cosine) {
    return points.height >= nearly_plane || std::abs(cosine) < upright;
  };
  std::optional<HoleTriangulation> triangulation;
  if (points.x.size() <= max_points &&
      std::any_of(facing.begin(), facing.end(), needs_triangulation))
    triangulation = developable_triangulation(points.x);
  std::vector<TriangulationCorner> corner_data;
  if (triangulation) corner_data = triangulation_corners(points.x, *triangulation);
  std::vector<char> left;
  for (size_t i = 0; i < facing.size(); ++i) {
    const auto piece = static_cast<size_t>(outline.corners[i]);
    const LoopVertex vertex = loop_vertex_at(outline, piece);
    left.push_back(triangulation && needs_triangulation(facing[i])
                       ? turns_left(vertex.incoming, vertex.outgoing,
                                    corner_data[piece * static_cast<size_t>(points.each)])
                       : facing[i] >= 0);
  }
  // Deep sides, such as the nose of a wing between two lines along the span, hide the inside of
  // the loop from the triangulation, but the angles of a polygon have a known sum.
  if (triangulation && angle_sum_error(outline, std::vector<char>(left.size(), 1)) <
                           angle_sum_error(outline, left))
    left.assign(left.size(), 1);
  return left;
}

}  // namespace

Vec3 loop_normal(const Outline& outline) {
  const Vec3 area = area_vector(outline);
  const double length = area.norm();
  if (!encloses_area(outline))
    throw InputError(
        "the outline encloses no area in any direction of view: it folds back on itself");
  return area / length;
}

bool encloses_area(const Outline& outline) {
  return enclosed_area(outline) >= 1e-6 * outline.size * outline.size;
}

double enclosed_area(const Outline& outline) { return area_vector(outline).norm(); }

std::vector<double> corner_angles(const Outline& outline, bool convex) {
  const std::vector<char> left =
      convex ? std::vector<char>(outline.corners.size(), 1) : left_at_corners(outline);
  std::vector<double> angles;
  for (size_t i = 0; i < left.size(); ++i) {
    const double turning_angle =
        turning_angle_at(outline, static_cast<size_t>(outline.corners[i]));
    angles.push_back(left[i] ? pi - turning_angle : pi + turning_angle);
  }
  return angles;
}

}  // namespace batten
