#include "batten/skinning/domains/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/dense.h"
#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/skinning/domains/curve_crossing.h"

namespace batten {
namespace {

using std::numbers::pi;

void require_not_on_one_line(const std::vector<SmoothSegment>& segments, double size) {
  std::vector<Vec3> points;
  for (const auto& s : segments)
    for (const Vec3& p : polyline(*s.curve)) points.push_back(p);
  const double across = principal_axes(points).values[1] / static_cast<double>(points.size());
  if (std::sqrt(std::max(0.0, across)) < 1e-7 * size)
    throw InputError("all outline lines lie on one straight line: they enclose no surface");
}

// Unit directions just before and just after the start of a piece.
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

// The partner of each end where every stretch ends where the next one in the list begins, all
// around; else all -1. Two stretches may have two such orders, one stretch has one.
std::vector<int> partners_in_listed_order(const std::vector<Vec3>& point, double gap_tolerance) {
  const int n = isize(point) / 2;
  const auto meet = [&](int a, int b) { return (point[a] - point[b]).norm() <= gap_tolerance; };
  for (const int first : {0, 1}) {
    std::vector<int> partner(point.size(), -1);
    int entry = first;  // the end at which the loop enters stretch i
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

// Whether the given curve that ends where a piece begins has the same slope as that one.
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
      throw InputError("of lines '" + segments[0].name + "' and '" + s.name +
                       "' around one region only one has a given curve: all have, or none");
}

// Joins stretches at their ends: end 2i is the start of stretch i, 2i+1 its end.
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
        throw InputError("line '" + segments_[i].name + "' crosses itself near " +
                         format_point(c.where));
      for (size_t j = i + 1; j < segments_.size(); ++j)
        if (const auto c = boxed[i].crossing(boxed[j], near, common_ends(i, j), 0.02 * size_);
            c.found)
          throw InputError("the outline crosses itself: lines '" + segments_[i].name + "' and '" +
                           segments_[j].name + "' cross or touch near " + format_point(c.where));
    }
  }

  // The end that meets each end.
  std::vector<int> partners() const {
    std::vector<int> partner = segments_[0].prescribed
                                   ? partners_in_listed_order(point_, gap_tolerance_)
                                   : std::vector<int>(point_.size(), -1);
    for (int e = 0; e < isize(point_) && partner[e] < 0; ++e) partner[e] = unique_partner(e);
    return partner;
  }

  // The loop that begins at an end.
  Outline loop(int begin, const std::vector<int>& partner, std::vector<char>& used) const {
    Outline outline;
    outline.size = size_;
    int end = begin;
    do {
      const bool flipped = end % 2 == 1;
      const SmoothSegment& s = segments_[end / 2];
      used[end / 2] = 1;
      Outline::OrientedSegment piece{s, flipped, 0, 0.5 * (point_[end] + point_[partner[end]])};
      if (flipped) piece.segment.curve = reversed(s.curve);
      piece.length = ArcLength(piece.segment.curve).total();
      if (piece.length < 1e-9 * size_) throw InputError("line '" + s.name + "' has zero length");
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
      throw InputError("the outline is open at " + name_of(end) + ", " + format_point(point_[end]) +
                       ": " +
                       (nearest < 0 ? "there is no other line"
                                    : "the nearest end, " + name_of(nearest) + ", is " +
                                          format_number(nearest_gap) + " away (ends meet within " +
                                          format_number(gap_tolerance_) + ")"));
    if (near.size() > 1)
      throw InputError("more than two outline lines end at " + format_point(point_[end]) + ": " +
                       name_of(end) + ", " + name_of(near[0]) + ", " + name_of(near[1]) +
                       " (ends within " + format_number(gap_tolerance_) +
                       " of each other count as one: is the tolerance too large? Give inner lines "
                       "role = \"inner\"; branching outlines are not supported)");
    return near[0];
  }

  const std::vector<SmoothSegment>& segments_;
  double size_, gap_tolerance_;
  std::vector<Vec3> point_;  // of each end
};

}  // namespace

std::vector<Outline> make_loops(const std::vector<SmoothSegment>& segments, double size,
                                double gap_tolerance, double corner_angle,
                                bool reverse_orientation) {
  if (segments.empty()) throw InputError("a region needs outline lines, and there are none");
  require_not_on_one_line(segments, size);
  require_all_or_none_prescribed(segments);
  const LoopBuilder builder(segments, size, gap_tolerance);
  // A crossing explains a broken loop better than the break does.
  builder.require_no_crossings();
  const std::vector<int> partner = builder.partners();

  std::vector<Outline> loops;
  std::vector<char> used(segments.size(), 0);
  for (size_t first = 0; first < segments.size(); ++first) {
    if (used[first]) continue;
    const int begin = 2 * static_cast<int>(first) + (reverse_orientation && first == 0 ? 1 : 0);
    Outline outline = builder.loop(begin, partner, used);
    for (size_t i = 0; i < outline.segments.size(); ++i)
      if (outline.segments[i].segment.prescribed
              ? !continues_smoothly(outline, i)
              : turning_angle_at(outline, i) > corner_angle * pi / 180)
        outline.corners.push_back(static_cast<int>(i));
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
      warnings.push_back("lines '" + outline.segments[(p + n - 1) % n].segment.name + "' and '" +
                         outline.segments[p].segment.name + "' meet at a kink of " +
                         format_number(turning_angle) + " degrees, below corner_angle = " +
                         format_number(corner_angle) + ": it is rounded within the tolerance");
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
  // Piece i began where piece n-1-i now ends.
  for (const int c : outline.corners)
    back.corners.push_back(static_cast<int>((n - static_cast<size_t>(c)) % n));
  std::sort(back.corners.begin(), back.corners.end());
  return back;
}

}  // namespace batten
