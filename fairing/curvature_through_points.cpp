#include <algorithm>
#include <cmath>
#include <string>

#include "batten/core/errors.h"
#include "batten/fairing/curvature_fairing.h"

namespace batten {
namespace {

// Direction at the middle of three points of the circle through them.
Vec3 circle_tangent(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e = b - a, f = c - b;
  const Vec3 t = e / e.squaredNorm() + f / f.squaredNorm();
  return t.norm() > 1e-9 / e.norm() ? t.normalized() : f.normalized();
}

// That of the circle through two points with one end's direction.
Vec3 mirrored(const Vec3& chord, const Vec3& t) {
  const Vec3 c = chord.normalized();
  return 2 * t.dot(c) * c - t;
}

// Length of the arc over a chord with these directions at its ends, which bound it to three chords.
double arc_over(const Vec3& chord, const Vec3& t0, const Vec3& t1) {
  const double length = chord.norm();
  const auto angle = [&](const Vec3& t) { return std::atan2(t.cross(chord).norm(), t.dot(chord)); };
  const double half = std::min(0.5 * (angle(t0) + angle(t1)), 2.28);
  return half > 1e-4 ? length * half / std::sin(half) : length;
}

}  // namespace

CurvatureFairingResult minimum_curvature_curve(const std::vector<CurveThroughPoint>& points,
                                               bool closed,
                                               const CurvatureFairingOptions& options) {
  const auto n = static_cast<long>(points.size());
  if (n < (closed ? 3 : 2))
    throw InputError("found " + std::to_string(n) + " points, expected at least " +
                     (closed ? "three for a closed curve" : "two"));
  const auto at = [&](long i) -> const Vec3& { return points[(i + n) % n].position; };
  for (long i = 0; i < n; ++i) {
    const std::string name = "point " + std::to_string(i + 1);
    const auto& tangent = points[i].tangent;
    if (!at(i).allFinite() || (tangent && !tangent->allFinite()))
      throw InputError(name + " has a number that is not finite");
    if (tangent && !(tangent->norm() > 0)) throw InputError(name + " has a tangent of length zero");
    if ((i > 0 || closed) && at(i) == at(i - 1))
      throw InputError(name + " equals the one before it");
  }

  std::vector<Vec3> t(n);
  const auto given = [&](long i) { return points[i].tangent.has_value(); };
  for (long i = 0; i < n; ++i) {
    if (given(i))
      t[i] = points[i].tangent->normalized();
    else if (closed || (i > 0 && i < n - 1))
      t[i] = circle_tangent(at(i - 1), at(i), at(i + 1));
  }
  if (!closed && n == 2 && !given(0) && !given(1))
    t[0] = t[1] = (at(1) - at(0)).normalized();
  else if (!closed) {
    if (!given(0)) t[0] = mirrored(at(1) - at(0), t[1]);
    if (!given(n - 1)) t[n - 1] = mirrored(at(n - 1) - at(n - 2), t[n - 2]);
  }

  std::vector<double> u = {0};
  for (long i = 0; i + 1 < n + (closed ? 1 : 0); ++i)
    u.push_back(u.back() + arc_over(at(i + 1) - at(i), t[i], t[(i + 1) % n]));
  Points dofs(2 * n, 3);
  std::vector<FixedCurvePoint> holds;
  for (long i = 0; i < n; ++i) {
    dofs.row(2 * i) = at(i);
    dofs.row(2 * i + 1) = t[i];
    holds.push_back({u[i], true, given(i)});
  }
  return fair_curvature(HermiteCurve(CurveMesh(u, closed), dofs), holds, {}, options);
}

}  // namespace batten
