#include "batten/fem/surface.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fem/curve.h"

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

Surface::Surface(std::shared_ptr<const ParametricMesh> mesh, TriangleElement kind, Points dofs)
    : mesh_(std::move(mesh)), kind_(kind), dof_map_(*mesh_), dofs_(std::move(dofs)) {
  if (dofs_.rows() != dof_map_.count())
    throw InputError("a surface with " + std::to_string(dofs_.rows()) + " dofs on a mesh with " +
                     std::to_string(dof_map_.count()));
}

Eigen::Matrix<double, 12, 3> Surface::triangle_dofs(int t) const {
  Eigen::Matrix<double, 12, 3> q;
  const auto dof = dof_map_.triangle(*mesh_, t);
  for (int a = 0; a < 12; ++a) q.row(a) = dofs_.row(dof[a]);
  return q;
}

Vec3 Surface::position(const Location& where) const { return jet(where).x; }

SurfaceJet Surface::jet(const Location& where) const {
  const Tabulation N = C1Triangle(kind_, mesh_->shape(where.triangle)).evaluate(where.L);
  const Eigen::Matrix<double, 3, kDerivatives> d = triangle_dofs(where.triangle).transpose() * N;
  return {d.col(kW), d.col(kU), d.col(kV), d.col(kUU), d.col(kUV), d.col(kVV)};
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

Surface::Closest Surface::closest_point(const Vec3& p) const {
  constexpr int n = 4;
  struct Start {
    double distance, spacing;
    Location where;
  };
  std::vector<Start> starts;
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < mesh_->triangle_count(); ++t) {
    const C1Triangle element(kind_, mesh_->shape(t));
    const auto q = triangle_dofs(t);
    Vec3 x[n + 1][n + 1];
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        x[i][j] = q.transpose() * element.evaluate(Vec3(i, j, n - i - j) / n).col(kW);
    // Every sample that none of its neighbours beats may lead to the nearest point.
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
        nearest = std::min(nearest, start.distance);
        if (lowest) starts.push_back(start);
      }
  }

  Closest best{{}, std::numeric_limits<double>::infinity()};
  for (const Start& start : starts) {
    if (start.distance - 2 * start.spacing > nearest) continue;
    const int t = start.where.triangle;
    const TriangleShape shape = mesh_->shape(t);
    if (start.distance < best.distance) best = {start.where, start.distance};
    // Inside by Newton's method, on each edge as a cubic curve.
    Vec3 L = start.where.L;
    for (int step = 0; step < 30; ++step) {
      const SurfaceJet j = jet({t, L});
      const Vec3 d = j.x - p;
      if (d.norm() < best.distance) best = {{t, L}, d.norm()};
      Mat2 G, H;
      G << j.x_u.dot(j.x_u), j.x_u.dot(j.x_v), j.x_u.dot(j.x_v), j.x_v.dot(j.x_v);
      H << j.x_uu.dot(d), j.x_uv.dot(d), j.x_uv.dot(d), j.x_vv.dot(d);
      const Vec2 g(j.x_u.dot(d), j.x_v.dot(d));
      const Mat2 full = G + H;
      const bool convex = full(0, 0) > 0 && full.determinant() > 1e-3 * G.determinant();
      const Vec2 move = -(convex ? full : G).ldlt().solve(g);
      if (!move.allFinite()) break;
      // A step that leads farther away is halved.
      Vec3 next = L;
      double length = 1;
      for (; length > 1e-3; length *= 0.5) {
        next = clamped(shape.barycentric(shape.point(L) + length * move));
        if ((position({t, next}) - p).norm() <= d.norm()) break;
      }
      if (length <= 1e-3) break;
      const double moved = (next - L).norm();
      L = next;
      if (moved < 1e-14) break;
    }
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      const Vec2 edge = shape.vertex[b] - shape.vertex[a];
      Points X(2, 3), D(2, 3);
      for (const int end : {0, 1}) {
        const SurfaceJet j = jet({t, Vec3::Unit(end ? b : a)});
        X.row(end) = j.x;
        D.row(end) = edge.x() * j.x_u + edge.y() * j.x_v;
      }
      const auto on_edge = HermiteCurve({0, 1}, X, D).closest_point(p);
      Location where{t, Vec3::Zero()};
      where.L[a] = 1 - on_edge.u;
      where.L[b] = on_edge.u;
      if (const double d = (position(where) - p).norm(); d < best.distance) best = {where, d};
    }
  }
  return best;
}

double Surface::area() const {
  static const TriangleRule rule = split_triangle(6);
  double sum = 0;
  for (int t = 0; t < mesh_->triangle_count(); ++t)
    for (long p = 0; p < rule.weights.size(); ++p)
      sum += mesh_->shape(t).area * rule.weights[p] *
             jet({t, rule.L.row(p).transpose()}).area_vector().norm();
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
  if (n < 1) throw InputError("a tessellation needs at least one facet a triangle");
  Tessellation result;
  result.points.resize(mesh.vertex_count());
  std::vector<int> edge_start(mesh.edge_count(), -1);  // n-1 points, from the lower end
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
    for (int i = 0; i < 3; ++i) {
      result.points[v[i]] = {t, Vec3::Unit(i)};
      if (edge_start[e[i]] >= 0) continue;
      edge_start[e[i]] = static_cast<int>(result.points.size());
      const int low = mesh.edge_sign(t, i) > 0 ? (i + 1) % 3 : (i + 2) % 3;
      for (int k = 1; k < n; ++k) {
        Location where{t, Vec3::Zero()};
        where.L[low] = static_cast<double>(n - k) / n;
        where.L[3 - i - low] = static_cast<double>(k) / n;
        result.points.push_back(where);
      }
    }
    // The lattice point with barycentric numerators a[0] + a[1] + a[2] = n.
    const int inner_start = static_cast<int>(result.points.size());
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

std::vector<Curvatures> recovered_curvatures(const Surface& surface, const Tessellation& points) {
  const ParametricMesh& mesh = surface.mesh();
  std::vector<Eigen::Vector2d> sum(mesh.vertex_count(), Eigen::Vector2d::Zero());  // mean, gauss
  std::vector<double> weight(mesh.vertex_count(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const int j = (s + 1) % 3, k = (s + 2) % 3;
      Vec3 L = Vec3::Constant(1.0 / 9);
      L[j] = L[k] = 4.0 / 9;
      const SurfaceJet jet = surface.jet({t, L});
      const Curvatures c = curvatures(jet);
      const double w = jet.area_vector().norm() * mesh.shape(t).area;
      for (const int corner : {j, k}) {
        const int v = mesh.triangles()[t][corner];
        sum[v] += w * Eigen::Vector2d(c.mean, c.gauss);
        weight[v] += w;
      }
    }
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (weight[v] > 0) sum[v] /= weight[v];
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

}  // namespace batten
