#include "batten/mesh/sequence/frame_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/constraints/coupling.h"
#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/core/rotations.h"
#include "batten/mesh/operators.h"
#include "batten/mesh/regions/mixing.h"
#include "batten/mesh/rotation_of_faces.h"
#include "batten/mesh/sequence/enclosed_volume.h"
#include "batten/mesh/sequence/frame_unknowns.h"
#include "batten/mesh/sequence/ring_steps.h"

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

struct FrameSolver::Data {
  Data(const TriangleMesh& mesh, FrameHolds given, const FrameOptions& opts)
      : holds(std::move(given)),
        options(opts),
        size(mesh.size()),
        graph(ring_graph(mesh.topology(), edge_weights(mesh, opts.weights))),
        unknowns((check_holds(holds, graph.nodes), frame_unknowns(graph, holds))),
        mixing(unknowns.count) {
    if (holds.keeps_volume) set_triangles(mesh);
    factorize();
    spread_turns();
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

  void set_triangles(const TriangleMesh& mesh) {
    const MeshTopology& topology = mesh.topology();
    if (!topology.boundary_loops().empty() || !topology.joint_loops().empty())
      throw InputError("the volume cannot be kept: the surface is not closed");
    for (auto t : topology.triangles()) {
      for (int& v : t) v = topology.node_of(v);
      triangles.push_back(t);
    }
  }

  // In the linear step: there each edge counts once, in E twice.
  double half_softness() const { return 0.5 * holds.softness.value_or(0); }

  void factorize() {
    if (unknowns.count == 0) return;
    const SparseMatrix K = frame_matrix(graph, unknowns, half_softness());
    factor.analyze(K, Expected::one_factor);
    if (!factor.factorize(K)) throw NoSolutionError("frames: " + factor.message());
  }

  // 1 on a handle, 0 on what else is held, harmonic between: how much of its turn a node takes.
  void spread_turns() {
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

  void couple_guides() {
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

  void begin(const Points& frame, const FramePlaces& given) {
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
      if (!place.motion.turn.allFinite() || !place.motion.shift.allFinite())
        throw InputError("a place of a handle is not finite");
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

  static Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p) {
    Vec3 sum = Vec3::Zero();
    for (const int v : nodes) sum += p.row(v).transpose();
    return nodes.empty() ? sum : sum / static_cast<double>(nodes.size());
  }

  bool turns_by_itself(size_t part) const {
    const auto& p = unknowns.parts[part];
    return p.handle >= 0 ? places.handles[p.handle].turns_freely : p.may_turn;
  }

  // How far the nodes of a part stand from where its unknown alone, or the frame, has them.
  void set_offsets(size_t k) {
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

  void set_guides() {
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

  void place_nodes() {
    for (int v = 0; v < graph.nodes; ++v) {
      const int a = unknowns.of_node[v];
      now.row(v) = rest.row(v) + offset.row(v);
      if (a >= 0) now.row(v) += y.row(a);
    }
    for (size_t k = 0; k < unknowns.parts.size(); ++k)
      if (const int a = unknowns.parts[k].unknown; a >= 0)
        part_place[k] = part_rest[k] + y.row(a).transpose();
  }

  // The exact minimum over the rotation of a part whose centre and surroundings stand still.
  void turn_part(size_t k) {
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

  Vec3 target(const FrameUnknowns::Drawn& d) const {
    const Vec3 p = rest.row(d.node).transpose();
    const HandlePlace& place = places.handles[d.handle];
    if (!place.turns_freely) return place.motion(p);
    return place.motion(handle_rest[d.handle]) +
           handle_turns[d.handle] * (p - handle_rest[d.handle]);
  }

  void turn_drawn_handles() {
    if (!holds.softness) return;
    for (size_t h = 0; h < holds.handles.size(); ++h) {
      if (!places.handles[h].turns_freely) continue;
      const Vec3 c = places.handles[h].motion(handle_rest[h]);
      Mat3 M = Mat3::Zero();
      for (const int v : holds.handles[h].vertices)
        M += (now.row(v).transpose() - c) * (rest.row(v).transpose() - handle_rest[h]).transpose();
      handle_turns[h] = rotation_part(M * handle_turns[h].transpose()) * handle_turns[h];
    }
  }

  /// Positions from y, then the best turns; returns the energy.
  double settle() {
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

  void give_parts_turns() {
    for (size_t k = 0; k < unknowns.parts.size(); ++k)
      for (const int v : unknowns.parts[k].nodes)
        if (keeps_turn[v]) shape.turns[v] = part_turns[k];
  }

  /// The best positions for the turns, into `right`.
  void solve_positions() {
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

  // Along z = K⁻¹ ∂V, with ∂V of the shape before, so that at rest E has its least value among the
  // shapes of this volume; in the first round of where the linear step went.
  void reach_volume() {
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

  void place_at(MatX& other) {
    y.swap(other);
    place_nodes();
    y.swap(other);
  }

  /// One round; returns the energy, which is not above the one before.
  double go_on(double before) {
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

  void rounds(int most) {
    while (report.rounds < most && !report.converged) {
      report.energies.push_back(go_on(report.energies.empty()
                                          ? std::numeric_limits<double>::infinity()
                                          : report.energies.back()));
      if (++report.rounds == 1) mixing.reset();  // its turns came from elsewhere
      report.converged = report.last_change < options.tolerance;
    }
  }

  void finish() { shape.positions = now; }

  void start_from_handles() {
    std::vector<Vec3> logs;
    for (const auto& place : places.handles) logs.push_back(rotation_log(place.motion.turn));
    for_each_in_chunks<512>(graph.nodes, [&](int v) {
      Vec3 log = Vec3::Zero();
      for (size_t h = 0; h < logs.size(); ++h) log += share(v, static_cast<long>(h)) * logs[h];
      shape.turns[v] = rotation_matrix(log);
    });
    take_part_turns();
    y.setZero();
  }

  // Of parts that turn by themselves the mean of their nodes' turns; then where the parts stand.
  void take_part_turns() {
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

  void start_from(const Points& start) {
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

  FrameHolds holds;
  FrameOptions options;
  double size;
  RingGraph graph;
  FrameUnknowns unknowns;
  SparseCholesky factor;
  MatX share;  // nodes × handles
  Coupling guides;
  std::vector<Coupling::Row> guide_rows;
  VecX guide_right;
  std::vector<std::array<int, 3>> triangles;  // for the volume
  double volume = 0;

  FramePlaces places;
  RowPoints rest, now, offset, loads, gradient;
  MatX y, right, mixed, along;
  Mixing mixing;
  std::vector<Mat3> part_turns, handle_turns;
  std::vector<Mat3> turns_before, part_turns_before, handle_turns_before;
  std::vector<Vec3> part_rest, part_place, handle_rest;
  std::vector<char> keeps_turn;  // nodes whose R_i is that of their part
  std::vector<double> chunk_sums;
  bool begun = false;
  FrameShape shape;
  EstimateReport report;
};

FrameSolver::FrameSolver(const TriangleMesh& mesh, FrameHolds holds, const FrameOptions& options)
    : data_(std::make_unique<Data>(mesh, std::move(holds), options)) {}
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
