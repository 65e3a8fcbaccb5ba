// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

Vec3 clamped(Vec3 L) {
  L = L.cwiseMax(0.0);
  return L / L.sum();
}

}  // namespace

Vec3 SurfaceJet::area_vector() const { return x_u.cross(x_v); }

Vec3 SurfaceJet::normal() const {
  const Vec3 a = area_vector();
  const double length = a.norm();
  return length > 0 ? Vec3(a / length) : Vec3::Zero();
}

Curvatures curvatures(const SurfaceJet& j) {
  const Vec3 n = j.normal();
  const double E = j.x_u.dot(j.x_u), F = j.x_u.dot(j.x_v), G = j.x_v.dot(j.x_v);
  const double L = j.x_uu.dot(n), M = j.x_uv.dot(n), N = j.x_vv.dot(n);
  const double det = E * G - F * F;
  Curvatures c;
  if (!(det > 0)) return c;
  c.mean = (E * N - 2 * F * M + G * L) / (2 * det);
  c.gauss = (L * N - M * M) / det;
  const double root = std::sqrt(std::max(0.0, c.mean * c.mean - c.gauss));
  c.k1 = c.mean + root;
  c.k2 = c.mean - root;
  return c;
}

Surface::Surface(std::shared_ptr<const ParametricMesh> mesh, TriangleElement kind, Points dofs,
                 std::shared_ptr<const Trim> trim)
    : mesh_(std::move(mesh)),
      kind_(kind),
      dof_map_(*mesh_),
      dofs_(std::move(dofs)),
      trim_(std::move(trim)) {
  if (dofs_.rows() != dof_map_.count())
    throw InputError("found " + std::to_string(dofs_.rows()) + " dofs of a surface, expected " +
                     std::to_string(dof_map_.count()) + " of its mesh");
}

Eigen::Matrix<double, 12, 3> Surface::triangle_dofs(int t) const {
  Eigen::Matrix<double, 12, 3> q;
  const auto dof = dof_map_.triangle(*mesh_, t);
  for (int a = 0; a < 12; ++a) q.row(a) = dofs_.row(dof[a]);
  return q;
}

Vec3 Surface::position(const Location& where) const {
  return C1Triangle(kind_, mesh_->shape(where.triangle))
      .position(where.L, triangle_dofs(where.triangle));
}

SurfaceJet Surface::jet(const Location& where) const {
  const Eigen::Matrix<double, 3, kDerivatives> d =
      C1Triangle(kind_, mesh_->shape(where.triangle)).jet(where.L, triangle_dofs(where.triangle));
  return {d.col(kW), d.col(kU), d.col(kV), d.col(kUU), d.col(kUV), d.col(kVV)};
}

namespace {

/// Evaluates x_u × x_v at many points of one triangle.
class AreaVector {
 public:
  AreaVector(const Surface& surface, int triangle, const TriangleShape& shape)
      : kind_(surface.kind()),
        q_(C1Triangle(kind_, shape).pull_back(surface.triangle_dofs(triangle))),
        scale_(DerivativeMap(shape).first.determinant()) {}
  Vec3 operator()(const Vec3& L) const {
    const Eigen::Matrix<double, 3, 2> d = q_.transpose().lazyProduct(reference_gradients(kind_, L));
    return scale_ * d.col(0).cross(d.col(1));
  }

 private:
  TriangleElement kind_;
  Eigen::Matrix<double, 12, 3> q_;
  double scale_;
};

}  // namespace

Vec3 Surface::area_vector(const Location& where) const {
  return AreaVector(*this, where.triangle, mesh_->shape(where.triangle))(where.L);
}

