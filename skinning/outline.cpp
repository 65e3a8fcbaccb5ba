#include "batten/skinning/outline.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/words.h"
#include "batten/skinning/plain_fill.h"

namespace batten {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSamples = 48;  // segments of a piece in crossing tests and loop integrals

Vec3 start_of(const Stretch& s) { return s.curve->evaluate(s.curve->start()); }
Vec3 end_of(const Stretch& s) { return s.curve->evaluate(s.curve->end()); }

std::vector<Vec3> polyline(const InputCurve& curve) {
  std::vector<Vec3> points;
  for (int i = 0; i <= kSamples; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kSamples));
  return points;
}

// How far a curve may lie from the chords of its polyline.
double sag(const Vec3& a0, const Vec3& a1) { return 0.1 * (a1 - a0).norm(); }

// A polyline in boxes of eight chords each, and of all of them.
struct Boxed {
  static constexpr int chords = 8, count = kSamples / chords;
  struct Box {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    bool meets(const Box& other, double distance) const {
      return (low.array() <= other.high.array() + distance).all() &&
             (other.low.array() <= high.array() + distance).all();
    }
    void add(const Vec3& p, double around) {
      low = low.cwiseMin((p.array() - around).matrix());
      high = high.cwiseMax((p.array() + around).matrix());
    }
  };
  std::vector<Vec3> points;
  std::array<Box, count> part;
  Box all;

  explicit Boxed(const InputCurve& curve) : points(polyline(curve)) {
    for (int i = 0; i < kSamples; ++i)
      for (const int k : {i, i + 1}) {
        part[i / chords].add(points[k], sag(points[i], points[i + 1]));
        all.add(points[k], sag(points[i], points[i + 1]));
      }
  }
};

// Nearest points of two segments.
std::pair<double, Vec3> segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0,
                                         const Vec3& b1) {
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
  const Vec3 p = a0 + s * da, q = b0 + t * db;
  return {(p - q).norm(), 0.5 * (p + q)};
}

void require_not_on_one_line(const std::vector<Stretch>& stretches, double size) {
  std::vector<Vec3> points;
  for (const auto& s : stretches)
    for (const Vec3& p : polyline(*s.curve)) points.push_back(p);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points)
    covariance += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  const Vec3 spread = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues();
  if (std::sqrt(std::max(0.0, spread[1])) < 1e-7 * size)
    throw InputError("all outline lines lie on one straight line: they enclose no surface");
}

}  // namespace

