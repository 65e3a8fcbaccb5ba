// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/frame_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/regions/local_global_iteration.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/frame_constraints.h"
#include "batten/mesh/sequence/frame_unknowns.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {

// Implementation of FrameSolver: the linear system and the state of the current frame.

struct FrameSolverData final : public LocalGlobalIteration {
  FrameSolverData(const TriangleMesh& mesh, FrameConstraints given, const FrameOptions& opts);

  // Set-up, once per solver.
  void set_triangles(const TriangleMesh& mesh);
  void factorize();
  // Interpolation weights of handle rotations: 1 on the handle, 0 on other constrained nodes,
  // harmonic in between.
  void compute_handle_weights();
  void couple_point_constraints();

  // Start of a frame.
  void begin_frame(const Points& frame, const FrameTargets& given);
  void start_from_handles();
  void start_from(const Points& start);
  void start_from_rotations(const std::vector<Mat3>& rotations);
  // Sets parts with free rotation to the mean rotation of their nodes, then sets the offsets of all
  // parts.
  void init_part_rotations();

  // Iterations.
  // λ/2: each edge counts once in the global step, but twice in E.
  double half_penalty_weight() const { return 0.5 * constraints.penalty_weight.value_or(0); }
  bool rotates_freely(size_t part) const;
  // Sets the offsets of the nodes of a part: their displacement beyond that of the part's unknown.
  void set_offsets(size_t k);
  void set_point_constraints();
  void update_positions();
  void update_positions_at(MatX& other);
  // Exact minimum over the rotation of a part, with its centre and surroundings fixed.
  void fit_part_rotation(size_t k);
  Vec3 target(const FrameUnknowns::PenalizedNode& d) const;
  void global_step() override;
  double update_rotations() override;
  void store_rotations() override;
  void restore_rotations() override;
  void assign_part_rotations();
  // Corrects the volume along z = K⁻¹ ∂V. ∂V is taken at the previous shape, so that the converged
  // shape minimises E among shapes of this volume. In the first iteration it is taken at the result
  // of the linear step.
  void restore_volume();
  void iterations(int most) { run(most, options.tolerance); }
  void finish() { shape.positions = now; }

  FrameConstraints constraints;
  FrameOptions options;
  NodeGraph graph;
  FrameUnknowns unknowns;
  SparseCholesky factor;
  MatX handle_weights;  // nodes × handles
  SchurComplementConstraints constraint_origins;
  std::vector<SchurComplementConstraints::Constraint> point_equations;
  VecX point_equation_rhs;
  std::vector<std::array<int, 3>> triangles;  // for the volume
  double volume = 0;

  FrameTargets targets;
  RowPoints rest, now, offset, loads, gradient;  // per node
  MatX volume_direction;                         // per unknown
  std::vector<Mat3> part_rotations, handle_rotations;
  std::vector<Mat3> rotations_before, part_rotations_before, handle_rotations_before;
  std::vector<Vec3> part_rest, part_position, handle_rest;
  std::vector<char> rotation_from_part;  // nodes whose R_i is the rotation of their part
  std::vector<double> chunk_sums;
  bool begun = false;
  FrameShape shape;
};

void FrameSolverData::begin_frame(const Points& frame, const FrameTargets& given) {
  if (frame.rows() != graph.nodes || !frame.allFinite())
    throw InputError("found a frame of " + std::to_string(frame.rows()) + " nodes, expected " +
                     std::to_string(graph.nodes) + " with finite coordinates");
  if (given.handles.size() != constraints.handles.size())
    throw InputError("found poses of " + std::to_string(given.handles.size()) +
                     " handles, expected " + std::to_string(constraints.handles.size()));
  if (!given.constraint_origins.empty() &&
      given.constraint_origins.size() != constraints.point_constraints.size())
    throw InputError("found " + std::to_string(given.constraint_origins.size()) +
                     " origins of point constraints, expected " +
                     std::to_string(constraints.point_constraints.size()));
  for (const auto& pose : given.handles)
    if (!pose.motion.rotation.allFinite() ||
        !(pose.motion.translation.cwiseAbs().maxCoeff() < 1e100))
      throw InputError("the pose of a handle is not finite, or above 1e100");
  rest = frame;
  targets = given;
  for (const auto& s : unknowns.shared) {
    const Vec3 p = rest.row(s.node).transpose();
    const double apart =
        (targets.handles[s.one].motion(p) - targets.handles[s.other].motion(p)).norm();
    if (apart > 1e-9 * size_ && !constraints.penalty_weight)
      throw ConflictError(
          {{{constraints.handles[s.one].name, constraints.handles[s.other].name}, apart}});
  }
  for (size_t h = 0; h < constraints.handles.size(); ++h) {
    handle_rest[h] = centre_of(constraints.handles[h].vertices, rest);
    handle_rotations[h] = targets.handles[h].motion.rotation;
  }
  offset.setZero();
  for (size_t k = 0; k < unknowns.parts.size(); ++k) {
    const auto& part = unknowns.parts[k];
    part_rest[k] = part.handle >= 0 ? handle_rest[part.handle] : centre_of(part.nodes, rest);
    part_position[k] =
        part.handle >= 0 ? targets.handles[part.handle].motion(part_rest[k]) : part_rest[k];
    part_rotations[k] = part.handle >= 0 ? handle_rotations[part.handle] : Mat3::Identity();
    for (const int v : part.nodes) rotation_from_part[v] = rotates_freely(k) || !part.may_rotate;
  }
  volume = constraints.preserve_volume ? enclosed_volume(triangles, rest) : 0;
  set_point_constraints();
  begin();
  begun = true;
}

