#include "batten/mesh/sequence/frame_session.h"

#include "batten/core/errors.h"

namespace batten {
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
  if (data_->frame.rows() == 0) throw InputError("an answer needs a frame");
  data_->shown = data_->subspace.solve(targets);
  data_->targets = targets;
  data_->answered = true;
  data_->refined = false;
  return data_->shown;
}

bool FrameSession::refine(int iterations) {
  Data& d = *data_;
  if (!d.answered) throw InputError("nothing to refine: ask for an answer first");
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
