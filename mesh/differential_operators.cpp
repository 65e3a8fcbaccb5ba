// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/differential_operators.h"

#include <algorithm>

namespace batten {

Eigen::Matrix3Xd half_cotangents(const TriangleMesh& mesh) {
  Eigen::Matrix3Xd half(3, mesh.triangle_count());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& v = mesh.triangles()[t];
    const Vec3 e[3] = {mesh.point(v[2]) - mesh.point(v[1]), mesh.point(v[0]) - mesh.point(v[2]),
                       mesh.point(v[1]) - mesh.point(v[0])};
    const double double_area = e[0].cross(e[1]).norm();
    for (int c = 0; c < 3; ++c)
      half(c, t) = -e[(c + 1) % 3].dot(e[(c + 2) % 3]) / (2 * double_area);
  }
  return half;
}

std::vector<double> edge_cotangents(const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const Eigen::Matrix3Xd half = half_cotangents(mesh);
  std::vector<double> weight(topology.edges().size(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int c = 0; c < 3; ++c) weight[topology.edges_of(t)[c]] += half(c, t);
  return weight;
}

SparseMatrix cotangent_laplacian(const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const int n = mesh.vertex_count();
  SparseMatrix L(n, n);
  const std::vector<double> weight = edge_cotangents(mesh);
  std::vector<double> diagonal(n, 0);
  for (size_t e = 0; e < weight.size(); ++e) {
    diagonal[topology.edges()[e].low] += weight[e];
    diagonal[topology.edges()[e].high] += weight[e];
  }
  // Edges are sorted by (low, high), so they fill column `low` of the lower triangle in row order.
  L.reserve(static_cast<long>(weight.size()) + n);
  size_t e = 0;
  for (int v = 0; v < n; ++v) {
    L.startVec(v);
    if (topology.neighbours(v).empty()) continue;
    L.insertBack(v, v) = diagonal[v];
    for (; e < weight.size() && topology.edges()[e].low == v; ++e)
      L.insertBack(topology.edges()[e].high, v) = -weight[e];
  }
  L.finalize();
  return L;
}

VecX mixed_areas(const TriangleMesh& mesh) {
  VecX area = VecX::Zero(mesh.vertex_count());
  const Eigen::Matrix3Xd half = half_cotangents(mesh);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& v = mesh.triangles()[t];
    const double whole = mesh.area_vector(t).norm() / 2;
    const int obtuse = static_cast<int>(
        std::find_if(half.col(t).data(), half.col(t).data() + 3, [](double x) { return x < 0; }) -
        half.col(t).data());
    if (obtuse < 3) {
      for (int c = 0; c < 3; ++c) area[v[c]] += whole / (c == obtuse ? 2 : 4);
      continue;
    }
    for (int c = 0; c < 3; ++c) {  // edge opposite to c: each end gets |e|² · ½ cot / 4
      const int a = v[(c + 1) % 3], b = v[(c + 2) % 3];
      const double part = (mesh.point(a) - mesh.point(b)).squaredNorm() * half(c, t) / 4;
      area[a] += part;
      area[b] += part;
    }
  }
  return area;
}

}  // namespace batten
