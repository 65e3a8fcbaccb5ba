// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/curve_through_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/corners.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fem/curves/cubic.h"

namespace batten {
namespace {

// A part of a curve between corners: parameter lengths of its pieces, slopes at its points.
struct SmoothSegment {
  std::vector<double> lengths;
  Points slopes;
};

// Parameter length for which the cubic between two points with unit slopes that turn by `angle`
// approximates an arc, to 4e-6 of the radius at 45 degrees.
double arc_length(double chord, double angle) { return chord / std::pow(std::cos(angle / 4), 2); }

// Interpolates one part: lines and arcs keep their tangents, and splines continue them in between.
// `closed`: the first point is the last, and a run begins there.
SmoothSegment interpolate_segment(const std::vector<Vec3>& p, const std::vector<LineOrArc>& runs,
                                  bool closed) {
  const long n = std::ssize(p);
  SmoothSegment part;
  Points x(n, 3);
  part.slopes.resize(n, 3);
  std::vector<char> given(n, 0);
  for (long i = 0; i < n; ++i) x.row(i) = p[i];
  for (const LineOrArc& run : runs)
    for (int i = run.first; i <= run.last; ++i) {
      part.slopes.row(i) = run.tangents[static_cast<size_t>(i - run.first)];
      given[i] = 1;
    }
  if (closed && !given[n - 1]) {
    part.slopes.row(n - 1) = part.slopes.row(0);
    given[n - 1] = 1;
  }
  std::vector<double> u{0};
  for (long i = 0; i + 1 < n; ++i) {
    const bool both = given[i] && given[i + 1];
    const double angle =
        both ? std::atan2(Vec3(part.slopes.row(i)).cross(Vec3(part.slopes.row(i + 1))).norm(),
                          part.slopes.row(i).dot(part.slopes.row(i + 1)))
             : 0;
    part.lengths.push_back(arc_length((p[i + 1] - p[i]).norm(), angle));
    u.push_back(u.back() + part.lengths.back());
  }
  for (long i = 0; i + 1 < n;) {
    long end = i + 1;
    if (!given[i] || !given[end]) {
      while (end + 1 < n && !given[end]) ++end;
      // At open ends the curvature is that of the adjacent points.
      const auto end_at = [&](long node) {
        return given[node] ? SplineEnd::Given : SplineEnd::Parabolic;
      };
      spline_slopes({u.begin() + i, u.begin() + end + 1}, x.middleRows(i, end + 1 - i), end_at(i),
                    end_at(end), part.slopes.middleRows(i, end + 1 - i));
    }
    i = end;
  }
  return part;
}

// Builds a curve with these corners, each of which has two slopes. It is open, or closed if its
// last point, which equals its first, is no corner.
class CurveBuilder {
 public:
  CurveBuilder(std::vector<Vec3> points, std::vector<int> corners, bool closed)
      : p_(std::move(points)), corners_(std::move(corners)), closed_(closed) {}

  std::optional<HermiteCurve> make() {
    const int last = isize(p_) - 1;
    u_ = {0};
    std::vector<int> ends = corners_;
    if (!closed_) ends.insert(ends.begin(), 0);
    if (!closed_) ends.push_back(last);
    if (closed_ && corners_.empty()) {
      if (!closed_segment()) return std::nullopt;
    } else {
      for (size_t c = 0; c + 1 < ends.size(); ++c) part(ends[c], ends[c + 1]);
      if (closed_) part(ends.back(), ends.front() + last);
    }
    for (const double length : lengths_) u_.push_back(u_.back() + length);
    const CurveMesh mesh(u_, closed_, corners_);
    Points dofs(mesh.dof_count(), 3);
    for (int i = 0; i < mesh.node_count(); ++i) {
      dofs.row(mesh.position_dof(i)) = p_[static_cast<size_t>(i)];
      dofs.row(mesh.slope_in(i)) = in_.row(i == 0 && closed_ ? last : i);
      if (i < last) dofs.row(mesh.slope_out(i)) = out_.row(i);
    }
    return HermiteCurve(mesh, std::move(dofs));
  }

 private:
  void prepare() {
    if (!lengths_.empty()) return;
    lengths_.resize(p_.size() - 1);
    in_.setZero(std::ssize(p_), 3);
    out_.setZero(std::ssize(p_), 3);
  }
  int around(int i) const {
    const int last = isize(p_) - 1;
    return i > last ? i - last : i;
  }

