// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/crossing_corners.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/scenes/lines/line_corners.h"

namespace batten {

namespace {

/// A curve as a polyline, to find the points near it.
struct CurveTrace {
  std::vector<Vec3> points;
  Box3 box;

  double distance(const Vec3& p) const {
    double best = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i + 1 < points.size(); ++i) {
      const Vec3 d = points[i + 1] - points[i];
      const double t = std::clamp((p - points[i]).dot(d) / d.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (p - points[i] - t * d).norm());
    }
    return best;
  }
};

/// A point of one line through which another line passes.
struct LineCrossing {
  int line, point, other;
  bool is_corner;  ///< whatever other lines have there
};

class CrossingCorners {
 public:
  CrossingCorners(std::vector<SourceLine>& lines, double corner_angle)
      : lines_(lines), corner_angle_(corner_angle) {}

  void find() {
    if (lines_.size() < 2 || std::none_of(lines_.begin(), lines_.end(), has_open_corners) ||
        !make_traces())
      return;
    for (int i = 0; i < isize(lines_); ++i)
      if (has_open_corners(lines_[i])) find_at(i);
    for (int other = 0; other < isize(lines_); ++other) mark_crease(other);
    for (SourceLine& line : lines_)
      line.crossing_corners = sorted_unique(std::move(line.crossing_corners));
  }

 private:
  static bool has_open_corners(const SourceLine& line) {
    return line.points.size() > 2 && !line.corners && line.vertices == SourceLine::Vertices::Points;
  }

  // False if a line is not usable, which is reported where it is used.
  bool make_traces() {
    Box3 box;
    for (const SourceLine& line : lines_) {
      CurveTrace& trace = traces_.emplace_back();
      try {
        const auto curve = curves_.emplace_back(line.as_curve(corner_angle_));
        constexpr int per_piece = 16;
        const std::vector<double> t = curve->breaks();
        for (size_t i = 0; i + 1 < t.size(); ++i)
          for (int k = 0; k < per_piece; ++k)
            trace.points.push_back(
                curve->evaluate(std::lerp(t[i], t[i + 1], static_cast<double>(k) / per_piece)));
        trace.points.push_back(curve->evaluate(curve->end()));
      } catch (const InputError&) {
        return false;
      }
      trace.box = bounding_box(trace.points);
      box.extend(trace.box);
    }
    near_ = 1e-4 * box.diagonal().norm();
    return true;
  }

  // The turning angle at a point of a line; 0 at the ends of an open one.
  static double turning_angle(const std::vector<Vec3>& p, bool closed, int i) {
    const int count = isize(p) - (closed ? 1 : 0);
    if (!closed && (i <= 0 || i + 1 >= count)) return 0;
    const auto at = [&](int k) -> const Vec3& { return p[((k % count) + count) % count]; };
    return degrees_between(at(i) - at(i - 1), at(i + 1) - at(i));
  }

  // True if the line has a corner at a point by the turning angles of the line itself.
  bool has_corner(int line, int point) const {
    const std::vector<double> t = curves_[line]->breaks(), corners = curves_[line]->corners();
    return std::binary_search(corners.begin(), corners.end(), t.at(static_cast<size_t>(point)));
  }

  void find_at(int line) {
    const std::vector<Vec3>& p = lines_[line].points;
    const bool closed = is_closed_polyline(p);
    for (int i = 1; i + 1 < isize(p); ++i) {
      const double here = turning_angle(p, closed, i);
      const double beside =
          std::max(turning_angle(p, closed, i - 1), turning_angle(p, closed, i + 1));
      if (here < kLeastTurn || here < 2 * beside) continue;
      // Beside a single chord, turning angles alone do not tell a corner from an arc.
      const bool at_end = !closed && (i == 1 || i + 2 == isize(p));
      const bool is_corner =
          has_corner(line, i) || (at_end && here >= kCertainTurn && here >= 3 * beside);
      for (int other = 0; other < isize(lines_); ++other)
        if (other != line && traces_[other].box.exteriorDistance(p[i]) <= near_ &&
            traces_[other].distance(p[i]) <= near_)
          crossings_.push_back({line, i, other, is_corner});
    }
  }

  // Marks the corners along a line that half of the lines across it, or more, make a crease.
  void mark_crease(int other) {
    int corners = 0, all = 0;
    for (const LineCrossing& c : crossings_)
      if (c.other == other) {
        ++all;
        corners += c.is_corner;
      }
    if (2 * corners < all) return;
    for (const LineCrossing& c : crossings_)
      if (c.other == other) lines_[c.line].crossing_corners.push_back(c.point);
  }

  static constexpr double kLeastTurn = 20, kCertainTurn = 45;  // degrees

  std::vector<SourceLine>& lines_;
  double corner_angle_, near_ = 0;
  std::vector<std::shared_ptr<const InputCurve>> curves_;
  std::vector<CurveTrace> traces_;
  std::vector<LineCrossing> crossings_;
};

}  // namespace

void find_crossing_corners(std::vector<SourceLine>& lines, double corner_angle) {
  if (corner_angle < 180) CrossingCorners(lines, corner_angle).find();
}

}  // namespace batten
