// One deforming mesh turns gradually into another.
#pragma once

#include <functional>
#include <optional>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/rigid_motion.h"

namespace batten {

/// Between two shapes p and q of one mesh: of each ring the rotation R_i from p to q, and what is
/// left of its edges when that is taken off; at α in [0, 1] the edges
///
///     e_ij = R_i^α [ (1 - α) (p_j - p_i) + α R_iᵀ (q_j - q_i) ]
///
/// met in the least-squares sense. At α = 0 that is p and at 1 q, to rounding. R_i^α goes by its
/// logarithm, that of neighbours the nearest to each other, so that parts that turn far turn together
/// and keep their size. The centroid of each sheet goes straight.
///
/// One factor for all shapes and α. A blend costs two solves' worth of ring work and one solve:
/// about 3 ms on 10,000 nodes. Source: Xu et al. 2007, section on morphing; Alexa et al. 2000.
class ShapeBlend {
 public:
  explicit ShapeBlend(const TriangleMesh& mesh);
  ~ShapeBlend();
  ShapeBlend(ShapeBlend&&) noexcept;
  ShapeBlend& operator=(ShapeBlend&&) noexcept;

  /// Throws InputError on other numbers of nodes, NoSolutionError.
  const Points& blend(const Points& p, const Points& q, double alpha);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

struct MorphInterval {
  int first = 0, last = 0;  ///< frames of a sequence, from 0; last after first
};

/// Throws InputError, with `which` in it, on an interval that is not in the sequence.
void check(const MorphInterval& interval, const MeshSequence& sequence, const char* which);

struct MorphOptions {
  MorphInterval source, target;
  int frames = 0;  ///< of the morph, its ends included; 0: the mean of both intervals
  /// What takes the target to the source; none: the rigid motion that fits the two frames where the
  /// intervals start best (about `up` only, and along the ground).
  std::optional<RigidMotion> alignment;
  Vec3 up = Vec3::UnitZ();
};

/// The source until its interval starts, the morph, the target from where its interval ends on.
/// In the morph t goes evenly from 0 to 1; both sequences are sampled at t of their intervals
/// (between frames: linearly in time), and blended by α = 3t² - 2t³, so that the change begins and
/// ends gently. The first frame of the morph is the source's, the last the aligned target's.
///
/// Throws InputError: sequences of other connectivity, intervals that are not in them.
MeshSequence morph(const MeshSequence& source, const MeshSequence& target, const TriangleMesh& mesh,
                   const MorphOptions& options, const Progress& progress = {});

/// The rotation about `up` and the shift that take q to p best, heights as they are.
RigidMotion ground_alignment(const Points& q, const Points& p, const Vec3& up);

}  // namespace batten
