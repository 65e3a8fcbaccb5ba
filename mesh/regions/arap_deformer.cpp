// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/arap_deformer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/regions/local_global_solver.h"

namespace batten {
namespace {

/// Two rows per triangle: √A times the derivatives along two orthogonal directions in its plane.
void add_gradients(const TriangleMesh& mesh, ArapEnergy& rows) {
  const int count = mesh.triangle_count();
  rows.A.resize(2L * count, mesh.vertex_count());
  rows.A.reserve(6L * count);
  rows.base.resize(2L * count, 3);
  rows.cells_of_element = 3;
  for (int t = 0; t < count; ++t) {
    auto v = mesh.triangles()[t];
    std::sort(v.begin(), v.end());  // columns ascend; the sign of the normal cancels
    const Vec3 a = mesh.point(v[0]), b = mesh.point(v[1]), c = mesh.point(v[2]);
    const Vec3 across = (b - a).cross(c - a);
    const double double_area = across.norm();
    if (!(double_area > 0))
      throw InputError("triangle " + std::to_string(t) +
                       " has no area, expected triangles with an area");
    const Vec3 n = across / double_area, first = (b - a).normalized(), second = n.cross(first);
    const Vec3 slope[3] = {n.cross(c - b) / double_area, n.cross(a - c) / double_area,
                           n.cross(b - a) / double_area};
    const double weight = std::sqrt(double_area / 2);
    for (int k = 0; k < 2; ++k) {
      const long r = 2L * t + k;
      const Vec3& along = k == 0 ? first : second;
      rows.A.startVec(r);
      for (int i = 0; i < 3; ++i) rows.A.insertBack(r, v[i]) = weight * slope[i].dot(along);
      rows.base.row(r) = weight * along.transpose();
    }
    rows.row_start.push_back(2 * t + 2);
    for (const int vertex : v) rows.cells.push_back(mesh.topology().node_of(vertex));
  }
  rows.A.finalize();
}

ArapEnergy rows_of(const TriangleMesh& mesh, double smoothing) {
  ArapEnergy rows;
  add_gradients(mesh, rows);
  rows.mean.resize(mesh.vertex_count(), mesh.vertex_count());
  rows.mean.setIdentity();
  rows.cell_vertices.resize(mesh.vertex_count());
  std::iota(rows.cell_vertices.begin(), rows.cell_vertices.end(), 0);
  if (smoothing == 0) return rows;
  double area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) area += mesh.area_vector(t).norm() / 2;
  const std::vector<double> cotangents = edge_cotangents(mesh);
  for (size_t e = 0; e < cotangents.size(); ++e)
    if (cotangents[e] > 0) {
      const auto& edge = mesh.topology().edges()[e];
      const int low = mesh.topology().node_of(edge.low), high = mesh.topology().node_of(edge.high);
      rows.links.push_back({low, high, smoothing * area * cotangents[e]});
    }
  return rows;
}

const ArapOptions& checked(const ArapOptions& options) {
  if (options.max_iterations < 1 || !(options.tolerance >= 0) || !(options.smoothing >= 0) ||
      !std::isfinite(options.smoothing))
    throw InputError(
        "ARAP deformer: found max_iterations = " + std::to_string(options.max_iterations) +
        ", tolerance = " + format_number(options.tolerance) + ", smoothing = " +
        format_number(options.smoothing) + ", expected 1 or more, 0 or more, 0 or more");
  return options;
}

}  // namespace

ArapDeformer::ArapDeformer(const TriangleMesh& mesh, std::vector<int> fixed,
                           std::vector<Handle> handles, const ArapOptions& options)
    : IterativeDeformer(mesh, std::move(fixed), std::move(handles),
                        rows_of(mesh, checked(options).smoothing), "ARAP deformer",
                        options.max_iterations, options.tolerance) {}

}  // namespace batten