  // Stores the part between points a and b, which may cross the seam.
  void put(int a, const SmoothSegment& part) {
    prepare();
    const int last = isize(p_) - 1;
    for (int k = 0; k < isize(part.lengths); ++k) {
      const int piece = (a + k) % last;
      lengths_[static_cast<size_t>(piece)] = part.lengths[static_cast<size_t>(k)];
      out_.row(piece) = part.slopes.row(k);
      in_.row(piece + 1) = part.slopes.row(k + 1);
    }
  }
  std::vector<Vec3> points(int a, int b) const {
    std::vector<Vec3> part;
    for (int i = a; i <= b; ++i) part.push_back(p_[static_cast<size_t>(around(i))]);
    return part;
  }
  void part(int a, int b) {
    const std::vector<Vec3> row = points(a, b);
    put(a, interpolate_segment(row, find_lines_and_arcs(row), false));
  }

  // Handles a loop without corners that contains a line or an arc; returns false if there is none.
  bool closed_segment() {
    const int last = isize(p_) - 1;
    const std::vector<LineOrArc> runs = find_lines_and_arcs(p_);
    if (runs.empty()) return false;
    // Starts at the beginning of a run that does not continue across the seam.
    const int a = runs.size() > 1 ? runs[1].first : runs[0].first;
    const std::vector<Vec3> row = points(a, a + last);
    std::vector<LineOrArc> again = find_lines_and_arcs(row);
    if (again.empty() || again.front().first != 0) return false;
    if (again.back().last == last) again.front().tangents.front() = again.back().tangents.back();
    put(a, interpolate_segment(row, again, true));
    return true;
  }

