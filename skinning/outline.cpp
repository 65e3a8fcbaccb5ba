#include "batten/skinning/outline.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"

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

// How far a curve may lie from the chords of its polyline.
double sag(const Vec3& a0, const Vec3& a1) { return 0.1 * (a1 - a0).norm(); }

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

Crossing find_crossing(const InputCurve& a, const InputCurve& b, double distance,
                       const std::vector<Vec3>& common_ends, double skip) {
  const auto pa = polyline(a), pb = polyline(b);
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const double near = sag(pa[i], pa[i + 1]) + sag(pb[j], pb[j + 1]);
      if (segment_distance(pa[i], pa[i + 1], pb[j], pb[j + 1]).first > distance + near) continue;
      const auto [d, where] = curve_distance(a, i, b, j);
      if (d > distance) continue;
      const Vec3 place = where;
      if (std::none_of(common_ends.begin(), common_ends.end(),
                       [&](const Vec3& e) { return (place - e).norm() < skip; }))
        return {true, place};
    }
  return {};
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

std::vector<Outline> make_loops(const std::vector<Stretch>& stretches, double size, double join,
                                double corner_angle) {
  if (stretches.empty()) throw InputError("a region needs outline lines, and there are none");
  require_not_on_one_line(stretches, size);

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
    for (size_t i = 0; i < stretches.size(); ++i) {
      if (const auto c = find_self_crossing(*stretches[i].curve, 1e-7 * size); c.found)
        throw InputError("line '" + stretches[i].name + "' crosses itself near " + at(c.where));
      for (size_t j = i + 1; j < stretches.size(); ++j) {
        std::vector<Vec3> common;
        for (const Vec3& p : {point[2 * i], point[2 * i + 1]})
          for (const Vec3& q : {point[2 * j], point[2 * j + 1]})
            if ((p - q).norm() <= join) common.push_back(p);
        const auto c = find_crossing(*stretches[i].curve, *stretches[j].curve, 1e-7 * size, common,
                                     0.02 * size);
        if (c.found)
          throw InputError("the outline crosses itself: lines '" + stretches[i].name + "' and '" +
                           stretches[j].name + "' cross or touch near " + at(c.where));
      }
    }
  };
  report_crossings();

  std::vector<int> partner(ends, -1);
  for (int e = 0; e < ends; ++e) {
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
    int end = first;
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
    } while (end != first);
    for (size_t i = 0; i < outline.pieces.size(); ++i)
      if (turn_at(outline, i) > corner_angle * kPi / 180)
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

std::vector<double> corner_angles(const Outline& outline) {
  const Vec3 normal = loop_normal(outline);
  std::vector<double> angles;
  for (const int c : outline.corners) {
    const auto [a, b] = directions_at(outline, static_cast<size_t>(c));
    const double turn = std::atan2(a.cross(b).norm(), a.dot(b));
    angles.push_back(a.cross(b).dot(normal) >= 0 ? kPi - turn : kPi + turn);
  }
  return angles;
}

Vec3 loop_normal(const Outline& outline) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = outline.pieces[0].start;
  for (const auto& piece : outline.pieces) {
    const auto p = polyline(*piece.stretch.curve);
    for (int i = 0; i < kSamples; ++i) area += 0.5 * (p[i] - origin).cross(p[i + 1] - origin);
  }
  const double length = area.norm();
  if (length < 1e-6 * outline.size * outline.size)
    throw InputError("the outline encloses no area seen from any side: it folds back on itself");
  return area / length;
}

// --- polygon
// --------------------------------------------------------------------------------------

namespace {

bool simple_and_ccw(const std::vector<Vec2>& p) {
  const size_t n = p.size();
  double area = 0;
  for (size_t i = 0; i < n; ++i) area += 0.5 * cross(p[i], p[(i + 1) % n]);
  if (!(area > 0)) return false;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j) {
      if (j == i + 1 || (i == 0 && j + 1 == n)) continue;
      const Vec2 &a = p[i], &b = p[(i + 1) % n], &c = p[j], &d = p[(j + 1) % n];
      if (cross(b - a, c - a) * cross(b - a, d - a) <= 0 &&
          cross(d - c, a - c) * cross(d - c, b - c) <= 0)
        return false;
    }
  return true;
}

