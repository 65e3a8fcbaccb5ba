#include "batten/skinning/domains/curve_crossing.h"

#include <algorithm>

namespace batten {
namespace {

// How far a curve may lie from the chords of its polyline.
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

// Two polylines of different curves come near each other at these segments: the curves' own
// distance there, by Gauss-Newton on both parameters.
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

}  // namespace batten
