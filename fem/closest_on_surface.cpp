#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "batten/fem/closest_on_curve.h"
#include "batten/fem/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

// A sample from which the nearest point is looked for.
struct Start {
  double distance, spacing;  // spacing: largest distance from the samples beside it
  Location where;
};

Vec3 clamped(Vec3 L) {
  L = L.cwiseMax(0.0);
  return L / L.sum();
}

// Every sample of a triangle that none of its neighbours beats may lead to the nearest point.
// Visits all samples, with whether it is such a one.
template <class Visit>
void sample_triangle(const Surface& surface, int t, const Vec3& p, const Visit& visit) {
  constexpr int n = 4;
  const C1Triangle element(surface.kind(), surface.mesh().shape(t));
  const auto q = surface.triangle_dofs(t);
  Vec3 x[n + 1][n + 1];
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j)
      x[i][j] = q.transpose() * element.evaluate(Vec3(i, j, n - i - j) / n).col(kW);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      Start start{(x[i][j] - p).norm(), 0, {t, Vec3(i, j, n - i - j) / n}};
      bool lowest = true;
      constexpr int step[6][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};
      for (const auto& [di, dj] : step) {
        const int k = i + di, l = j + dj;
        if (k < 0 || l < 0 || k + l > n) continue;
        lowest = lowest && (x[k][l] - p).norm() >= start.distance;
        start.spacing = std::max(start.spacing, (x[k][l] - x[i][j]).norm());
      }
      visit(start, lowest);
    }
}

// Newton's method inside of a triangle; offers every place that it passes.
template <class Offer>
void descend(const Surface& surface, const Location& from, const Vec3& p, const Offer& offer) {
  const int t = from.triangle;
  const TriangleShape shape = surface.mesh().shape(t);
  Vec3 L = from.L;
  for (int step = 0; step < 30; ++step) {
    const SurfaceJet j = surface.jet({t, L});
    const Vec3 d = j.x - p;
    offer({t, L}, d.norm());
    Mat2 G, H;
    G << j.x_u.dot(j.x_u), j.x_u.dot(j.x_v), j.x_u.dot(j.x_v), j.x_v.dot(j.x_v);
    H << j.x_uu.dot(d), j.x_uv.dot(d), j.x_uv.dot(d), j.x_vv.dot(d);
    const Vec2 g(j.x_u.dot(d), j.x_v.dot(d));
    const Mat2 full = G + H;
    const bool convex = full(0, 0) > 0 && full.determinant() > 1e-3 * G.determinant();
    const Vec2 move = -(convex ? full : G).ldlt().solve(g);
    if (!move.allFinite()) return;
    // A step that leads farther away is halved.
    Vec3 next = L;
    double length = 1;
    for (; length > 1e-3; length *= 0.5) {
      next = clamped(shape.barycentric(shape.point(L) + length * move));
      if ((surface.position({t, next}) - p).norm() <= d.norm()) break;
    }
    if (length <= 1e-3) return;
    const double moved = (next - L).norm();
    L = next;
    if (moved < 1e-14) return;
  }
}

// The nearest place on each edge of a triangle, a cubic curve.
template <class Offer>
void search_edges(const Surface& surface, int t, const Vec3& p, const Offer& offer) {
  const TriangleShape shape = surface.mesh().shape(t);
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 1) % 3, b = (i + 2) % 3;
    const Vec2 edge = shape.vertex[b] - shape.vertex[a];
    Points X(2, 3), D(2, 3);
    for (const int end : {0, 1}) {
      const SurfaceJet j = surface.jet({t, Vec3::Unit(end ? b : a)});
      X.row(end) = j.x;
      D.row(end) = edge.x() * j.x_u + edge.y() * j.x_v;
    }
    const auto on_edge = HermiteCurve({0, 1}, X, D).closest_point(p);
    Location where{t, Vec3::Zero()};
    where.L[a] = 1 - on_edge.u;
    where.L[b] = on_edge.u;
    offer(where, (surface.position(where) - p).norm());
  }
}

}  // namespace

Surface::ClosestPoint Surface::closest_point(const Vec3& p) const {
  std::vector<Start> starts;
  ClosestPoint best{{}, std::numeric_limits<double>::infinity()};
  if (trim_) best = closest_on_loops(p);
  double nearest = best.distance;
  const auto inside = [&](const Location& where) {
    return !trim_ || trim_->side(where.triangle) == Trim::Side::Inside ||
           trim_->loops().contains(mesh_->shape(where.triangle).point(where.L));
  };
  for (int t = 0; t < mesh_->triangle_count(); ++t) {
    if (trim_ && trim_->side(t) == Trim::Side::Outside) continue;
    sample_triangle(*this, t, p, [&](const Start& start, bool lowest) {
      if (start.distance < nearest && inside(start.where)) nearest = start.distance;
      if (lowest) starts.push_back(start);
    });
  }
  const auto offer = [&](const Location& where, double distance) {
    if (distance < best.distance && inside(where)) best = {where, distance};
  };
  for (const Start& start : starts) {
    if (start.distance - 2 * start.spacing > nearest) continue;
    offer(start.where, start.distance);
    descend(*this, start.where, p, offer);
    search_edges(*this, start.where.triangle, p, offer);
  }
  return best;
}

Surface::ClosestPoint Surface::closest_on_loops(const Vec3& p) const {
  const TriangleLocator locator(*mesh_);
  double edge = 0;
  for (int e = 0; e < mesh_->edge_count(); ++e) edge += mesh_->edge_length(e) / mesh_->edge_count();
  ClosestPoint best{{}, std::numeric_limits<double>::infinity()};
  for (const auto& loop : trim_->loops().loops())
    for (const HermiteCurve& curve : loop) {
      const auto where = [&](double t) { return locator.locate(curve.evaluate(t).head<2>()); };
      const auto along = [&](double t, int order) -> Vec3 {
        const SurfaceJet j = jet(where(t));
        if (order == 0) return j.x;
        const Vec3 d = curve.evaluate(t, 1);
        if (order == 1) return d.x() * j.x_u + d.y() * j.x_v;
        const Vec3 dd = curve.evaluate(t, 2);
        return d.x() * d.x() * j.x_uu + 2 * d.x() * d.y() * j.x_uv + d.y() * d.y() * j.x_vv +
               dd.x() * j.x_u + dd.y() * j.x_v;
      };
      std::vector<double> samples{curve.start()};
      for (int s = 0; s < curve.segment_count(); ++s) {
        const int next = (s + 1) % curve.node_count();
        const double chord = (curve.position(next) - curve.position(s)).norm();
        const int count = 4 + static_cast<int>(4 * chord / edge);
        const double from = curve.parameters()[s], to = curve.parameters()[s + 1];
        for (int k = 1; k <= count; ++k)
          samples.push_back(k == count ? to : from + (to - from) * k / count);
      }
      const CurvePoint found = closest_on_curve(along, samples, p);
      if (found.distance < best.distance) best = {where(found.u), found.distance};
    }
  return best;
}

}  // namespace batten
