// One frame edited live: an answer at once, better ones on demand.
#pragma once

#include <memory>

#include "batten/mesh/sequence/frame_solver.h"
#include "batten/mesh/sequence/subspace_solver.h"

namespace batten {

/// A keyframe under the mouse. solve_preview() moves few vertices of a control mesh and so the whole shape
/// smoothly; refine() goes on from there with the alternation over all nodes, which repairs what the
/// control mesh folded, and holds handles and features exactly.
///
///     FrameSession session(mesh, holds, control_mesh(mesh));
///     session.set_frame(frame);
///     show(session.solve_preview(places));            // at every event of the mouse
///     while (!session.refine(5)) show(session.positions());   // when it rests
///
/// Cost: set_frame() as SubspaceSolver's; solve_preview() 10 to 50 ms on 10,000 nodes; a round of refine() 2
/// to 3 ms.
class FrameSession {
 public:
  /// `control`: around `mesh`, in its own shape. Throws as FrameSolver and SubspaceSolver.
  FrameSession(const TriangleMesh& mesh, FrameConstraints constraints, TriangleMesh control,
               const FrameOptions& frames = {}, const SubspaceOptions& subspace = {});
  ~FrameSession();

  /// The control mesh goes along as ControlMeshTransfer says. Throws InputError on another number of
  /// nodes.
  void set_frame(const Points& frame);
  /// Needs a frame. Throws InputError, ConflictError.
  const Points& solve_preview(const FrameTargets& targets);
  /// Needs an answer. Returns whether the shape is at rest.
  bool refine(int iterations);
  const Points& positions() const;
  const IterationReport& report() const;  ///< of the refinement

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