namespace {

// Two polylines of different curves come near each other at these segments: the curves' own
// distance there, by Gauss-Newton on both parameters.
std::pair<double, Vec3> curve_distance(const InputCurve& a, int i, const InputCurve& b, int j) {
  const double step_a = (a.end() - a.start()) / kSamples, step_b = (b.end() - b.start()) / kSamples;
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

// Unit directions just before and just after the start of a piece.
std::pair<Vec3, Vec3> directions_at(const Outline& outline, size_t piece) {
  const size_t n = outline.pieces.size();
  const InputCurve &in = *outline.pieces[(piece + n - 1) % n].stretch.curve,
                   &out = *outline.pieces[piece].stretch.curve;
  return {in.evaluate(in.end(), 1).normalized(), out.evaluate(out.start(), 1).normalized()};
}

double turn_at(const Outline& outline, size_t piece) {
  const auto [a, b] = directions_at(outline, piece);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

namespace {

Crossing crossing_of(const InputCurve& a, const Boxed& of_a, const InputCurve& b, const Boxed& of_b,
                     double distance, const std::vector<Vec3>& common_ends, double skip) {
  if (!of_a.all.meets(of_b.all, distance)) return {};
  const auto &pa = of_a.points, &pb = of_b.points;
  for (int i = 0; i < kSamples; ++i) {
    const Boxed::Box& part = of_a.part[i / Boxed::chords];
    if (!part.meets(of_b.all, distance)) {
      i += Boxed::chords - 1 - i % Boxed::chords;
      continue;
    }
    for (int j = 0; j < kSamples; ++j) {
      if (j % Boxed::chords == 0 && !part.meets(of_b.part[j / Boxed::chords], distance)) {
        j += Boxed::chords - 1;
        continue;
      }
      const double near = sag(pa[i], pa[i + 1]) + sag(pb[j], pb[j + 1]);
      if (segment_distance(pa[i], pa[i + 1], pb[j], pb[j + 1]).first > distance + near) continue;
      const auto [d, where] = curve_distance(a, i, b, j);
      if (d > distance) continue;
      const Vec3 place = where;
      if (std::none_of(common_ends.begin(), common_ends.end(),
                       [&](const Vec3& e) { return (place - e).norm() < skip; }))
        return {true, place};
    }
  }
  return {};
}

}  // namespace

Crossing find_crossing(const InputCurve& a, const InputCurve& b, double distance,
                       const std::vector<Vec3>& common_ends, double skip) {
  return crossing_of(a, Boxed(a), b, Boxed(b), distance, common_ends, skip);
}

Crossing find_self_crossing(const InputCurve& a, double distance) {
  const auto p = polyline(a);
  const bool closed = (p.front() - p.back()).norm() <= distance;
  for (int i = 0; i < kSamples; ++i)
    for (int j = i + 4; j < kSamples; ++j) {
      if (closed && i + kSamples - j < 4) continue;
      const double near = sag(p[i], p[i + 1]) + sag(p[j], p[j + 1]);
      if (segment_distance(p[i], p[i + 1], p[j], p[j + 1]).first > distance + near) continue;
      if (const auto [d, where] = curve_distance(a, i, a, j); d <= distance) return {true, where};
    }
  return {};
}

namespace {

// The partner of each end where every stretch ends where the next one in the list begins, all
// around; else all -1. Two stretches may have two such orders, one stretch has one.
std::vector<int> listed_in_order(const std::vector<Vec3>& point, double join) {
  const int n = static_cast<int>(point.size()) / 2;
  const auto meet = [&](int a, int b) { return (point[a] - point[b]).norm() <= join; };
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
bool goes_on(const Outline& outline, size_t piece) {
  const size_t n = outline.pieces.size();
  const auto &before = outline.pieces[(piece + n - 1) % n], &after = outline.pieces[piece];
  const HermiteCurve &a = before.stretch.given->curve, &b = after.stretch.given->curve;
  const Vec3 in =
                 before.flipped ? Vec3(-a.slope_out(0)) : a.evaluate({a.segment_count() - 1, 1}, 1),
             out =
                 after.flipped ? Vec3(-b.evaluate({b.segment_count() - 1, 1}, 1)) : b.slope_out(0);
  constexpr double same = 1e-12;
  return (in - out).norm() <= same * in.norm();
}

}  // namespace

std::vector<Outline> make_loops(const std::vector<Stretch>& stretches, double size, double join,
                                double corner_angle, bool against_first) {
  if (stretches.empty()) throw InputError("a region needs outline lines, and there are none");
  require_not_on_one_line(stretches, size);
  for (const Stretch& s : stretches)
    if (static_cast<bool>(s.given) != static_cast<bool>(stretches[0].given))
      throw InputError("of lines '" + stretches[0].name + "' and '" + s.name +
                       "' around one region only one has a given curve: all have, or none");

  // Ends that meet: end 2i is the start of stretch i, 2i+1 its end.
  const int ends = 2 * static_cast<int>(stretches.size());
  std::vector<Vec3> point(ends);
  for (int i = 0; i < ends / 2; ++i) {
    point[2 * i] = start_of(stretches[i]);
    point[2 * i + 1] = end_of(stretches[i]);
  }
  const auto name_of = [&](int e) {
    return std::string(e % 2 ? "the end of '" : "the start of '") + stretches[e / 2].name + "'";
  };
  // A crossing explains a broken loop better than the break does.
  const auto report_crossings = [&] {
    std::vector<Boxed> boxed;
    for (const Stretch& s : stretches) boxed.emplace_back(*s.curve);
    for (size_t i = 0; i < stretches.size(); ++i) {
      if (const auto c = find_self_crossing(*stretches[i].curve, 1e-7 * size); c.found)
        throw InputError("line '" + stretches[i].name + "' crosses itself near " + at(c.where));
      for (size_t j = i + 1; j < stretches.size(); ++j) {
        std::vector<Vec3> common;
        for (const Vec3& p : {point[2 * i], point[2 * i + 1]})
          for (const Vec3& q : {point[2 * j], point[2 * j + 1]})
            if ((p - q).norm() <= join) common.push_back(p);
        const auto c = crossing_of(*stretches[i].curve, boxed[i], *stretches[j].curve, boxed[j],
                                   1e-7 * size, common, 0.02 * size);
        if (c.found)
          throw InputError("the outline crosses itself: lines '" + stretches[i].name + "' and '" +
                           stretches[j].name + "' cross or touch near " + at(c.where));
      }
    }
  };
  report_crossings();

  std::vector<int> partner =
      stretches[0].given ? listed_in_order(point, join) : std::vector<int>(point.size(), -1);
  for (int e = 0; e < ends && partner[e] < 0; ++e) {
    std::vector<int> near;
    int nearest = -1;
    double nearest_gap = std::numeric_limits<double>::infinity();
    for (int o = 0; o < ends; ++o) {
      if (o == e) continue;
      const double gap = (point[e] - point[o]).norm();
      if (gap <= join) near.push_back(o);
      if (gap < nearest_gap) {
        nearest_gap = gap;
        nearest = o;
      }
    }
    if (near.empty())
      throw InputError("the outline is open at " + name_of(e) + ", " + at(point[e]) + ": " +
                       (nearest < 0 ? "there is no other line"
                                    : "the nearest end, " + name_of(nearest) + ", is " +
                                          number(nearest_gap) + " away (ends meet within " +
                                          number(join) + ")"));
    if (near.size() > 1)
      throw InputError("more than two outline lines end at " + at(point[e]) + ": " + name_of(e) +
                       ", " + name_of(near[0]) + ", " + name_of(near[1]) + " (ends within " +
                       number(join) +
                       " of each other count as one: is the tolerance too large? Give inner lines "
                       "role = \"inner\"; branching outlines are not supported)");
    partner[e] = near[0];
  }

  std::vector<Outline> loops;
  std::vector<char> used(stretches.size(), 0);
  for (int first = 0; first < ends; first += 2) {
    if (used[static_cast<size_t>(first / 2)]) continue;
    Outline outline;
    outline.size = size;
    const int begin = first + (against_first && first == 0 ? 1 : 0);
    int end = begin;
    do {
      const bool flipped = end % 2 == 1;
      const Stretch& s = stretches[static_cast<size_t>(end / 2)];
      used[static_cast<size_t>(end / 2)] = 1;
      Outline::Piece piece{s, flipped, 0, 0.5 * (point[end] + point[partner[end]])};
      if (flipped) piece.stretch.curve = reversed(s.curve);
      piece.length = ArcLength(piece.stretch.curve).total();
      if (piece.length < 1e-9 * size) throw InputError("line '" + s.name + "' has zero length");
      outline.pieces.push_back(std::move(piece));
      end = partner[end ^ 1];
    } while (end != begin);
    for (size_t i = 0; i < outline.pieces.size(); ++i)
      if (outline.pieces[i].stretch.given ? !goes_on(outline, i)
                                          : turn_at(outline, i) > corner_angle * kPi / 180)
        outline.corners.push_back(static_cast<int>(i));
    loops.push_back(std::move(outline));
  }
  return loops;
}

bool Outline::is_corner(size_t piece) const {
  return std::find(corners.begin(), corners.end(), static_cast<int>(piece)) != corners.end();
}

Joint joint_at(const Outline& outline, size_t p) {
  const auto [in, out] = directions_at(outline, p);
  Joint joint{outline.pieces[p].start, out, in};
  if (!outline.is_corner(p)) joint.outgoing = joint.incoming = (in + out).normalized();
  return joint;
}

void warn_of_smoothed_joints(const Outline& outline, double corner_angle,
                             std::vector<std::string>& warnings) {
  const size_t n = outline.pieces.size();
  for (size_t p = 0; p < n; ++p) {
    if (outline.is_corner(p)) continue;
    const double turn = turn_at(outline, p) * 180 / kPi;
    constexpr double noticeable = 1;
    if (turn > noticeable)
      warnings.push_back("lines '" + outline.pieces[(p + n - 1) % n].stretch.name + "' and '" +
                         outline.pieces[p].stretch.name + "' meet at a kink of " + number(turn) +
                         " degrees, below corner_angle = " + number(corner_angle) +
                         ": it is rounded within the tolerance");
  }
}

Outline reversed(const Outline& outline) {
  const size_t n = outline.pieces.size();
  Outline back;
  back.size = outline.size;
  for (size_t i = n; i-- > 0;) {
    Outline::Piece piece = outline.pieces[i];
    piece.start = outline.end_of(i);
    piece.flipped = !piece.flipped;
    piece.stretch.curve = reversed(piece.stretch.curve);
    back.pieces.push_back(std::move(piece));
  }
  // Piece i began where piece n-1-i now ends.
  for (const int c : outline.corners)
    back.corners.push_back(static_cast<int>((n - static_cast<size_t>(c)) % n));
  std::sort(back.corners.begin(), back.corners.end());
  return back;
}

namespace {

// Whether the loop turns to the left at its corners: seen from its side where it is nearly plane,
// else as a filling has it (a strip around a cylinder faces all ways).
std::vector<char> left_at_corners(const Outline& outline) {
  const Vec3 normal = loop_normal(outline);
  const size_t n = outline.pieces.size();
  const int each = static_cast<int>(std::clamp<size_t>(64 / n, 2, 24));
  std::vector<Vec3> points;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& piece : outline.pieces) {
    const InputCurve& c = *piece.stretch.curve;
    for (int k = 0; k < each; ++k) {
      const Vec3 x =
          c.evaluate(c.start() + (c.end() - c.start()) * k / each) - outline.pieces[0].start;
      points.push_back(x / outline.size);
      low = std::min(low, points.back().dot(normal));
      high = std::max(high, points.back().dot(normal));
    }
  }
  constexpr double nearly_plane = 0.2;  // of the size
  constexpr size_t most_points = 400;
  std::optional<PlainFill> fill;
  if (high - low >= nearly_plane && points.size() <= most_points) fill = developable_fill(points);
  std::vector<FillCorner> of_fill;
  if (fill) of_fill = fill_corners(points, *fill);
  std::vector<char> left;
  for (const int c : outline.corners) {
    const auto piece = static_cast<size_t>(c);
    const auto [a, b] = directions_at(outline, piece);
    left.push_back(fill ? turns_left(a, b, of_fill[piece * static_cast<size_t>(each)])
                        : a.cross(b).dot(normal) >= 0);
  }
  return left;
}

}  // namespace

std::vector<double> corner_angles(const Outline& outline) {
  const std::vector<char> left = left_at_corners(outline);
  std::vector<double> angles;
  for (size_t i = 0; i < left.size(); ++i) {
    const auto [a, b] = directions_at(outline, static_cast<size_t>(outline.corners[i]));
    const double turn = std::atan2(a.cross(b).norm(), a.dot(b));
    angles.push_back(left[i] ? kPi - turn : kPi + turn);
  }
  return angles;
}

namespace {

Vec3 area_vector(const Outline& outline) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = outline.pieces[0].start;
  for (const auto& piece : outline.pieces) {
    const auto p = polyline(*piece.stretch.curve);
    for (int i = 0; i < kSamples; ++i) area += 0.5 * (p[i] - origin).cross(p[i + 1] - origin);
  }
  return area;
}

}  // namespace

double enclosed_area(const Outline& outline) { return area_vector(outline).norm(); }

bool encloses_area(const Outline& outline) {
  return area_vector(outline).norm() >= 1e-6 * outline.size * outline.size;
}

Vec3 loop_normal(const Outline& outline) {
  const Vec3 area = area_vector(outline);
  const double length = area.norm();
  if (!encloses_area(outline))
    throw InputError("the outline encloses no area seen from any side: it folds back on itself");
  return area / length;
}

}  // namespace batten
