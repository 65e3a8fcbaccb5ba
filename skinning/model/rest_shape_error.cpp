#include "batten/skinning/model/rest_shape_error.h"

#include <algorithm>
#include <cmath>

#include "batten/skinning/model/boundary_sweep.h"

namespace batten {

namespace {

double length_of(const ParametricMesh& mesh, const ParametricMesh::Edge& edge) {
  const auto& corner = mesh.shape(edge.triangle[0]).vertex;
  const int i = edge.local[0];
  return (corner[(i + 1) % 3] - corner[(i + 2) % 3]).norm();
}

}  // namespace

RestShapeError rest_shape_error(const RegionLayout& region, double tolerance,
                                const SizeField* before) {
  const auto sweep = BoundarySweep::of(region);
  if (!sweep) return {};
  const ParametricMesh& mesh = *region.mesh();
  Points edge_midpoints;
  // Turned over where elements are too large for it, or for good.
  const Surface surface(region.mesh(), region.element(),
                        interpolate_surface(
                            mesh, [&](const Vec2& uv) { return sweep->at(uv); }, &edge_midpoints));
  double longest = 0;
  for (const auto& edge : mesh.edges()) longest = std::max(longest, length_of(mesh, edge));
  std::vector<double> lengths(static_cast<size_t>(mesh.vertex_count()), longest);
  if (before)
    for (int v = 0; v < mesh.vertex_count(); ++v) lengths[v] = before->at(mesh.vertices()[v]);
  RestShapeError found;
  double& largest = found.largest;
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const int t = edge.triangle[0], i = edge.local[0];
    Vec3 L = Vec3::Constant(0.5);
    L[i] = 0;
    const double error = (surface.position({t, L}) - edge_midpoints.row(e).transpose()).norm();
    largest = std::max(largest, error);
    if (!(error > tolerance)) continue;
    const double shorter = std::clamp(std::pow(0.1 * tolerance / error, 0.25), 0.5, 0.7);
    for (const int beside : edge.triangle) {
      if (beside < 0) continue;
      for (const int v : mesh.triangles()[beside]) {
        // Edges may be longer than asked for.
        const double asked = before ? before->at(mesh.vertices()[v]) : longest;
        lengths[v] = std::min(lengths[v], shorter * std::min(asked, length_of(mesh, edge)));
      }
    }
  }
  if (largest > tolerance)
    found.size_field = std::make_shared<const SizeField>(region.mesh(), std::move(lengths));
  return found;
}

}  // namespace batten