void FrameSolverData::start_from_handles() {
  spread_rotations(handle_weights, targets.handles, shape.rotations);
  init_part_rotations();
  y_.setZero();
}

void FrameSolverData::init_part_rotations() {
  for (size_t k = 0; k < unknowns.parts.size(); ++k) {
    if (rotates_freely(k)) {
      Mat3 sum = Mat3::Zero();
      for (const int v : unknowns.parts[k].nodes) sum += shape.rotations[v];
      part_rotations[k] = nearest_rotation(sum);
    }
    set_offsets(k);
  }
  assign_part_rotations();
}

void FrameSolverData::start_from(const Points& start) {
  if (start.rows() != graph.nodes || !start.allFinite())
    throw InputError("the initial guess has " + std::to_string(start.rows()) +
                     " points, expected " + std::to_string(graph.nodes) + " finite ones");
  const RowPoints at = start;
  std::fill(shape.rotations.begin(), shape.rotations.end(), Mat3::Identity());
  local_step(graph, rest, at, {}, shape.rotations, chunk_sums);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0) y_.row(a) = at.row(v) - rest.row(v);
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      y_.row(a) = (centre_of(unknowns.parts[k].nodes, at) - part_rest[k]).transpose();
  update_positions();
  init_part_rotations();
}

void FrameSolverData::start_from_rotations(const std::vector<Mat3>& rotations) {
  shape.rotations = rotations;
  init_part_rotations();
  y_.setZero();
  solve_unknowns();
  y_.swap(next_);
  update_positions();
}

FrameSolver::FrameSolver(const TriangleMesh& mesh, FrameConstraints constraints,
                         const FrameOptions& options)
    : data_(std::make_unique<FrameSolverData>(mesh, std::move(constraints), options)) {}
FrameSolver::~FrameSolver() = default;
FrameSolver::FrameSolver(FrameSolver&&) noexcept = default;
FrameSolver& FrameSolver::operator=(FrameSolver&&) noexcept = default;

void FrameSolver::alternate(const Points& frame, const FrameTargets& targets) {
  data_->begin_frame(frame, targets);
  data_->start_from_handles();
  data_->iterations(data_->options.max_iterations);
  data_->finish();
}

void FrameSolver::alternate(const Points& frame, const FrameTargets& targets, const Points& start) {
  data_->begin_frame(frame, targets);
  data_->start_from(start);
  data_->iterations(data_->options.max_iterations);
  data_->finish();
}

bool FrameSolver::iterate(int iterations) {
  if (!data_->begun)
    throw InputError("iterate() without a frame: call alternate() or reconstruct() first");
  data_->iterations(data_->report().iterations + iterations);
  data_->finish();
  return data_->report().converged;
}

void FrameSolver::reconstruct(const Points& frame, const FrameTargets& targets,
                              const std::vector<Mat3>& rotations, int iterations) {
  if (isize(rotations) != data_->graph.nodes)
    throw InputError("found " + std::to_string(rotations.size()) + " rotations, expected " +
                     std::to_string(data_->graph.nodes));
  data_->begin_frame(frame, targets);
  data_->start_from_rotations(rotations);
  if (iterations > 0) {
    data_->update_rotations();
    data_->iterations(iterations);
  }
  data_->finish();
}