double interior_angle(const std::vector<Vec2>& p, size_t i) {
  const size_t n = p.size();
  const Vec2 a = p[i] - p[(i + n - 1) % n], b = p[(i + 1) % n] - p[i];
  return kPi - std::atan2(cross(a, b), a.dot(b));
}

}  // namespace

std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal) {
  const size_t n = lengths.size();
  constexpr double length_weight = 1, angle_weight = 0.7, distance_weight = 0.25;
  constexpr size_t most_distances = 24;  // with more corners, lengths and angles say enough

  std::vector<std::vector<Vec2>> starts(2);
  const Vec3 e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
  for (const Vec3& c : corners) starts[0].emplace_back(c.dot(e1), c.dot(e2));
  const double around = std::accumulate(lengths.begin(), lengths.end(), 0.0);
  double along = 0;
  for (const double l : lengths) {
    const double t = 2 * kPi * along / around;
    starts[1].push_back(around / (2 * kPi) * Vec2(std::cos(t), std::sin(t)));
    along += l;
  }

  const auto residuals = [&](const std::vector<Vec2>& p) {
    std::vector<double> r;
    for (size_t i = 0; i < n; ++i) {
      const double l = (p[(i + 1) % n] - p[i]).norm();
      r.push_back(length_weight * std::log(std::max(l, 1e-12 * around) / lengths[i]));
      r.push_back(angle_weight * (interior_angle(p, i) - angles[i]));
      for (size_t j = i + 2; j < n && n <= most_distances; ++j) {
        if (i == 0 && j + 1 == n) continue;
        const double in_space = std::max((corners[i] - corners[j]).norm(), 1e-3 * around);
        // A surface between two corners is longer than the straight line, never shorter.
        r.push_back(
            distance_weight *
            std::min(0.0, std::log(std::max((p[i] - p[j]).norm(), 1e-6 * around) / in_space)));
      }
    }
    return VecX(Eigen::Map<const VecX>(r.data(), static_cast<long>(r.size())));
  };

  std::vector<Vec2> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (auto p : starts) {
    if (!simple_and_ccw(p)) continue;
    // Levenberg-Marquardt on the corners; a step that folds the polygon is refused.
    VecX r = residuals(p);
    double damping = 1e-3;
    for (int step = 0; step < 200 && damping < 1e8; ++step) {
      MatX J(r.size(), 2 * static_cast<long>(n));
      const double h = 1e-7 * around;
      for (size_t k = 0; k < 2 * n; ++k) {
        auto q = p;
        q[k / 2][static_cast<long>(k % 2)] += h;
        J.col(static_cast<long>(k)) = (residuals(q) - r) / h;
      }
      MatX H = J.transpose() * J;
      const double scale = H.diagonal().maxCoeff();
      H.diagonal().array() += damping * scale;
      const VecX move = -H.ldlt().solve(J.transpose() * r);
      auto q = p;
      for (size_t k = 0; k < 2 * n; ++k)
        q[k / 2][static_cast<long>(k % 2)] += move[static_cast<long>(k)];
      const VecX next = residuals(q);
      if (simple_and_ccw(q) && next.squaredNorm() < r.squaredNorm()) {
        const bool settled = move.norm() < 1e-10 * around;
        p = q;
        r = next;
        damping = std::max(1e-9, damping / 5);
        if (settled) break;
      } else {
        damping *= 5;
      }
    }
    if (r.squaredNorm() < best_cost) {
      best_cost = r.squaredNorm();
      best = p;
    }
  }
  if (best.empty())
    throw InputError(
        "no simple polygon has these side lengths and angles: the outline is too "
        "twisted for one flat domain");
  return best;
}

}  // namespace batten
