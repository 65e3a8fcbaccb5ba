// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/subspace_solver.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/sequence/frame_unknowns.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {

struct SubspaceSolver::Data {
  Data(const TriangleMesh& mesh, FrameConstraints given, TriangleMesh around,
       const SubspaceOptions& opts)
      : constraints(std::move(given)),
        control(std::move(around)),
        options(opts),
        graph(node_graph(mesh.topology())) {
    if (options.iterations < 1 ||
        !(options.penalty_weight > 0 && std::isfinite(options.penalty_weight)))
      throw InputError("the subspace solver needs one or more iterations and a penalty above 0");
    if (constraints.fixed.empty() && constraints.handles.empty())
      throw InputError("found no fixed nodes and no handles, expected one of them");
    if (!control.topology().boundary_loops().empty())
      throw InputError("the control mesh has free edges, expected a closed mesh");
    lambda = options.penalty_weight * 2 * static_cast<double>(graph.edges.size()) / graph.nodes;
    d = control.points();
  }

  // Visits the penalised nodes with the index of their handle, or -1 if the node is fixed.
  template <class Visit>
  void for_each_penalized(const Visit& visit) const {
    for (const int v : constraints.fixed) visit(v, -1);
    for (int h = 0; h < isize(constraints.handles); ++h)
      for (const int v : constraints.handles[h].vertices) visit(v, h);
  }

  void set_frame(const Points& frame, const Points& control_points) {
    if (frame.rows() != graph.nodes || control_points.rows() != control.vertex_count())
      throw InputError("the frame or the control mesh has a different size than before");
    rest = frame;
    W = mean_value_coordinates(control.with_points(control_points), frame);
    // Assembling Wᵀ K W as Σ w (W_a - W_b)ᵀ (W_a - W_b) would cost m² per edge; K W first costs m
    // per edge.
    MatX KW = MatX::Zero(W.rows(), W.cols());
    parallel_chunks<256>(graph.nodes, [&](long first, long last) {
      for (long i = first; i < last; ++i)
        for (int k = graph.start[i]; k < graph.start[i + 1]; ++k)
          KW.row(i) += graph.weight[k] * (W.row(i) - W.row(graph.neighbour[k]));
    });
    for_each_penalized([&](int v, int) { KW.row(v) += lambda * W.row(v); });
    MatX A = W.transpose() * KW;
    A.diagonal().array() += 1e-10 * A.trace() / static_cast<double>(A.rows());
    factor.compute(A);
    if (factor.info() != Eigen::Success)
      throw NoSolutionError("the control mesh has vertices that do not influence any node");
    d0 = control_points;
    MatX indicator = MatX::Zero(graph.nodes, isize(constraints.handles));
    for_each_penalized([&](int v, int h) {
      if (h >= 0) indicator(v, h) += lambda;
    });
    handle_weights = W * factor.solve(W.transpose() * indicator);
  }

  const Points& solve(const FrameTargets& targets) {
    if (targets.handles.size() != constraints.handles.size() || W.rows() == 0)
      throw InputError("found poses of " + std::to_string(targets.handles.size()) +
                       " handles, expected " + std::to_string(constraints.handles.size()) +
                       " and a frame");
    start(targets);
    RowPoints loads(graph.nodes, 3);
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
      global_step_rhs(graph, rest, rotations, loads);
      for_each_penalized([&](int v, int h) {
        if (h >= 0) loads.row(v) += lambda * (target(targets, v, h).transpose() - rest.row(v));
      });
      const MatX y = factor.solve(W.transpose() * loads);
      d = d0 + y;
      now = rest + W * y;
      local_step(graph, rest, now, {}, rotations, sums);
      fit_free_handles(constraints.handles, targets.handles, rest, handle_rest, now,
                       handle_rotations);
    }
    result = now;
    return result;
  }

  void start(const FrameTargets& targets) {
    rotations.assign(graph.nodes, Mat3::Identity());
    handle_rotations.clear();
    handle_rest.clear();
    for (size_t h = 0; h < constraints.handles.size(); ++h) {
      handle_rotations.push_back(targets.handles[h].motion.rotation);
      handle_rest.push_back(centre_of(constraints.handles[h].vertices, rest));
    }
    spread_rotations(handle_weights, targets.handles, rotations);
  }

  Vec3 target(const FrameTargets& targets, int v, int h) const {
    const Vec3 p = rest.row(v).transpose();
    const auto& pose = targets.handles[h];
    return pose.motion(handle_rest[h]) + handle_rotations[h] * (p - handle_rest[h]);
  }

  FrameConstraints constraints;
  TriangleMesh control;
  SubspaceOptions options;
  NodeGraph graph;
  double lambda = 0;
  MatX W, handle_weights;  // handle_weights: nodes × handles, interpolation weights of the handle
                           // rotations
  Eigen::LLT<MatX> factor;
  RowPoints rest, now;
  Points d0, d, result;
  std::vector<Mat3> rotations, handle_rotations;
  std::vector<Vec3> handle_rest;
  std::vector<double> sums;
};