Location Surface::locate(const Vec2& uv) const {
  Location best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (int t = 0; t < mesh_->triangle_count(); ++t) {
    const TriangleShape shape = mesh_->shape(t);
    const Vec3 L = shape.barycentric(uv);
    if (L.minCoeff() >= 0) return {t, clamped(L)};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec2 edge = shape.vertex[k] - shape.vertex[j];
      const double s = std::clamp((uv - shape.vertex[j]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const double distance = (shape.vertex[j] + s * edge - uv).norm();
      if (distance >= best_distance) continue;
      best_distance = distance;
      best = {t, Vec3::Zero()};
      best.L[j] = 1 - s;
      best.L[k] = s;
    }
  }
  return best;
}

double Surface::area() const {
  static const TriangleRule rule = split_triangle_rule(6);
  // The reference functions at the quadrature points are the same for all triangles.
  std::vector<Eigen::Matrix<double, 12, 2>> slopes;
  for (long p = 0; p < rule.weights.size(); ++p)
    slopes.push_back(reference_gradients(kind_, rule.L.row(p).transpose()));
  double sum = 0;
  const auto add_whole = [&](int t) {
    const TriangleShape shape = mesh_->shape(t);
    const Eigen::Matrix<double, 12, 3> q = C1Triangle(kind_, shape).pull_back(triangle_dofs(t));
    const DerivativeMap map(shape);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Eigen::Matrix<double, 12, 2> local = slopes[p] * map.first.transpose();
      const Eigen::Matrix<double, 3, 2> d = q.transpose().lazyProduct(local);
      sum += shape.area * rule.weights[p] * d.col(0).cross(d.col(1)).norm();
    }
  };
  const auto add_part = [&](int t, const TriangleRule& points) {
    const TriangleShape shape = mesh_->shape(t);
    const AreaVector area_vector(*this, t, shape);
    for (long p = 0; p < points.weights.size(); ++p)
      sum += shape.area * points.weights[p] * area_vector(points.L.row(p).transpose()).norm();
  };
  // Degree of the rule on cut triangles. Its cones do not follow the borders between the cubics of
  // a triangle, so a higher degree would not be more accurate.
  constexpr int degree = 4;
  for (int t = 0; t < mesh_->triangle_count(); ++t) {
    poll_every<4096>(t);
    if (!trim_ || trim_->side(t) == Trim::Side::Inside)
      add_whole(t);
    else
      add_part(t, trim_->rule(t, degree));
  }
  return sum;
}

SparseMatrix evaluation_operator(const ParametricMesh& mesh, TriangleElement kind,
                                 const std::vector<Location>& points, Derivative derivative) {
  const DofMap dofs(mesh);
  std::vector<Triplet> entries;
  entries.reserve(12 * points.size());
  for (size_t p = 0; p < points.size(); ++p) {
    const int t = points[p].triangle;
    const Vec12 N = C1Triangle(kind, mesh.shape(t)).evaluate(points[p].L).col(derivative);
    const auto dof = dofs.triangle(mesh, t);
    for (int a = 0; a < 12; ++a)
      if (N[a] != 0) entries.emplace_back(static_cast<int>(p), dof[a], N[a]);
  }
  SparseMatrix E(static_cast<long>(points.size()), dofs.count());
  E.setFromTriplets(entries.begin(), entries.end());
  return E;
}

Tessellation tessellate(const ParametricMesh& mesh, int n) {
  if (n < 1) throw InputError("a tessellation needs at least one facet per triangle");
  Tessellation result;
  result.points.resize(mesh.vertex_count());
  std::vector<int> edge_start(mesh.edge_count(), -1);  // n-1 points per edge, from the lower end
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
    for (int i = 0; i < 3; ++i) {
      result.points[v[i]] = {t, Vec3::Unit(i)};
      if (edge_start[e[i]] >= 0) continue;
      edge_start[e[i]] = isize(result.points);
      const int low = mesh.edge_sign(t, i) > 0 ? (i + 1) % 3 : (i + 2) % 3;
      for (int k = 1; k < n; ++k) {
        Location where{t, Vec3::Zero()};
        where.L[low] = static_cast<double>(n - k) / n;
        where.L[3 - i - low] = static_cast<double>(k) / n;
        result.points.push_back(where);
      }
    }
    // Lattice point with barycentric numerators a[0] + a[1] + a[2] = n.
    const int inner_start = isize(result.points);
    int inner = 0;
    std::vector<int> lattice((n + 1) * (n + 1));
    for (int a0 = 0; a0 <= n; ++a0)
      for (int a1 = 0; a0 + a1 <= n; ++a1) {
        const int a[3] = {a0, a1, n - a0 - a1};
        int point = -1;
        for (int i = 0; i < 3; ++i)
          if (a[i] == n) point = v[i];
        for (int i = 0; point < 0 && i < 3; ++i)
          if (a[i] == 0) {
            const int high = mesh.edge_sign(t, i) > 0 ? (i + 2) % 3 : (i + 1) % 3;
            point = edge_start[e[i]] + a[high] - 1;
          }
        if (point < 0) {
          point = inner_start + inner++;
          result.points.push_back({t, Vec3(a[0], a[1], a[2]) / n});
        }
        lattice[a0 * (n + 1) + a1] = point;
      }
    const auto at = [&](int a0, int a1) { return lattice[a0 * (n + 1) + a1]; };
    const auto add = [&](int a, int b, int c) {
      result.facets.push_back({a, b, c});
      result.facet_triangle.push_back(t);
    };
    for (int a0 = 0; a0 < n; ++a0)
      for (int a1 = 0; a0 + a1 < n; ++a1) {
        add(at(a0 + 1, a1), at(a0, a1 + 1), at(a0, a1));
        if (a0 + a1 + 1 < n) add(at(a0 + 1, a1), at(a0 + 1, a1 + 1), at(a0, a1 + 1));
      }
  }
  return result;
}

