#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/differential_operators.h"
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

void check_constraints(const FrameConstraints& constraints, int nodes) {
  DeformProblem problem;
  problem.fixed = constraints.fixed;
  problem.handles = constraints.handles;
  problem.features = constraints.features;
  problem.point_constraints = constraints.point_constraints;
  check(problem, nodes);
  if (constraints.penalty_weight &&
      !(*constraints.penalty_weight > 0 && std::isfinite(*constraints.penalty_weight)))
    throw InputError("softness " + std::to_string(*constraints.penalty_weight) +
                     ", expected a number above 0");
}

}  // namespace

FrameSolverData::FrameSolverData(const TriangleMesh& mesh, FrameConstraints given,
                                 const FrameOptions& opts)
    : constraints(std::move(given)),
      options(opts),
      size(mesh.size()),
      graph(node_graph(mesh.topology(), edge_weights(mesh, opts.weights))),
      unknowns((check_constraints(constraints, graph.nodes), frame_unknowns(graph, constraints))) {
  if (constraints.preserve_volume) set_triangles(mesh);
  factorize();
  compute_handle_weights();
  couple_point_constraints();
  const int n = graph.nodes;
  rest.setZero(n, 3), now.setZero(n, 3), offset.setZero(n, 3), loads.setZero(n, 3);
  y = rhs = accelerated = MatX::Zero(unknowns.count, 3);
  accelerator.resize(unknowns.count);
  shape.positions.setZero(n, 3);
  shape.rotations.assign(n, Mat3::Identity());
  part_rotations.assign(unknowns.parts.size(), Mat3::Identity());
  part_rest.assign(unknowns.parts.size(), Vec3::Zero());
  part_position = part_rest;
  handle_rotations.assign(constraints.handles.size(), Mat3::Identity());
  handle_rest.assign(constraints.handles.size(), Vec3::Zero());
  rotation_from_part.assign(n, 0);
}

void FrameSolverData::set_triangles(const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  if (!topology.boundary_loops().empty() || !topology.non_manifold_loops().empty())
    throw InputError("the volume cannot be kept: the surface is not closed");
  for (auto t : topology.triangles()) {
    for (int& v : t) v = topology.node_of(v);
    triangles.push_back(t);
  }
}

void FrameSolverData::factorize() {
  if (unknowns.count == 0) return;
  const SparseMatrix K = frame_matrix(graph, unknowns, half_penalty_weight());
  factor.analyze(K, FactorReuse::once);
  if (!factor.factorize(K)) throw NoSolutionError("frames: " + factor.message());
}

void FrameSolverData::compute_handle_weights() {
  const auto handles = static_cast<long>(constraints.handles.size());
  handle_weights = MatX::Zero(graph.nodes, handles);
  MatX loads_of = MatX::Zero(unknowns.count, handles);
  for (const auto& part : unknowns.parts)
    if (part.handle >= 0)
      for (const int v : part.nodes) handle_weights(v, part.handle) = 1;
  for (const auto& e : graph.edges) {
    const int a = unknowns.unknown_of_node[e.a], b = unknowns.unknown_of_node[e.b];
    if (a >= 0 && b < 0) loads_of.row(a) += e.weight * handle_weights.row(e.b);
    if (b >= 0 && a < 0) loads_of.row(b) += e.weight * handle_weights.row(e.a);
  }
  for (const auto& d : unknowns.penalized_nodes)
    if (const int a = unknowns.unknown_of_node[d.node]; a >= 0)
      loads_of(a, d.handle) += half_penalty_weight();
  if (unknowns.count > 0 && handles > 0) factor.solve_in_place(loads_of);
  for (int v = 0; v < graph.nodes; ++v)
    if (unknowns.unknown_of_node[v] >= 0)
      handle_weights.row(v) = loads_of.row(unknowns.unknown_of_node[v]);
}

void FrameSolverData::couple_point_constraints() {
  std::vector<SchurComplementConstraints::Constraint> rows;
  std::vector<Triplet> entries;
  for (int k = 0; k < isize(constraints.point_constraints); ++k) {
    const PointConstraint& constraint = constraints.point_constraints[k];
    for (const auto& entry : constraint.point.entries)
      if (const int a = unknowns.unknown_of_node[entry.vertex]; a >= 0)
        entries.emplace_back(a, k, entry.coefficient);
    const Vec3 d = constraint.direction.normalized();
    if (constraint.kind == PointConstraint::Kind::OnPlane) {
      rows.push_back({k, d, 1});
    } else {
      const Vec3 across = d.unitOrthogonal();
      rows.push_back({k, across, 1});
      rows.push_back({k, d.cross(across), 1});
    }
  }
  if (rows.empty()) return;
  SparseMatrix U(unknowns.count, isize(constraints.point_constraints));
  U.setFromTriplets(entries.begin(), entries.end());
  point_equations = rows;
  constraint_origins = SchurComplementConstraints(factor, std::move(U), std::move(rows));
  point_equation_rhs.setZero(constraint_origins.constraint_count());
}

}  // namespace batten
