#include "batten/mesh/sequence/frame_session.h"

#include "batten/core/errors.h"

namespace batten {
namespace {

FrameOptions one_round(FrameOptions options) {
  options.most_rounds = 1;
  return options;
}

}  // namespace

struct FrameSession::Data {
  Data(const TriangleMesh& mesh, const FrameHolds& holds, const TriangleMesh& control,
       const FrameOptions& frames, const SubspaceOptions& options)
      : solver(mesh, holds, one_round(frames)),
        subspace(mesh, holds, control, options),
        follower(
            mesh, control.points(),
            mean_value_coordinates(control, mesh.points().topRows(mesh.topology().node_count()))) {}

  FrameSolver solver;
  SubspaceSolver subspace;
  ControlFollower follower;
  Points frame, shown;
  FramePlaces places;
  bool answered = false, refined = false;
};

FrameSession::FrameSession(const TriangleMesh& mesh, FrameHolds holds, TriangleMesh control,
                           const FrameOptions& frames, const SubspaceOptions& subspace)
    : data_(std::make_unique<Data>(mesh, holds, control, frames, subspace)) {}
FrameSession::~FrameSession() = default;

void FrameSession::set_frame(const Points& frame) {
  data_->subspace.set_frame(frame, data_->follower.at(frame));
  data_->frame = frame;
  data_->shown = frame;
  data_->answered = false;
}

const Points& FrameSession::answer(const FramePlaces& places) {
  if (data_->frame.rows() == 0) throw InputError("an answer needs a frame");
  data_->shown = data_->subspace.solve(places);
  data_->places = places;
  data_->answered = true;
  data_->refined = false;
  return data_->shown;
}

bool FrameSession::refine(int rounds) {
  Data& d = *data_;
  if (!d.answered) throw InputError("nothing to refine: ask for an answer first");
  bool rests = false;
  if (!d.refined) {
    d.solver.alternate(d.frame, d.places, d.shown);
    d.refined = true;
    rests = d.solver.report().converged || (rounds > 1 && d.solver.go_on(rounds - 1));
  } else {
    rests = d.solver.go_on(rounds);
  }
  d.shown = d.solver.result().positions;
  return rests;
}

const Points& FrameSession::positions() const { return data_->shown; }
const EstimateReport& FrameSession::report() const { return data_->solver.report(); }

}  // namespace batten
