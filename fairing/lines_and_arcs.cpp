#include "batten/fairing/lines_and_arcs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/format.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

constexpr double on_it = 5e-5;       // of the chord
constexpr double same_way = 0.5;     // degrees
constexpr double most_turn = 75;     // degrees, at a point of an arc
constexpr double most_uneven = 2.5;  // chords of an arc that few points tell

struct Circle {
  Vec3 centre, axis;  // points go around the axis counterclockwise
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

  // How far a run from i goes: point by point, later in steps that double and halve again, so that
  // thousands of points on one line take no time.
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

  // The last point of the straight run that begins at i; i itself if there is none.
  int straight_from(int i) {
    const int end = farthest(i, [this](int a, int b) { return is_straight(a, b); });
    if (end - i < 2) return i;
    const bool inflects = end - i == 2 && i > 0 && end < last_ && axis(i).dot(axis(end)) < 0;
    if (inflects) return i;
    // Dense points of any curve are nearly straight: a line turns at its ends, and nowhere else.
    double inside = 0, beside = 0;
    for (int k = i + 1; k < end; ++k) inside = std::max(inside, turning_angle(k));
    for (const int k : {i, end})
      if (k > 0 && k < last_) beside = std::max(beside, turning_angle(k));
    constexpr double least = 0.5;                         // degrees
    const double fraction = end - i == 2 ? 0.001 : 0.05;  // three points are soon nearly on a line
    if (beside > least && inside < fraction * beside) return end;
    // What begins later on the same line ends there too.
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
      if (turning_angle(i) > most_turn || axis(i).dot(circle->axis) <= 0) return false;
    }
    return true;
  }

  int arc_from(int i) {
    const int end = farthest(i, [this](int a, int b) { return is_arc(a, b); });
    constexpr int sure = 4;  // chords
    if (end - i < 2) return i;
    if (!ends_bending(i, end)) {
      // What begins later on it bends as much at its beginning as behind.
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
  // Dense points of any curve are nearly on a circle. An arc bends as much at all its points, and
  // otherwise at its ends.
  bool ends_bending(int a, int b) const {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (int k = a + 1; k < b; ++k) {
      least = std::min(least, curvature_at(k));
      most = std::max(most, curvature_at(k));
    }
    constexpr double even = 1.02, other = 0.2;  // ratio; share
    if (most > even * least) return false;
    for (const int k : {a, b})
      if (k > 0 && k < last_ && std::abs(curvature_at(k) / most - 1) < other) return false;
    return true;
  }

  // Whether few points are an arc: all there are, or one that goes on along both chords beside it.
  bool is_certain_arc(int a, int b) const {
    for (int i = a; i + 1 < b; ++i)
      if (std::max(chord(i), chord(i + 1)) > most_uneven * std::min(chord(i), chord(i + 1)))
        return false;
    if (a == 0 && b == last_) return true;
    constexpr double clear = 10;  // degrees: chords of dense points always leave along each other
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

  // Where two runs share a point they have one tangent, or the longer one leaves a chord to what is
  // between them.
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
  int next_line_start_ = 0, next_arc_start_ = 0;  // such runs begin there or later
  std::vector<LineOrArc> pieces_;
};

}  // namespace

std::vector<LineOrArc> find_lines_and_arcs(const std::vector<Vec3>& points) {
  return LineArcSearch(points).run();
}

}  // namespace batten