  std::vector<Vec3> p_;
  std::vector<int> corners_;
  bool closed_;
  std::vector<double> u_, lengths_;
  Points in_, out_;
};

// Given or detected corners, ascending; 0 stands for the seam of a closed list.
std::vector<int> corners_among(const std::string& name, const std::vector<Vec3>& points,
                               bool is_closed, double corner_angle,
                               const std::optional<std::vector<int>>& corners) {
  if (!corners) {
    std::vector<Vec3> row = points;
    if (is_closed) row.pop_back();
    return find_corners(row, is_closed, corner_angle);
  }
  const int last = isize(points) - 1;
  std::vector<int> all;
  for (const int c : *corners) {
    if (c < 0 || c > last)
      throw InputError("curve '" + name + "': found a corner at point " + std::to_string(c + 1) +
                       ", expected 1 to " + std::to_string(last + 1));
    if (is_closed || (c > 0 && c < last)) all.push_back(c == last ? 0 : c);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

std::shared_ptr<const InputCurve> curve_through_points(
    const std::string& name, const std::vector<Vec3>& points, double corner_angle,
    const std::optional<std::vector<int>>& corners) {
  const auto n = static_cast<long>(points.size());
  if (n < 2)
    throw InputError("curve '" + name + "' has " + std::to_string(n) + " point" +
                     (n == 1 ? "" : "s") + ", expected two or more");
  for (long i = 0; i < n; ++i)
    if (!points[i].allFinite())
      throw InputError("curve '" + name + "', point " + std::to_string(i + 1) +
                       ": a coordinate is not a finite number");
  const double size = bounding_box(points).diagonal().norm();
  if (!(size > 0)) throw InputError("curve '" + name + "' has zero length: all points coincide");
  for (long i = 0; i + 1 < n; ++i)
    if ((points[i + 1] - points[i]).norm() < 1e-9 * size)
      throw InputError("curve '" + name + "', points " + std::to_string(i + 1) + " and " +
                       std::to_string(i + 2) + " are duplicates at " + format_point(points[i]) +
                       (n == 2 ? ": the curve has zero length" : ""));
  const bool is_closed = n > 3 && (points.front() - points.back()).norm() < 1e-9 * size;
  std::vector<int> found = corners_among(name, points, is_closed, corner_angle, corners);
  // If the seam is a corner, the curve is treated as an open one that ends where it starts.
  const bool closed = is_closed && (found.empty() || found.front() != 0);
  std::erase(found, 0);
  if (auto curve = CurveBuilder(points, found, closed).make())
    return curve_from_hermite(std::move(*curve));
  FairOptions options;
  options.closed = true;
  options.corners.emplace();
  return curve_from_hermite(interpolating_spline(name, points, options));
}

namespace {

constexpr double on_it = 5e-5;          // distance from a line or arc, as a fraction of the chord
constexpr double same_way = 0.5;        // angle between directions that count as equal, degrees
constexpr double kMaxTurn = 75;         // largest turning angle at a point of an arc, degrees
constexpr double kMaxChordRatio = 2.5;  // largest ratio of adjacent chords, for arcs of few points

struct Circle {
  Vec3 centre, axis;  // the points run counter-clockwise about the axis
  double radius = 0;
  Vec3 tangent(const Vec3& p) const { return axis.cross(p - centre).normalized(); }
};

std::optional<Circle> circle_through(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  if (!(normal.norm() > 1e-9 * ab.norm() * ac.norm())) return std::nullopt;
  const Vec3 to_centre =
      (normal.cross(ab) * ac.squaredNorm() + ac.cross(normal) * ab.squaredNorm()) /
      (2 * normal.squaredNorm());
  return Circle{a + to_centre, normal.normalized(), to_centre.norm()};
}

class LineArcSearch {
 public:
  explicit LineArcSearch(const std::vector<Vec3>& points) : p_(points), last_(isize(points) - 1) {}

  std::vector<LineOrArc> run() {
    for (int i = 0; i + 2 <= last_;) {
      const int straight = i >= next_line_start_ ? straight_from(i) : i;
      const int arc = straight > i || i < next_arc_start_ ? i : arc_from(i);
      const int end = std::max(straight, arc);
      if (end == i) {
        ++i;
        continue;
      }
      add(i, end, straight > i);
      i = end;
    }
    match_tangents();
    return std::move(pieces_);
  }

 private:
  double turning_angle(int i) const {
    return degrees_between(p_[i] - p_[i - 1], p_[i + 1] - p_[i]);
  }
  Vec3 axis(int i) const { return (p_[i] - p_[i - 1]).cross(p_[i + 1] - p_[i]); }
  double chord(int i) const { return (p_[i + 1] - p_[i]).norm(); }

  bool is_straight(int a, int b) const {
    const Vec3 chord_direction = (p_[b] - p_[a]).normalized();
    double before = 0;
    for (int i = a + 1; i <= b; ++i) {
      const Vec3 d = p_[i] - p_[a];
      const double along = d.dot(chord_direction);
      if (!(along > before) ||
          (d - along * chord_direction).norm() > on_it * (p_[b] - p_[a]).norm())
        return false;
      before = along;
    }
    return true;
  }

  // Last index of a run that starts at i. Extends it point by point, then by doubling and halving
  // steps, so that thousands of collinear points take no time.
  template <class Fits>
  int farthest(int i, const Fits& fits) const {
    int end = i + 1;
    constexpr int one_by_one = 16;
    while (end < last_ && end - i < one_by_one && fits(i, end + 1)) ++end;
    if (end - i < one_by_one) return end;
    int step = 1;
    for (; end + step <= last_ && fits(i, end + step); step *= 2) end += step;
    for (; step > 0; step /= 2)
      if (end + step <= last_ && fits(i, end + step)) end += step;
    return end;
  }

  // Last point of the straight run that begins at i; i itself if there is none.
  int straight_from(int i) {
    const int end = farthest(i, [this](int a, int b) { return is_straight(a, b); });
    if (end - i < 2) return i;
    const bool inflects = end - i == 2 && i > 0 && end < last_ && axis(i).dot(axis(end)) < 0;
    if (inflects) return i;
    // Dense points of any curve are nearly straight: a line turns at its ends and nowhere else.
    double inside = 0, beside = 0;
    for (int k = i + 1; k < end; ++k) inside = std::max(inside, turning_angle(k));
    for (const int k : {i, end})
      if (k > 0 && k < last_) beside = std::max(beside, turning_angle(k));
    constexpr double least = 0.5;                         // degrees
    const double fraction = end - i == 2 ? 0.001 : 0.05;  // three points are easily collinear
    if (beside > least && inside < fraction * beside) return end;
    // Runs that begin later on the same line end there too.
    next_line_start_ = std::max(next_line_start_, end - 1);
    return i;
  }

  bool is_arc(int a, int b) const {
    const auto circle = circle_through(p_[a], p_[(a + b) / 2], p_[b]);
    if (!circle) return false;
    const double near =
        on_it * std::min((p_[b] - p_[a]).norm() + circle->radius, 4 * circle->radius);
    for (int i = a; i <= b; ++i) {
      const Vec3 d = p_[i] - circle->centre;
      const double out = d.dot(circle->axis);
      if (std::abs(out) > near || std::abs(d.norm() - circle->radius) > near) return false;
      if (i == a || i == b) continue;
      if (turning_angle(i) > kMaxTurn || axis(i).dot(circle->axis) <= 0) return false;
    }
    return true;
  }

  int arc_from(int i) {
    const int end = farthest(i, [this](int a, int b) { return is_arc(a, b); });
    constexpr int sure = 4;  // chords
    if (end - i < 2) return i;
    if (!ends_bending(i, end)) {
      // Runs that begin later on it have the same curvature at their beginning as behind.
      next_arc_start_ = std::max(next_arc_start_, end - 1);
      return i;
    }
    return end - i >= sure || is_certain_arc(i, end) ? end : i;
  }

  // Curvature of the circle through a point and its neighbours.
  double curvature_at(int i) const {
    const Vec3 a = p_[i] - p_[i - 1], b = p_[i + 1] - p_[i];
    return 2 * a.cross(b).norm() / (a.norm() * b.norm() * (a + b).norm());
  }
  // Dense points of any curve are nearly on a circle. An arc has the same curvature at all of its
  // points and a different one at its ends.
  bool ends_bending(int a, int b) const {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (int k = a + 1; k < b; ++k) {
      least = std::min(least, curvature_at(k));
      most = std::max(most, curvature_at(k));
    }
    constexpr double even = 1.02, other = 0.2;  // ratio; fraction
    if (most > even * least) return false;
    for (const int k : {a, b})
      if (k > 0 && k < last_ && std::abs(curvature_at(k) / most - 1) < other) return false;
    return true;
  }

  // True if few points are an arc: the whole sequence, or tangent to both adjacent chords.
  bool is_certain_arc(int a, int b) const {
    for (int i = a; i + 1 < b; ++i)
      if (std::max(chord(i), chord(i + 1)) > kMaxChordRatio * std::min(chord(i), chord(i + 1)))
        return false;
    if (a == 0 && b == last_) return true;
    constexpr double clear = 10;  // degrees: chords of dense points are always tangent
    for (int i = a + 1; i < b; ++i)
      if (turning_angle(i) < clear) return false;
    const Circle circle = *circle_through(p_[a], p_[(a + b) / 2], p_[b]);
    const bool before =
                   a == 0 || degrees_between(p_[a] - p_[a - 1], circle.tangent(p_[a])) < same_way,
               behind = b == last_ ||
                        degrees_between(p_[b + 1] - p_[b], circle.tangent(p_[b])) < same_way;
    return before && behind;
  }

  void add(int a, int b, bool straight) {
    LineOrArc run{a, b, {}};
    if (straight) {
      run.tangents.assign(static_cast<size_t>(b - a) + 1, (p_[b] - p_[a]).normalized());
    } else {
      const Circle circle = *circle_through(p_[a], p_[(a + b) / 2], p_[b]);
      for (int i = a; i <= b; ++i) run.tangents.push_back(circle.tangent(p_[i]));
    }
    pieces_.push_back(std::move(run));
  }

  // Gives two runs that share a point the same tangent there. If their tangents differ, the longer
  // run gives up its last chord to the spline in between.
  void match_tangents() {
    for (size_t k = 0; k + 1 < pieces_.size(); ++k) {
      LineOrArc &a = pieces_[k], &b = pieces_[k + 1];
      if (a.last != b.first) continue;
      Vec3 &before = a.tangents.back(), &behind = b.tangents.front();
      if (degrees_between(before, behind) < same_way) {
        before = behind = (before + behind).normalized();
      } else if (a.tangents.size() > b.tangents.size()) {
        a.tangents.pop_back();
        --a.last;
      } else {
        b.tangents.erase(b.tangents.begin());
        ++b.first;
      }
    }
  }

  const std::vector<Vec3>& p_;
  int last_;
  int next_line_start_ = 0, next_arc_start_ = 0;  // such runs cannot begin earlier
  std::vector<LineOrArc> pieces_;
};

}  // namespace

std::vector<LineOrArc> find_lines_and_arcs(const std::vector<Vec3>& points) {
  return LineArcSearch(points).run();
}

Points not_a_knot_slopes(const std::vector<double>& u, const Points& x) {
  const long n = x.rows();
  if (n == 2) return (x.row(1) - x.row(0)).replicate(2, 1) / (u[1] - u[0]);
  MatX A = MatX::Zero(n, n);
  Points b = Points::Zero(n, 3);
  const auto step = [&](long i) {
    return u[static_cast<size_t>(i) + 1] - u[static_cast<size_t>(i)];
  };
  // Rows of the system: continuity of the second derivative.
  for (long i = 1; i + 1 < n; ++i)
    for (const long s : {i - 1, i}) {
      const double h = step(s);
      A(i, i) += 2 / h;
      A(i, 2 * s + 1 - i) += 1 / h;
      b.row(i) += 3 / (h * h) * (x.row(s + 1) - x.row(s));
    }
  // Adds the third derivative on segment s: x_uuu = 6 (m0 + m1)/h² - 12 (x1 - x0)/h³.
  const auto add_third = [&](long row, long s, double sign) {
    const double h = step(s);
    A(row, s) += sign * 6 / (h * h);
    A(row, s + 1) += sign * 6 / (h * h);
    b.row(row) += sign * 12 / (h * h * h) * (x.row(s + 1) - x.row(s));
  };
  add_third(0, 0, 1);
  add_third(n - 1, n - 2, 1);
  if (n > 3) {
    add_third(0, 1, -1);
    add_third(n - 1, n - 3, -1);
  }
  return solve_square(A, b);
}

}  // namespace batten
