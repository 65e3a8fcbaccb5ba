#include "batten/mesh/harmonic_map.h"

#include <algorithm>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

SparseMatrix positive_laplacian(const TriangleMesh& mesh) {
  constexpr double least = 0.01, most = 100;
  const auto& edges = mesh.topology().edges();
  const std::vector<double> cotangents = edge_cotangents(mesh);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t e = 0; e < edges.size(); ++e) {
    // A triangle without area has no cotangent.
    const double w = cotangents[e] > least ? std::min(cotangents[e], most) : least;
    entries.emplace_back(edges[e].low, edges[e].low, w);
    entries.emplace_back(edges[e].high, edges[e].high, w);
    entries.emplace_back(edges[e].high, edges[e].low, -w);
  }
  SparseMatrix L(mesh.vertex_count(), mesh.vertex_count());
  L.setFromTriplets(entries.begin(), entries.end());
  return L;
}

TriangleMesh laid_flat(const TriangleMesh& mesh,
                       const std::function<Vec2(const Vec3&)>& boundary_parameter) {
  const MeshTopology& topology = mesh.topology();
  if (topology.component_count() != 1)
    throw InputError("a surface of " + std::to_string(topology.component_count()) +
                     " sheets, expected one to lay flat");
  ConstraintSet parameters(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (topology.on_boundary(v)) {
      const Vec2 parameter = boundary_parameter(mesh.point(v));
      parameters.fix("rim", v, {parameter.x(), parameter.y(), 0});
    } else if (topology.neighbours(v).empty()) {
      parameters.fix("apart", v, Vec3::Zero());
    }
  }
  if (parameters.constraints().empty())
    throw InputError("a closed surface, expected a rim to lay it flat");
  return mesh.with_points(solve_constrained(parameters, positive_laplacian(mesh),
                                            Points::Zero(mesh.vertex_count(), 3)));
}

}  // namespace

HarmonicMap::HarmonicMap(const PnTriangleMesh& mesh,
                         const std::function<Vec2(const Vec3&)>& boundary_parameter)
    : mesh_(mesh), flat_(laid_flat(mesh.mesh(), boundary_parameter)), search_(flat_) {}

Vec3 HarmonicMap::surface_point(const Vec2& parameter) const {
  const auto found = search_.nearest({parameter.x(), parameter.y(), 0});
  return mesh_.triangle(found->triangle).at(found->weights);
}

}  // namespace batten
