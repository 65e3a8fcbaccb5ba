#include "batten/mesh/sequence/frame_solver.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/enclosed_volume.h"
#include "batten/mesh/sequence/frame_solver_data.h"
#include "batten/mesh/sequence/handle_rotations.h"

namespace batten {

void FrameSolverData::begin(const Points& frame, const FrameTargets& given) {
  if (frame.rows() != graph.nodes || !frame.allFinite())
    throw InputError("a frame of " + std::to_string(frame.rows()) + " nodes, expected " +
                     std::to_string(graph.nodes) + " with finite coordinates");
  if (given.handles.size() != constraints.handles.size())
    throw InputError(std::to_string(given.handles.size()) + " places of handles, expected " +
                     std::to_string(constraints.handles.size()));
  if (!given.constraint_origins.empty() &&
      given.constraint_origins.size() != constraints.point_constraints.size())
    throw InputError(std::to_string(given.constraint_origins.size()) +
                     " points of guides, expected " +
                     std::to_string(constraints.point_constraints.size()));
  for (const auto& pose : given.handles)
    if (!pose.motion.rotation.allFinite() ||
        !(pose.motion.translation.cwiseAbs().maxCoeff() < 1e100))
      throw InputError("a place of a handle is not finite, or above 1e100");
  rest = frame;
  targets = given;
  for (const auto& s : unknowns.shared) {
    const Vec3 p = rest.row(s.node).transpose();
    const double apart =
        (targets.handles[s.one].motion(p) - targets.handles[s.other].motion(p)).norm();
    if (apart > 1e-9 * size && !constraints.penalty_weight)
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
  report = {};
  accelerator.reset();
  begun = true;
}

void FrameSolverData::start_from_handles() {
  spread_rotations(handle_weights, targets.handles, shape.rotations);
  init_part_rotations();
  y.setZero();
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
    throw InputError("the start has " + std::to_string(start.rows()) + " points, expected " +
                     std::to_string(graph.nodes) + " finite ones");
  const RowPoints at = start;
  std::fill(shape.rotations.begin(), shape.rotations.end(), Mat3::Identity());
  local_step(graph, rest, at, {}, shape.rotations, chunk_sums);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.unknown_of_node[v]; a >= 0) y.row(a) = at.row(v) - rest.row(v);
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      y.row(a) = (centre_of(unknowns.parts[k].nodes, at) - part_rest[k]).transpose();
  update_positions();
  init_part_rotations();
}

FrameSolver::FrameSolver(const TriangleMesh& mesh, FrameConstraints constraints,
                         const FrameOptions& options)
    : data_(std::make_unique<FrameSolverData>(mesh, std::move(constraints), options)) {}
FrameSolver::~FrameSolver() = default;
FrameSolver::FrameSolver(FrameSolver&&) noexcept = default;
FrameSolver& FrameSolver::operator=(FrameSolver&&) noexcept = default;

void FrameSolver::alternate(const Points& frame, const FrameTargets& targets) {
  data_->begin(frame, targets);
  data_->start_from_handles();
  data_->iterations(data_->options.max_iterations);
  data_->finish();
}

void FrameSolver::alternate(const Points& frame, const FrameTargets& targets, const Points& start) {
  data_->begin(frame, targets);
  data_->start_from(start);
  data_->iterations(data_->options.max_iterations);
  data_->finish();
}

bool FrameSolver::iterate(int iterations) {
  if (!data_->begun) throw InputError("a frame that was not begun cannot go on");
  data_->iterations(data_->report.iterations + iterations);
  data_->finish();
  return data_->report.converged;
}

void FrameSolver::reconstruct(const Points& frame, const FrameTargets& targets,
                              const std::vector<Mat3>& rotations, int iterations) {
  if (isize(rotations) != data_->graph.nodes)
    throw InputError(std::to_string(rotations.size()) + " rotations, expected " +
                     std::to_string(data_->graph.nodes));
  data_->begin(frame, targets);
  data_->shape.rotations = rotations;
  data_->init_part_rotations();
  data_->y.setZero();
  data_->global_step();
  data_->y.swap(data_->rhs);
  data_->update_positions();
  if (iterations > 0) {
    data_->update_rotations();
    data_->iterations(iterations);
  }
  data_->finish();
}

const FrameShape& FrameSolver::result() const { return data_->shape; }
const IterationReport& FrameSolver::report() const { return data_->report; }
int FrameSolver::unknowns() const { return data_->unknowns.count; }
long FrameSolver::factor_entries() const {
  return data_->unknowns.count > 0 ? data_->factor.factor_entries() : 0;
}
const std::vector<std::string>& FrameSolver::notes() const { return data_->unknowns.notes; }

}  // namespace batten
