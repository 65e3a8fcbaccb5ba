#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/enclosed_volume.h"
#include "batten/mesh/sequence/frame_solver_data.h"
#include "batten/mesh/sequence/handle_rotations.h"

namespace batten {

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
    if (a >= 0) now.row(v) += y.row(a);
  }
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      part_position[k] = part_rest[k] + y.row(a).transpose();
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
  // Relative to the turn it has: where M does not tell, the part turns no further.
  part_rotations[k] = nearest_rotation(M * part_rotations[k].transpose()) * part_rotations[k];
  set_offsets(k);
  for (const int v : part.nodes) {
    const int a = unknowns.unknown_of_node[v];
    now.row(v) = rest.row(v) + offset.row(v);
    if (a >= 0) now.row(v) += y.row(a);
  }
}

Vec3 FrameSolverData::target(const FrameUnknowns::PenalizedNode& d) const {
  const Vec3 p = rest.row(d.node).transpose();
  const HandlePose& pose = targets.handles[d.handle];
  if (!pose.free_rotation) return pose.motion(p);
  return pose.motion(handle_rest[d.handle]) +
         handle_rotations[d.handle] * (p - handle_rest[d.handle]);
}

void FrameSolverData::rotate_penalized_handles() {
  if (!constraints.penalty_weight) return;
  for (size_t h = 0; h < constraints.handles.size(); ++h) {
    if (!targets.handles[h].free_rotation) continue;
    const Vec3 c = targets.handles[h].motion(handle_rest[h]);
    handle_rotations[h] = best_rotation(constraints.handles[h].vertices, rest, handle_rest[h], now,
                                        c, handle_rotations[h]);
  }
}

double FrameSolverData::update_rotations() {
  update_positions();
  rotate_penalized_handles();
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
  rhs.setZero();
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0) rhs.row(a) += loads.row(v);
  if (unknowns.count > 0) factor.solve_in_place(rhs);
  if (!constraint_origins.empty()) {
    set_point_constraints();
    constraint_origins.apply(rhs, point_equation_rhs);
  }
  if (constraints.preserve_volume) restore_volume();
  if (!rhs.allFinite()) throw NoSolutionError("frames: positions are not finite");
  report.last_change =
      size > 0 && unknowns.count > 0 ? (rhs - y).rowwise().norm().maxCoeff() / size : 0;
}

void FrameSolverData::restore_volume() {
  if (report.iterations == 0) update_positions_at(rhs);
  volume_gradient(triangles, now, gradient);
  volume_direction.setZero(unknowns.count, 3);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0)
      volume_direction.row(a) += gradient.row(v);
  if (unknowns.count > 0) factor.solve_in_place(volume_direction);
  for (int step = 0; step < 5; ++step) {
    update_positions_at(rhs);
    volume_gradient(triangles, now, gradient);
    double slope = 0;
    for (int v = 0; v < graph.nodes; ++v)
      if (const int a = unknowns.unknown_of_node[v]; a >= 0)
        slope += gradient.row(v).dot(volume_direction.row(a));
    const double volume_error = volume - enclosed_volume(triangles, now);
    if (!(slope > 0) || std::abs(volume_error) < 1e-15 * std::abs(volume)) return;
    rhs += volume_error / slope * volume_direction;
  }
}

void FrameSolverData::update_positions_at(MatX& other) {
  y.swap(other);
  update_positions();
  y.swap(other);
}

double FrameSolverData::iterate(double before) {
  global_step();
  const bool accelerate =
      !constraints.preserve_volume && accelerator.accelerate(y, rhs, accelerated);
  rotations_before = shape.rotations;
  part_rotations_before = part_rotations;
  handle_rotations_before = handle_rotations;
  y.swap(accelerate ? accelerated : rhs);
  double energy = update_rotations();
  if (accelerate && !(energy <= before)) {
    shape.rotations = rotations_before;
    part_rotations = part_rotations_before;
    handle_rotations = handle_rotations_before;
    for (size_t k = 0; k < unknowns.parts.size(); ++k) set_offsets(k);
    y.swap(rhs);
    accelerator.reset();
    energy = update_rotations();
  }
  return energy;
}

void FrameSolverData::iterations(int most) {
  while (report.iterations < most && !report.converged) {
    report.energies.push_back(iterate(report.energies.empty()
                                          ? std::numeric_limits<double>::infinity()
                                          : report.energies.back()));
    if (++report.iterations == 1) accelerator.reset();  // its turns came from elsewhere
    report.converged = report.last_change < options.tolerance;
  }
}

}  // namespace batten