SubspaceSolver::SubspaceSolver(const TriangleMesh& mesh, FrameConstraints constraints,
                               TriangleMesh control, const SubspaceOptions& options)
    : data_(std::make_unique<Data>(mesh, std::move(constraints), std::move(control), options)) {}
SubspaceSolver::~SubspaceSolver() = default;
SubspaceSolver::SubspaceSolver(SubspaceSolver&&) noexcept = default;
SubspaceSolver& SubspaceSolver::operator=(SubspaceSolver&&) noexcept = default;

void SubspaceSolver::set_frame(const Points& frame, const Points& control) {
  data_->set_frame(frame, control);
}
const Points& SubspaceSolver::solve(const FrameTargets& targets) { return data_->solve(targets); }
const Points& SubspaceSolver::control() const { return data_->d; }

namespace {

FrameOptions one_round(FrameOptions options) {
  options.max_iterations = 1;
  return options;
}

}  // namespace

struct FrameSession::Data {
  Data(const TriangleMesh& mesh, const FrameConstraints& constraints, const TriangleMesh& control,
       const FrameOptions& frames, const SubspaceOptions& options)
      : solver(mesh, constraints, one_round(frames)),
        subspace(mesh, constraints, control, options),
        transfer(
            mesh, control.points(),
            mean_value_coordinates(control, mesh.points().topRows(mesh.topology().node_count()))) {}

  FrameSolver solver;
  SubspaceSolver subspace;
  ControlMeshTransfer transfer;
  Points frame, shown;
  FrameTargets targets;
  bool answered = false, refined = false;
};

FrameSession::FrameSession(const TriangleMesh& mesh, FrameConstraints constraints,
                           TriangleMesh control, const FrameOptions& frames,
                           const SubspaceOptions& subspace)
    : data_(std::make_unique<Data>(mesh, constraints, control, frames, subspace)) {}
FrameSession::~FrameSession() = default;

void FrameSession::set_frame(const Points& frame) {
  data_->subspace.set_frame(frame, data_->transfer.at(frame));
  data_->frame = frame;
  data_->shown = frame;
  data_->answered = false;
}

const Points& FrameSession::solve_preview(const FrameTargets& targets) {
  if (data_->frame.rows() == 0)
    throw InputError("solve_preview() without a frame: set a frame first");
  data_->shown = data_->subspace.solve(targets);
  data_->targets = targets;
  data_->answered = true;
  data_->refined = false;
  return data_->shown;
}

bool FrameSession::refine(int iterations) {
  Data& d = *data_;
  if (!d.answered) throw InputError("refine() without a preview: call solve_preview() first");
  bool rests = false;
  if (!d.refined) {
    d.solver.alternate(d.frame, d.targets, d.shown);
    d.refined = true;
    rests = d.solver.report().converged || (iterations > 1 && d.solver.iterate(iterations - 1));
  } else {
    rests = d.solver.iterate(iterations);
  }
  d.shown = d.solver.result().positions;
  return rests;
}

const Points& FrameSession::positions() const { return data_->shown; }
const IterationReport& FrameSession::report() const { return data_->solver.report(); }

}  // namespace batten
