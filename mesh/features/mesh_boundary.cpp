// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/features/mesh_boundary.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

using std::numbers::pi;

// Estimates the surface at vertices of a mesh by quadratic height functions.
class QuadraticFit {
 public:
  QuadraticFit(const TriangleMesh& mesh, double crease_deg)
      : mesh_(mesh), crease_cos_(std::cos(crease_deg * pi / 180)) {}

  // The fitted surface at a vertex.
  struct Jet {
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
    Mat3 curvature = Mat3::Zero();
    double residual = 0;  // weighted root mean square
  };

  Jet at(int vertex) const {
    constexpr int rings = 3, most_rings = 12;
    Fit best = fit(vertex, rings);
    // More vertices, if they fit as well: the residual is noise, not the shape of the surface.
    constexpr double as_well = 2, exact = 1e-6;
    for (int more = 2 * rings; more <= most_rings && best.jet.residual > exact * best.size;
         more *= 2) {
      Fit next = fit(vertex, more);
      if (!(next.jet.residual < as_well * best.jet.residual)) break;
      best = std::move(next);
    }
    return best.jet;
  }

 private:
  // Triangles around a vertex that are connected without a crease.
  std::vector<int> surroundings(int vertex, int rings) const {
    const MeshTopology& topology = mesh_.topology();
    std::vector<int> found;
    std::set<int> visited;
    const auto first = topology.triangles_of(vertex);
    for (const int t : first)
      if (visited.insert(t).second) found.push_back(t);
    std::set<int> points;
    const auto count_points = [&] {
      for (const int t : found)
        for (const int v : topology.triangles()[t]) points.insert(v);
      return points.size();
    };
    constexpr int most_rings = 8;
    constexpr size_t enough = 12;
    for (int ring = 1;
         ring < std::max(rings, most_rings) && (ring < rings || count_points() < enough); ++ring) {
      std::set<int> next;
      for (const int t : found) {
        const Vec3 n = mesh_.area_vector(t).normalized();
        for (const int v : topology.triangles()[t])
          for (const int other : topology.triangles_of(v)) {
            if (visited.count(other)) continue;
            // The test at a common vertex includes that at a common edge.
            if (mesh_.area_vector(other).normalized().dot(n) > crease_cos_) next.insert(other);
          }
      }
      if (next.empty()) break;
      visited.insert(next.begin(), next.end());
      found.insert(found.end(), next.begin(), next.end());
    }
    return found;
  }

  struct Fit {
    Jet jet;
    double size = 0;  // radius of the vertices
  };

  Fit fit(int vertex, int rings) const {
    Fit found;
    Jet& jet = found.jet;
    jet.point = mesh_.point(vertex);
    std::set<int> points;
    for (const int t : surroundings(vertex, rings)) {
      jet.normal += mesh_.area_vector(t);
      for (const int v : mesh_.triangles()[t]) points.insert(v);
    }
    jet.normal.normalize();
    constexpr Eigen::Index unknowns = 6;
    if (isize(points) < unknowns) return found;
    const Vec3 origin = mesh_.point(vertex);
    const Vec3 e1 = jet.normal.unitOrthogonal(), e2 = jet.normal.cross(e1);
    double& size = found.size;
    for (const int v : points) size = std::max(size, (mesh_.point(v) - origin).norm());
    Eigen::Matrix<double, Eigen::Dynamic, 6> A(isize(points), unknowns);
    VecX z(isize(points));
    int row = 0;
    for (const int v : points) {
      const Vec3 d = (mesh_.point(v) - origin) / size;
      const double x = d.dot(e1), y = d.dot(e2), weight = std::exp(-2 * d.squaredNorm());
      A.row(row) << 1, x, y, x * x / 2, x * y, y * y / 2;
      A.row(row) *= weight;
      z[row++] = weight * d.dot(jet.normal);
    }
    const auto qr = A.colPivHouseholderQr();
    constexpr double well_posed = 1e-4;
    if (std::abs(qr.matrixR()(unknowns - 1, unknowns - 1)) <
        well_posed * std::abs(qr.matrixR()(0, 0)))
      return found;
    const VecX c = qr.solve(z);
    const double freedom = std::max(1.0, static_cast<double>(isize(points) - unknowns));
    const double residual = size * (A * c - z).norm() / A.col(0).norm() *
                            std::sqrt(static_cast<double>(isize(points)) / freedom);
    const Vec3 xu = e1 + c[1] * jet.normal, xv = e2 + c[2] * jet.normal;
    const Vec3 n = xu.cross(xv).normalized();
    Eigen::Matrix<double, 3, 2> X;
    X << xu, xv;
    Eigen::Matrix2d second;
    second << c[3], c[4], c[4], c[5];
    second *= jet.normal.dot(n) / size;
    const Eigen::Matrix<double, 3, 2> dual = X * (X.transpose() * X).inverse();
    jet = {origin + size * c[0] * jet.normal.dot(n) * n, n, dual * second * dual.transpose(),
           residual};
    return found;
  }

  const TriangleMesh& mesh_;
  double crease_cos_;
};

double angle_at(const TriangleMesh& mesh, int vertex) {
  double sum = 0;
  for (const int t : mesh.topology().triangles_of(vertex)) {
    const auto& corners = mesh.triangles()[t];
    const auto at = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
    const Vec3 a = mesh.point(corners[(at + 1) % 3]) - mesh.point(vertex),
               b = mesh.point(corners[(at + 2) % 3]) - mesh.point(vertex);
    sum += std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return sum;
}

}  // namespace

std::vector<MeshBoundary> mesh_boundaries(const TriangleMesh& mesh, double crease_deg) {
  const QuadraticFit surface(mesh, crease_deg);
  std::vector<MeshBoundary> boundaries;
  for (const std::vector<int>& loop : mesh.topology().boundary_loops()) {
    MeshBoundary& boundary = boundaries.emplace_back();
    boundary.vertices = loop;
    boundary.component = mesh.topology().component()[loop.front()];
    boundary.length = mesh.length(loop);
    std::vector<QuadraticFit::Jet> jets(loop.size());
    parallel_for(isize(loop), [&](int i) { jets[i] = surface.at(loop[i]); });
    std::vector<double> residuals;
    for (const auto& jet : jets) residuals.push_back(jet.residual);
    const auto middle = residuals.begin() + isize(residuals) / 2;
    std::nth_element(residuals.begin(), middle, residuals.end());
    boundary.noise = *middle;
    for (size_t i = 0; i < loop.size(); ++i) {
      boundary.points.push_back(jets[i].point);
      boundary.normals.push_back(jets[i].normal);
      boundary.curvatures.push_back(jets[i].curvature);
      boundary.centre += mesh.point(loop[i]) / isize(loop);
      boundary.turning_deg += (pi - angle_at(mesh, loop[i])) * 180 / pi;
    }
  }
  std::stable_sort(
      boundaries.begin(), boundaries.end(),
      [](const MeshBoundary& a, const MeshBoundary& b) { return a.length > b.length; });
  return boundaries;
}

}  // namespace batten