const FrameShape& FrameSolver::result() const { return data_->shape; }
const IterationReport& FrameSolver::report() const { return data_->report(); }
int FrameSolver::unknowns() const { return data_->unknowns.count; }
long FrameSolver::factor_entries() const {
  return data_->unknowns.count > 0 ? data_->factor.factor_entries() : 0;
}
const std::vector<std::string>& FrameSolver::notes() const { return data_->unknowns.notes; }

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
    throw InputError("found penalty = " + std::to_string(*constraints.penalty_weight) +
                     ", expected a number above 0");
}

}  // namespace

FrameSolverData::FrameSolverData(const TriangleMesh& mesh, FrameConstraints given,
                                 const FrameOptions& opts)
    : LocalGlobalIteration(mesh.size(), "deformation of frames"),
      constraints(std::move(given)),
      options(opts),
      graph(node_graph(mesh.topology(), edge_weights(mesh, opts.weights))),
      unknowns((check_constraints(constraints, graph.nodes), frame_unknowns(graph, constraints))) {
  if (constraints.preserve_volume) set_triangles(mesh);
  factorize();
  compute_handle_weights();
  couple_point_constraints();
  const int n = graph.nodes;
  rest.setZero(n, 3), now.setZero(n, 3), offset.setZero(n, 3), loads.setZero(n, 3);
  resize(unknowns.count, unknowns.count);
  // Positions of constant volume do not minimise the energy, so they are not accelerated.
  accelerates_ = !constraints.preserve_volume;
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
    throw InputError(
        "preserve_volume needs a closed surface, found one with free or non-manifold edges");
  for (auto t : topology.triangles()) {
    for (int& v : t) v = topology.node_of(v);
    triangles.push_back(t);
  }
}

