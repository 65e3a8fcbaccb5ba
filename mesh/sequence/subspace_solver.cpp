#include "batten/mesh/sequence/subspace_solver.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/mesh/sequence/handle_turns.h"
#include "batten/mesh/sequence/ring_steps.h"

namespace batten {

struct SubspaceSolver::Data {
  Data(const TriangleMesh& mesh, FrameHolds given, TriangleMesh around, const SubspaceOptions& opts)
      : holds(std::move(given)),
        control(std::move(around)),
        options(opts),
        graph(ring_graph(mesh.topology())) {
    if (options.rounds < 1 || !(options.softness > 0 && std::isfinite(options.softness)))
      throw InputError("a subspace solution needs a round or more and a softness above 0");
    if (holds.fixed.empty() && holds.handles.empty())
      throw InputError("nothing is held and there is no handle");
    if (!control.topology().boundary_loops().empty())
      throw InputError("a control mesh has to be closed");
    lambda = options.softness * 2 * static_cast<double>(graph.edges.size()) / graph.nodes;
    d = control.points();
  }

  // Nodes that are drawn somewhere: a handle's number, or -1 where the node stays.
  template <class Visit>
  void each_drawn(const Visit& visit) const {
    for (const int v : holds.fixed) visit(v, -1);
    for (int h = 0; h < count_of(holds.handles); ++h)
      for (const int v : holds.handles[h].vertices) visit(v, h);
  }

  void set_frame(const Points& frame, const Points& control_points) {
    if (frame.rows() != graph.nodes || control_points.rows() != control.vertex_count())
      throw InputError("a frame or a control mesh of another size");
    rest = frame;
    W = mean_value_coordinates(control.with_points(control_points), frame);
    // Wᵀ K W as Σ w (W_a - W_b)ᵀ (W_a - W_b) would be m² an edge; K W first is m an edge.
    MatX KW = MatX::Zero(W.rows(), W.cols());
    in_chunks<256>(graph.nodes, [&](long first, long last) {
      for (long i = first; i < last; ++i)
        for (int k = graph.start[i]; k < graph.start[i + 1]; ++k)
          KW.row(i) += graph.weight[k] * (W.row(i) - W.row(graph.neighbour[k]));
    });
    each_drawn([&](int v, int) { KW.row(v) += lambda * W.row(v); });
    MatX A = W.transpose() * KW;
    A.diagonal().array() += 1e-10 * A.trace() / static_cast<double>(A.rows());
    factor.compute(A);
    if (factor.info() != Eigen::Success)
      throw NoSolutionError("the control mesh has vertices that no node sees");
    d0 = control_points;
    MatX told = MatX::Zero(graph.nodes, count_of(holds.handles));
    each_drawn([&](int v, int h) {
      if (h >= 0) told(v, h) += lambda;
    });
    share = W * factor.solve(W.transpose() * told);
  }

  const Points& solve(const FramePlaces& places) {
    if (places.handles.size() != holds.handles.size() || W.rows() == 0)
      throw InputError(std::to_string(places.handles.size()) + " places of handles, expected " +
                       std::to_string(holds.handles.size()) + " and a frame");
    start(places);
    RowPoints loads(graph.nodes, 3);
    for (int round = 0; round < options.rounds; ++round) {
      ring_loads(graph, rest, turns, loads);
      each_drawn([&](int v, int h) {
        if (h >= 0) loads.row(v) += lambda * (target(places, v, h).transpose() - rest.row(v));
      });
      const MatX y = factor.solve(W.transpose() * loads);
      d = d0 + y;
      now = rest + W * y;
      turn_rings(graph, rest, now, {}, turns, sums);
      turn_handles(places);
    }
    result = now;
    return result;
  }

  void start(const FramePlaces& places) {
    turns.assign(graph.nodes, Mat3::Identity());
    handle_turns.clear();
    handle_rest.clear();
    for (size_t h = 0; h < holds.handles.size(); ++h) {
      handle_turns.push_back(places.handles[h].motion.turn);
      handle_rest.push_back(centre_of(holds.handles[h].vertices, rest));
    }
    spread_turns(share, places.handles, turns);
  }

  Vec3 target(const FramePlaces& places, int v, int h) const {
    const Vec3 p = rest.row(v).transpose();
    const auto& place = places.handles[h];
    return place.motion(handle_rest[h]) + handle_turns[h] * (p - handle_rest[h]);
  }

  void turn_handles(const FramePlaces& places) {
    for (size_t h = 0; h < holds.handles.size(); ++h) {
      if (!places.handles[h].turns_freely) continue;
      const Vec3 c = places.handles[h].motion(handle_rest[h]);
      handle_turns[h] =
          best_turn(holds.handles[h].vertices, rest, handle_rest[h], now, c, handle_turns[h]);
    }
  }

  FrameHolds holds;
  TriangleMesh control;
  SubspaceOptions options;
  RingGraph graph;
  double lambda = 0;
  MatX W, share;  // share: nodes × handles, of the handles' turns
  Eigen::LLT<MatX> factor;
  RowPoints rest, now;
  Points d0, d, result;
  std::vector<Mat3> turns, handle_turns;
  std::vector<Vec3> handle_rest;
  std::vector<double> sums;
};

SubspaceSolver::SubspaceSolver(const TriangleMesh& mesh, FrameHolds holds, TriangleMesh control,
                               const SubspaceOptions& options)
    : data_(std::make_unique<Data>(mesh, std::move(holds), std::move(control), options)) {}
SubspaceSolver::~SubspaceSolver() = default;
SubspaceSolver::SubspaceSolver(SubspaceSolver&&) noexcept = default;
SubspaceSolver& SubspaceSolver::operator=(SubspaceSolver&&) noexcept = default;

void SubspaceSolver::set_frame(const Points& frame, const Points& control) {
  data_->set_frame(frame, control);
}
const Points& SubspaceSolver::solve(const FramePlaces& places) { return data_->solve(places); }
const Points& SubspaceSolver::control() const { return data_->d; }

}  // namespace batten
