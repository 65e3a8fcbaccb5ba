#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/mesh/rotation_of_faces.h"
#include "batten/mesh/sequence/enclosed_volume.h"
#include "batten/mesh/sequence/frame_solver_data.h"
#include "batten/mesh/sequence/handle_turns.h"

namespace batten {

bool FrameSolverData::turns_by_itself(size_t part) const {
  const auto& p = unknowns.parts[part];
  return p.handle >= 0 ? places.handles[p.handle].turns_freely : p.may_turn;
}

void FrameSolverData::set_offsets(size_t k) {
  const auto& part = unknowns.parts[k];
  const bool exact = part.handle >= 0 && !places.handles[part.handle].turns_freely;
  for (const int v : part.nodes) {
    const Vec3 p = rest.row(v).transpose();
    const Vec3 to = exact ? places.handles[part.handle].motion(p)
                          : Vec3(part_place[k] + part_turns[k] * (p - part_rest[k]));
    offset.row(v) = (to - p).transpose();
    if (part.unknown >= 0) offset.row(v) -= (part_place[k] - part_rest[k]).transpose();
  }
}

void FrameSolverData::set_guides() {
  if (guides.empty()) return;
  for (int r = 0; r < guides.rows(); ++r) {
    const auto& row = guide_rows[r];
    const auto& point = holds.guided[row.point].point;
    Vec3 rest_point = Vec3::Zero(), there = Vec3::Zero();
    for (const auto& e : point.entries) {
      rest_point += e.coefficient * rest.row(e.vertex).transpose();
      there += e.coefficient * (rest.row(e.vertex) + offset.row(e.vertex)).transpose();
    }
    const Vec3 to = places.guides.empty() ? rest_point : places.guides[row.point];
    guide_right[r] = row.direction.dot(to - there);
  }
}

void FrameSolverData::place_nodes() {
  for (int v = 0; v < graph.nodes; ++v) {
    const int a = unknowns.of_node[v];
    now.row(v) = rest.row(v) + offset.row(v);
    if (a >= 0) now.row(v) += y.row(a);
  }
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (const int a = unknowns.parts[k].unknown; a >= 0)
      part_place[k] = part_rest[k] + y.row(a).transpose();
}

void FrameSolverData::turn_part(size_t k) {
  const auto& part = unknowns.parts[k];
  const Vec3 &c = part_place[k], &c0 = part_rest[k];
  Mat3 M = Mat3::Zero();
  for (const int e : part.edges) {
    const auto& edge = graph.edges[e];
    const bool low = unknowns.part_of_node[edge.a] == static_cast<int>(k);
    const int i = low ? edge.a : edge.b, j = low ? edge.b : edge.a;
    const Vec3 p = rest.row(i).transpose(), q = rest.row(j).transpose();
    const Vec3 to = now.row(j).transpose() - c;
    M += edge.weight *
         (to * (q - c0).transpose() + (to + shape.turns[j] * (p - q)) * (p - c0).transpose());
  }
  if (holds.softness && part.handle < 0)
    for (const auto& d : unknowns.drawn)
      if (unknowns.part_of_node[d.node] == static_cast<int>(k))
        M += *holds.softness * (target(d) - c) * (rest.row(d.node).transpose() - c0).transpose();
  // Relative to the turn it has: where M does not tell, the part turns no further.
  part_turns[k] = rotation_part(M * part_turns[k].transpose()) * part_turns[k];
  set_offsets(k);
  for (const int v : part.nodes) {
    const int a = unknowns.of_node[v];
    now.row(v) = rest.row(v) + offset.row(v);
    if (a >= 0) now.row(v) += y.row(a);
  }
}

Vec3 FrameSolverData::target(const FrameUnknowns::Drawn& d) const {
  const Vec3 p = rest.row(d.node).transpose();
  const HandlePlace& place = places.handles[d.handle];
  if (!place.turns_freely) return place.motion(p);
  return place.motion(handle_rest[d.handle]) + handle_turns[d.handle] * (p - handle_rest[d.handle]);
}

void FrameSolverData::turn_drawn_handles() {
  if (!holds.softness) return;
  for (size_t h = 0; h < holds.handles.size(); ++h) {
    if (!places.handles[h].turns_freely) continue;
    const Vec3 c = places.handles[h].motion(handle_rest[h]);
    handle_turns[h] =
        best_turn(holds.handles[h].vertices, rest, handle_rest[h], now, c, handle_turns[h]);
  }
}

double FrameSolverData::settle() {
  place_nodes();
  turn_drawn_handles();
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    if (turns_by_itself(k)) turn_part(k);
  give_parts_turns();
  double energy = turn_rings(graph, rest, now, keeps_turn, shape.turns, chunk_sums);
  for (const auto& d : unknowns.drawn)
    energy += *holds.softness * (now.row(d.node).transpose() - target(d)).squaredNorm();
  return energy;
}

void FrameSolverData::give_parts_turns() {
  for (size_t k = 0; k < unknowns.parts.size(); ++k)
    for (const int v : unknowns.parts[k].nodes)
      if (keeps_turn[v]) shape.turns[v] = part_turns[k];
}

void FrameSolverData::solve_positions() {
  ring_loads(graph, rest, shape.turns, loads);
  for (const int e : unknowns.special) {
    const auto& edge = graph.edges[e];
    const Eigen::RowVector3d pull = edge.weight * (offset.row(edge.a) - offset.row(edge.b));
    loads.row(edge.a) -= pull;
    loads.row(edge.b) += pull;
  }
  for (const auto& d : unknowns.drawn)
    loads.row(d.node) +=
        half_softness() * (target(d).transpose() - rest.row(d.node) - offset.row(d.node));
  right.setZero();
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.of_node[v]; a >= 0) right.row(a) += loads.row(v);
  if (unknowns.count > 0) factor.solve_in_place(right);
  if (!guides.empty()) {
    set_guides();
    guides.apply(right, guide_right);
  }
  if (holds.keeps_volume) reach_volume();
  if (!right.allFinite()) throw NoSolutionError("frames: positions are not finite");
  report.last_change =
      size > 0 && unknowns.count > 0 ? (right - y).rowwise().norm().maxCoeff() / size : 0;
}