namespace {

// Values computed from slivers only are unreliable: replaces them by the mean of their neighbours,
// starting from vertices with sufficient support.
void smooth_thin_support(const ParametricMesh& mesh, const Trim& trim,
                         std::vector<Eigen::Vector2d>& value) {
  std::vector<double> support(mesh.vertex_count(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles()[t]) support[v] += trim.area_fraction(t);
  constexpr double enough = 0.2;
  std::vector<char> known(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) known[v] = support[v] >= enough;
  for (bool found = true; found;) {
    found = false;
    std::vector<Eigen::Vector2d> sum(mesh.vertex_count(), Eigen::Vector2d::Zero());
    std::vector<int> count(mesh.vertex_count(), 0);
    for (const auto& e : mesh.edges())
      for (const auto& [from, to] : {std::pair{e.low, e.high}, {e.high, e.low}})
        if (known[from] && !known[to]) {
          sum[to] += value[from];
          ++count[to];
        }
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (count[v] > 0) {
        value[v] = sum[v] / count[v];
        known[v] = 1;
        found = true;
      }
  }
}

}  // namespace

std::vector<Curvatures> recovered_curvatures(const Surface& surface, const Tessellation& points) {
  const ParametricMesh& mesh = surface.mesh();
  std::vector<Eigen::Vector2d> sum(mesh.vertex_count(), Eigen::Vector2d::Zero());  // mean, Gaussian
  std::vector<double> weight(mesh.vertex_count(), 0);
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const int j = (s + 1) % 3, k = (s + 2) % 3;
      Vec3 L = Vec3::Constant(1.0 / 9);
      L[j] = L[k] = 4.0 / 9;
      const SurfaceJet jet = surface.jet({t, L});
      const Curvatures c = curvatures(jet);
      double w = jet.area_vector().norm() * mesh.shape(t).area;
      if (trim) w *= trim->area_fraction(t);
      for (const int corner : {j, k}) {
        const int v = mesh.triangles()[t][corner];
        sum[v] += w * Eigen::Vector2d(c.mean, c.gauss);
        weight[v] += w;
      }
    }
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (weight[v] > 0) sum[v] /= weight[v];
  if (trim) smooth_thin_support(mesh, *trim, sum);
  std::vector<Curvatures> result(points.points.size());
  for (size_t p = 0; p < result.size(); ++p) {
    const auto& [t, L] = points.points[p];
    Eigen::Vector2d value = Eigen::Vector2d::Zero();
    for (int i = 0; i < 3; ++i) value += L[i] * sum[mesh.triangles()[t][i]];
    Curvatures& c = result[p];
    c.mean = value[0];
    c.gauss = value[1];
    const double root = std::sqrt(std::max(0.0, c.mean * c.mean - c.gauss));
    c.k1 = c.mean + root;
    c.k2 = c.mean - root;
  }
  return result;
}

namespace {

// Sample from which the nearest point is searched.
struct Start {
  double distance, spacing;  // largest distance from the samples beside it
  Location where;
};

Vec3 clamped_barycentric(Vec3 L) {
  L = L.cwiseMax(0.0);
  return L / L.sum();
}

// Samples of a triangle that are nearer to p than all neighbouring samples may lead to the nearest
// point. Visits all samples, with a flag for these.
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

// Newton's method within a triangle; offers every location on its path.
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
    // A step that increases the distance is halved.
    Vec3 next = L;
    double length = 1;
    for (; length > 1e-3; length *= 0.5) {
      next = clamped_barycentric(shape.barycentric(shape.point(L) + length * move));
      if ((surface.position({t, next}) - p).norm() <= d.norm()) break;
    }
    if (length <= 1e-3) return;
    const double moved = (next - L).norm();
    L = next;
    if (moved < 1e-14) return;
  }
}

// Finds the nearest point on each edge of a triangle, a cubic curve.
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

Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints) {
  if (edge_midpoints) edge_midpoints->resize(mesh.edge_count(), 3);
  const DofMap map(mesh);
  Points q(map.count(), 3);
  parallel_for_each<16>(mesh.vertex_count(), [&](int v) {
    const FirstOrderJet s = surface(mesh.vertices()[v]);
    q.row(map.vertex(v)) = s.x;
    q.row(map.vertex(v, 1)) = s.gradient.col(0);
    q.row(map.vertex(v, 2)) = s.gradient.col(1);
  });
  parallel_for_each<16>(mesh.edge_count(), [&](int e) {
    const auto& edge = mesh.edges()[e];
    const auto& corner = mesh.shape(edge.triangle[0]).vertex;
    const int i = edge.local[0];
    const Vec2 middle = (corner[(i + 1) % 3] + corner[(i + 2) % 3]) / 2;
    const FirstOrderJet s = surface(middle);
    q.row(map.edge(e)) = s.gradient * mesh.edge_normal(e);
    if (edge_midpoints) edge_midpoints->row(e) = s.x;
  });
  return q;
}

}  // namespace batten