void FrameSolverData::factorize() {
  if (unknowns.count == 0) return;
  const SparseMatrix K = frame_matrix(graph, unknowns, half_penalty_weight());
  factor.analyze(K, FactorReuse::once);
  if (!factor.factorize(K)) throw NoSolutionError("deformation of frames: " + factor.message());
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

bool FrameSolverData::rotates_freely(size_t part) const {
  const auto& p = unknowns.parts[part];
  return p.handle >= 0 ? targets.handles[p.handle].free_rotation : p.may_rotate;
}

void FrameSolverData::set_offsets(size_t k) {
  const auto& part = unknowns.parts[k];
  const bool exact = part.handle >= 0 && !targets.handles[part.handle].free_rotation;
  for (const int v : part.nodes) {
    const Vec3 p = rest.row(v).transpose();
    const Vec3 to = exact ? targets.handles[part.handle].motion(p)
                          : Vec3(part_position[k] + part_rotations[k] * (p - part_rest[k]));
    offset.row(v) = (to - p).transpose();
    if (part.unknown >= 0) offset.row(v) -= (part_position[k] - part_rest[k]).transpose();
  }
}

void FrameSolverData::set_point_constraints() {
  if (constraint_origins.empty()) return;
  for (int r = 0; r < constraint_origins.constraint_count(); ++r) {
    const auto& row = point_equations[r];
    const auto& point = constraints.point_constraints[row.point].point;
    Vec3 rest_point = Vec3::Zero(), there = Vec3::Zero();
    for (const auto& e : point.entries) {
      rest_point += e.coefficient * rest.row(e.vertex).transpose();
      there += e.coefficient * (rest.row(e.vertex) + offset.row(e.vertex)).transpose();
    }
    const Vec3 to =
        targets.constraint_origins.empty() ? rest_point : targets.constraint_origins[row.point];
    point_equation_rhs[r] = row.direction.dot(to - there);
  }
}

void FrameSolverData::update_positions() {
  for (int v = 0; v < graph.nodes; ++v) {
    const int a = unknowns.unknown_of_node[v];
    now.row(v) = rest.row(v) + offset.row(v);
    if (a >= 0) now.row(v) += y_.row(a);
  }
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      part_position[k] = part_rest[k] + y_.row(a).transpose();
}

void FrameSolverData::fit_part_rotation(size_t k) {
  const auto& part = unknowns.parts[k];
  const Vec3 &c = part_position[k], &c0 = part_rest[k];
  Mat3 M = Mat3::Zero();
  for (const int e : part.edges) {
    const auto& edge = graph.edges[e];
    const bool low = unknowns.part_of_node[edge.a] == static_cast<int>(k);
    const int i = low ? edge.a : edge.b, j = low ? edge.b : edge.a;
    const Vec3 p = rest.row(i).transpose(), q = rest.row(j).transpose();
    const Vec3 to = now.row(j).transpose() - c;
    M += edge.weight *
         (to * (q - c0).transpose() + (to + shape.rotations[j] * (p - q)) * (p - c0).transpose());
  }
  if (constraints.penalty_weight && part.handle < 0)
    for (const auto& d : unknowns.penalized_nodes)
      if (unknowns.part_of_node[d.node] == static_cast<int>(k))
        M += *constraints.penalty_weight * (target(d) - c) *
             (rest.row(d.node).transpose() - c0).transpose();
  // Relative to the current rotation: directions that M does not determine are not rotated further.
  part_rotations[k] = nearest_rotation(M * part_rotations[k].transpose()) * part_rotations[k];
  set_offsets(k);
  for (const int v : part.nodes) {
    const int a = unknowns.unknown_of_node[v];
    now.row(v) = rest.row(v) + offset.row(v);
    if (a >= 0) now.row(v) += y_.row(a);
  }
}

Vec3 FrameSolverData::target(const FrameUnknowns::PenalizedNode& d) const {
  const Vec3 p = rest.row(d.node).transpose();
  const HandlePose& pose = targets.handles[d.handle];
  if (!pose.free_rotation) return pose.motion(p);
  return pose.motion(handle_rest[d.handle]) +
         handle_rotations[d.handle] * (p - handle_rest[d.handle]);
}

double FrameSolverData::update_rotations() {
  update_positions();
  if (constraints.penalty_weight)
    fit_free_handles(constraints.handles, targets.handles, rest, handle_rest, now,
                     handle_rotations);
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (rotates_freely(k)) fit_part_rotation(k);
  assign_part_rotations();
  double energy = local_step(graph, rest, now, rotation_from_part, shape.rotations, chunk_sums);
  for (const auto& d : unknowns.penalized_nodes)
    energy += *constraints.penalty_weight * (now.row(d.node).transpose() - target(d)).squaredNorm();
  return energy;
}

void FrameSolverData::assign_part_rotations() {
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    for (const int v : unknowns.parts[k].nodes)
      if (rotation_from_part[v]) shape.rotations[v] = part_rotations[k];
}

void FrameSolverData::global_step() {
  global_step_rhs(graph, rest, shape.rotations, loads);
  for (const int e : unknowns.offset_edges) {
    const auto& edge = graph.edges[e];
    const Eigen::RowVector3d pull = edge.weight * (offset.row(edge.a) - offset.row(edge.b));
    loads.row(edge.a) -= pull;
    loads.row(edge.b) += pull;
  }
  for (const auto& d : unknowns.penalized_nodes)
    loads.row(d.node) +=
        half_penalty_weight() * (target(d).transpose() - rest.row(d.node) - offset.row(d.node));
  next_.setZero();
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0) next_.row(a) += loads.row(v);
  if (unknowns.count > 0) factor.solve_in_place(next_);
  if (!constraint_origins.empty()) {
    set_point_constraints();
    constraint_origins.apply(next_, point_equation_rhs);
  }
  if (constraints.preserve_volume) restore_volume();
}

void FrameSolverData::restore_volume() {
  if (report_.iterations == 0) update_positions_at(next_);
  volume_gradient(triangles, now, gradient);
  volume_direction.setZero(unknowns.count, 3);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0)
      volume_direction.row(a) += gradient.row(v);
  if (unknowns.count > 0) factor.solve_in_place(volume_direction);
  for (int step = 0; step < 5; ++step) {
    update_positions_at(next_);
    volume_gradient(triangles, now, gradient);
    double slope = 0;
    for (int v = 0; v < graph.nodes; ++v)
      if (const int a = unknowns.unknown_of_node[v]; a >= 0)
        slope += gradient.row(v).dot(volume_direction.row(a));
    const double volume_error = volume - enclosed_volume(triangles, now);
    if (!(slope > 0) || std::abs(volume_error) < 1e-15 * std::abs(volume)) return;
    next_ += volume_error / slope * volume_direction;
  }
}

void FrameSolverData::update_positions_at(MatX& other) {
  y_.swap(other);
  update_positions();
  y_.swap(other);
}

void FrameSolverData::store_rotations() {
  rotations_before = shape.rotations;
  part_rotations_before = part_rotations;
  handle_rotations_before = handle_rotations;
}

void FrameSolverData::restore_rotations() {
  shape.rotations = rotations_before;
  part_rotations = part_rotations_before;
  handle_rotations = handle_rotations_before;
  for (size_t k = 0; k < unknowns.parts.size(); ++k) set_offsets(k);
}

}  // namespace batten