void FrameSolverData::reach_volume() {
  if (report.rounds == 0) place_at(right);
  volume_gradient(triangles, now, gradient);
  along.setZero(unknowns.count, 3);
  for (int v = 0; v < graph.nodes; ++v)
    if (const int a = unknowns.of_node[v]; a >= 0) along.row(a) += gradient.row(v);
  if (unknowns.count > 0) factor.solve_in_place(along);
  for (int step = 0; step < 5; ++step) {
    place_at(right);
    volume_gradient(triangles, now, gradient);
    double slope = 0;
    for (int v = 0; v < graph.nodes; ++v)
      if (const int a = unknowns.of_node[v]; a >= 0) slope += gradient.row(v).dot(along.row(a));
    const double missing = volume - enclosed_volume(triangles, now);
    if (!(slope > 0) || std::abs(missing) < 1e-15 * std::abs(volume)) return;
    right += missing / slope * along;
  }
}

void FrameSolverData::place_at(MatX& other) {
  y.swap(other);
  place_nodes();
  y.swap(other);
}

double FrameSolverData::go_on(double before) {
  solve_positions();
  const bool mix = !holds.keeps_volume && mixing.mix(y, right, mixed);
  turns_before = shape.turns;
  part_turns_before = part_turns;
  handle_turns_before = handle_turns;
  y.swap(mix ? mixed : right);
  double energy = settle();
  if (mix && !(energy <= before)) {
    shape.turns = turns_before;
    part_turns = part_turns_before;
    handle_turns = handle_turns_before;
    for (size_t k = 0; k < unknowns.parts.size(); ++k) set_offsets(k);
    y.swap(right);
    mixing.reset();
    energy = settle();
  }
  return energy;
}

void FrameSolverData::rounds(int most) {
  while (report.rounds < most && !report.converged) {
    report.energies.push_back(go_on(report.energies.empty()
                                        ? std::numeric_limits<double>::infinity()
                                        : report.energies.back()));
    if (++report.rounds == 1) mixing.reset();  // its turns came from elsewhere
    report.converged = report.last_change < options.tolerance;
  }
}

}  // namespace batten
