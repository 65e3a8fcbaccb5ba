// One frame of a sequence, deformed as rigidly as possible ring by ring.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/sequence/frame_constraints.h"

namespace batten {

struct FrameSolverData;

/// With p the positions of a frame and v those after an edit,
///
///     E = Σ_i Σ_{j∈N(i)} w_ij |(v_j - v_i) - R_i (p_j - p_i)|²  (+ λ Σ_{handles} |v_h - u_h|²)
///
/// is minimised by turns over the rotations, R_i = nearest_rotation(Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ),
/// and over the positions, a linear system whose matrix depends on w_ij and on what is held only. So
/// it is factored once, here, for all rounds and frames. Nothing raises E; a round may be mixed with
/// those before it where that leads lower (Anderson). Rings count edges between nodes: sheets
/// that meet are one there, and joints of any kind do no harm.
///
/// A feature is one rigid part: its rotation is the exact minimum over all edges that leave it, its
/// centre three unknowns. Handles that turn freely find their rotation in the same way. Features that
/// share nodes are one part; those that share nodes with a handle go with it, those with a fixed
/// node stay. What hangs on nothing that is held stays.
///
/// `preserve_volume`: after each linear step one multiplier along the gradient of the volume, by
/// Newton's method; E may rise while the volume is not yet reached.
///
/// Cost: a factor of the nodes at construction; 2 to 3 ms for a round on 10,000 nodes. Memory: the
/// factor, some 50 numbers a node. One thread at a time per solver; it uses several itself.
/// Source: Xu et al. 2007, eq. 1 to 3; Sorkine and Alexa 2007.
class FrameSolver {
 public:
  /// `mesh`: topology, and positions where weights come from them. Throws InputError (check() in
  /// deform_problem.h; a softness not above 0, a volume of a surface that is not closed),
  /// NoSolutionError.
  FrameSolver(const TriangleMesh& mesh, FrameConstraints constraints,
              const FrameOptions& options = {});
  ~FrameSolver();
  FrameSolver(FrameSolver&&) noexcept;
  FrameSolver& operator=(FrameSolver&&) noexcept;

  /// Alternates from the rest shape turned along with the handles (their turns' logarithms spread
  /// harmonically) until it is at rest; result() then. Throws InputError: numbers missing or not
  /// finite, another number of points; ConflictError: a node that two handles hold in two places.
  void alternate(const Points& frame, const FrameTargets& targets);
  /// The same from positions: of a neighbour, of a coarser solution, or those of the drag so far.
  void alternate(const Points& frame, const FrameTargets& targets, const Points& start);
  /// Goes on from where it stands, for so many rounds at most: a drag shows a shape in between. Needs
  /// a shape. Returns whether it is at rest.
  bool iterate(int iterations);
  /// The linear step alone: rotations as given, one a node; then `iterations` rounds. Parts that turn
  /// freely start with the mean of their nodes' rotations.
  void reconstruct(const Points& frame, const FrameTargets& targets,
                   const std::vector<Mat3>& rotations, int iterations = 0);

  const FrameShape& result() const;
  const IterationReport& report() const;
  int unknowns() const;  ///< of one coordinate
  long factor_entries() const;
  /// Sentences about parts of the mesh that nothing holds.
  const std::vector<std::string>& notes() const;

 private:
  std::unique_ptr<FrameSolverData> data_;
};

}  // namespace batten
