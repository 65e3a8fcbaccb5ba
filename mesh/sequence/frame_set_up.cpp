#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/operators.h"
#include "batten/mesh/sequence/frame_solver_data.h"

namespace batten {
namespace {

std::vector<double> edge_weights(const TriangleMesh& mesh, FrameOptions::Weights kind) {
  if (kind == FrameOptions::Weights::Uniform) return {};
  std::vector<double> weights = edge_cotangents(mesh);
  double mean = 0;
  for (const double w : weights) mean += std::max(w, 0.0) / static_cast<double>(weights.size());
  for (double& w : weights) w = std::max(w, 0.1 * mean);
  return weights;
}

void check_holds(const FrameHolds& holds, int nodes) {
  DeformProblem problem;
  problem.fixed = holds.fixed;
  problem.handles = holds.handles;
  problem.features = holds.features;
  problem.guided = holds.guided;
  check(problem, nodes);
  if (holds.softness && !(*holds.softness > 0 && std::isfinite(*holds.softness)))
    throw InputError("softness " + std::to_string(*holds.softness) + ", expected a number above 0");
}

}  // namespace

FrameSolverData::FrameSolverData(const TriangleMesh& mesh, FrameHolds given,
                                 const FrameOptions& opts)
    : holds(std::move(given)),
      options(opts),
      size(mesh.size()),
      graph(ring_graph(mesh.topology(), edge_weights(mesh, opts.weights))),
      unknowns((check_holds(holds, graph.nodes), frame_unknowns(graph, holds))),
      mixing(unknowns.count) {
  if (holds.keeps_volume) set_triangles(mesh);
  factorize();
  share_turns();
  couple_guides();
  const int n = graph.nodes;
  rest.setZero(n, 3), now.setZero(n, 3), offset.setZero(n, 3), loads.setZero(n, 3);
  y = right = mixed = MatX::Zero(unknowns.count, 3);
  shape.positions.setZero(n, 3);
  shape.turns.assign(n, Mat3::Identity());
  part_turns.assign(unknowns.parts.size(), Mat3::Identity());
  part_rest.assign(unknowns.parts.size(), Vec3::Zero());
  part_place = part_rest;
  handle_turns.assign(holds.handles.size(), Mat3::Identity());
  handle_rest.assign(holds.handles.size(), Vec3::Zero());
  keeps_turn.assign(n, 0);
}

void FrameSolverData::set_triangles(const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  if (!topology.boundary_loops().empty() || !topology.joint_loops().empty())
    throw InputError("the volume cannot be kept: the surface is not closed");
  for (auto t : topology.triangles()) {
    for (int& v : t) v = topology.node_of(v);
    triangles.push_back(t);
  }
}

void FrameSolverData::factorize() {
  if (unknowns.count == 0) return;
  const SparseMatrix K = frame_matrix(graph, unknowns, half_softness());
  factor.analyze(K, Expected::one_factor);
  if (!factor.factorize(K)) throw NoSolutionError("frames: " + factor.message());
}

void FrameSolverData::share_turns() {
  const auto handles = static_cast<long>(holds.handles.size());
  share = MatX::Zero(graph.nodes, handles);
  MatX loads_of = MatX::Zero(unknowns.count, handles);
  for (const auto& part : unknowns.parts)
    if (part.handle >= 0)
      for (const int v : part.nodes) share(v, part.handle) = 1;
  for (const auto& e : graph.edges) {
    const int a = unknowns.of_node[e.a], b = unknowns.of_node[e.b];
    if (a >= 0 && b < 0) loads_of.row(a) += e.weight * share.row(e.b);
    if (b >= 0 && a < 0) loads_of.row(b) += e.weight * share.row(e.a);
  }
  for (const auto& d : unknowns.drawn)
    if (const int a = unknowns.of_node[d.node]; a >= 0) loads_of(a, d.handle) += half_softness();
  if (unknowns.count > 0 && handles > 0) factor.solve_in_place(loads_of);
  for (int v = 0; v < graph.nodes; ++v)
    if (unknowns.of_node[v] >= 0) share.row(v) = loads_of.row(unknowns.of_node[v]);
}

void FrameSolverData::couple_guides() {
  std::vector<Coupling::Row> rows;
  std::vector<Triplet> entries;
  for (int k = 0; k < count_of(holds.guided); ++k) {
    const GuidedPoint& guide = holds.guided[k];
    for (const auto& entry : guide.point.entries)
      if (const int a = unknowns.of_node[entry.vertex]; a >= 0)
        entries.emplace_back(a, k, entry.coefficient);
    const Vec3 d = guide.direction.normalized();
    if (guide.kind == GuidedPoint::Kind::OnPlane) {
      rows.push_back({k, d, 1});
    } else {
      const Vec3 across = d.unitOrthogonal();
      rows.push_back({k, across, 1});
      rows.push_back({k, d.cross(across), 1});
    }
  }
  if (rows.empty()) return;
  SparseMatrix U(unknowns.count, count_of(holds.guided));
  U.setFromTriplets(entries.begin(), entries.end());
  guide_rows = rows;
  guides = Coupling(factor, std::move(U), std::move(rows));
  guide_right.setZero(guides.rows());
}

}  // namespace batten
