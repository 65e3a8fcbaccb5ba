#include "batten/mesh/sequence/frame_solver.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/mesh/rotation_of_faces.h"
#include "batten/mesh/sequence/enclosed_volume.h"
#include "batten/mesh/sequence/frame_solver_data.h"
#include "batten/mesh/sequence/handle_turns.h"

namespace batten {

void FrameSolverData::begin(const Points& frame, const FramePlaces& given) {
  if (frame.rows() != graph.nodes || !frame.allFinite())
    throw InputError("a frame of " + std::to_string(frame.rows()) + " nodes, expected " +
                     std::to_string(graph.nodes) + " with finite coordinates");
  if (given.handles.size() != holds.handles.size())
    throw InputError(std::to_string(given.handles.size()) + " places of handles, expected " +
                     std::to_string(holds.handles.size()));
  if (!given.guides.empty() && given.guides.size() != holds.guided.size())
    throw InputError(std::to_string(given.guides.size()) + " points of guides, expected " +
                     std::to_string(holds.guided.size()));
  for (const auto& place : given.handles)
    if (!place.motion.turn.allFinite() || !(place.motion.shift.cwiseAbs().maxCoeff() < 1e100))
      throw InputError("a place of a handle is not finite, or above 1e100");
  rest = frame;
  places = given;
  for (const auto& s : unknowns.shared) {
    const Vec3 p = rest.row(s.node).transpose();
    const double apart =
        (places.handles[s.one].motion(p) - places.handles[s.other].motion(p)).norm();
    if (apart > 1e-9 * size && !holds.softness)
      throw ConflictError({{{holds.handles[s.one].name, holds.handles[s.other].name}, apart}});
  }
  for (size_t h = 0; h < holds.handles.size(); ++h) {
    handle_rest[h] = centre_of(holds.handles[h].vertices, rest);
    handle_turns[h] = places.handles[h].motion.turn;
  }
  offset.setZero();
  for (size_t k = 0; k < unknowns.parts.size(); ++k) {
    const auto& part = unknowns.parts[k];
    part_rest[k] = part.handle >= 0 ? handle_rest[part.handle] : centre_of(part.nodes, rest);
    part_place[k] =
        part.handle >= 0 ? places.handles[part.handle].motion(part_rest[k]) : part_rest[k];
    part_turns[k] = part.handle >= 0 ? handle_turns[part.handle] : Mat3::Identity();
    for (const int v : part.nodes) keeps_turn[v] = turns_by_itself(k) || !part.may_turn;
  }
  volume = holds.keeps_volume ? enclosed_volume(triangles, rest) : 0;
  set_guides();
  report = {};
  mixing.reset();
  begun = true;
}

void FrameSolverData::start_from_handles() {
  spread_turns(share, places.handles, shape.turns);
  take_part_turns();
  y.setZero();
}

void FrameSolverData::take_part_turns() {
  for (size_t k = 0; k < unknowns.parts.size(); ++k) {
    if (turns_by_itself(k)) {
      Mat3 sum = Mat3::Zero();
      for (const int v : unknowns.parts[k].nodes) sum += shape.turns[v];
      part_turns[k] = rotation_part(sum);
    }
    set_offsets(k);
  }
  give_parts_turns();
}

void FrameSolverData::start_from(const Points& start) {
  if (start.rows() != graph.nodes || !start.allFinite())
    throw InputError("the start has " + std::to_string(start.rows()) + " points, expected " +
                     std::to_string(graph.nodes) + " finite ones");
  const RowPoints at = start;
  std::fill(shape.turns.begin(), shape.turns.end(), Mat3::Identity());
  turn_rings(graph, rest, at, {}, shape.turns, chunk_sums);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.of_node[v]; a >= 0) y.row(a) = at.row(v) - rest.row(v);
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      y.row(a) = (centre_of(unknowns.parts[k].nodes, at) - part_rest[k]).transpose();
  place_nodes();
  take_part_turns();
}

FrameSolver::FrameSolver(const TriangleMesh& mesh, FrameHolds holds, const FrameOptions& options)
    : data_(std::make_unique<FrameSolverData>(mesh, std::move(holds), options)) {}
FrameSolver::~FrameSolver() = default;
FrameSolver::FrameSolver(FrameSolver&&) noexcept = default;
FrameSolver& FrameSolver::operator=(FrameSolver&&) noexcept = default;

void FrameSolver::alternate(const Points& frame, const FramePlaces& places) {
  data_->begin(frame, places);
  data_->start_from_handles();
  data_->rounds(data_->options.most_rounds);
  data_->finish();
}

void FrameSolver::alternate(const Points& frame, const FramePlaces& places, const Points& start) {
  data_->begin(frame, places);
  data_->start_from(start);
  data_->rounds(data_->options.most_rounds);
  data_->finish();
}

bool FrameSolver::go_on(int rounds) {
  if (!data_->begun) throw InputError("a frame that was not begun cannot go on");
  data_->rounds(data_->report.rounds + rounds);
  data_->finish();
  return data_->report.converged;
}

void FrameSolver::reconstruct(const Points& frame, const FramePlaces& places,
                              const std::vector<Mat3>& turns, int rounds) {
  if (count_of(turns) != data_->graph.nodes)
    throw InputError(std::to_string(turns.size()) + " rotations, expected " +
                     std::to_string(data_->graph.nodes));
  data_->begin(frame, places);
  data_->shape.turns = turns;
  data_->take_part_turns();
  data_->y.setZero();
  data_->solve_positions();
  data_->y.swap(data_->right);
  data_->place_nodes();
  if (rounds > 0) {
    data_->settle();
    data_->rounds(rounds);
  }
  data_->finish();
}

const FrameShape& FrameSolver::result() const { return data_->shape; }
const EstimateReport& FrameSolver::report() const { return data_->report; }
int FrameSolver::unknowns() const { return data_->unknowns.count; }
long FrameSolver::factor_entries() const {
  return data_->unknowns.count > 0 ? data_->factor.factor_entries() : 0;
}
const std::vector<std::string>& FrameSolver::notes() const { return data_->unknowns.notes; }

}  // namespace batten
