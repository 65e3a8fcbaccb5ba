// Morphing between deforming meshes, and non-rigid registration of a mesh to a target.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// Rotation-aware blend between two shapes p and q of one mesh. R_i is the rotation of each
/// one-ring from p to q; the remaining stretch of its edges is interpolated linearly. For α between
/// 0 and 1 the edges
///
///     e_ij = R_i^α [ (1 - α) (p_j - p_i) + α R_iᵀ (q_j - q_i) ]
///
/// are reproduced in the least-squares sense. α = 0 gives p and α = 1 gives q, to rounding. R_i^α
/// is computed by the logarithm; logarithms of neighbours are chosen nearest to each other, so that
/// parts with large rotations rotate together and keep their size. The centroid of each component
/// moves on a straight line.
///
/// One factorization serves all shapes and α. A blend costs about two local steps and one solve:
/// about 3 ms for 10,000 nodes. Sources: [Xu2007], section on morphing; [Alexa2000].
class ShapeBlend {
 public:
  explicit ShapeBlend(const TriangleMesh& mesh);
  ~ShapeBlend();
  ShapeBlend(ShapeBlend&&) noexcept;
  ShapeBlend& operator=(ShapeBlend&&) noexcept;

  /// Blends p (α = 0) and q (α = 1), nodes × 3 each. Throws InputError if the numbers of nodes
  /// differ, or NoSolutionError.
  const Points& blend(const Points& p, const Points& q, double alpha);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// An interval of frames.
struct MorphInterval {
  int first = 0, last = 0;  ///< 0-based frames of a sequence; last > first
};

/// Throws InputError, naming the sequence by `which`, if the interval is not within the sequence.
void check(const MorphInterval& interval, const MeshSequence& sequence, const char* which);

/// Options of morph().
struct MorphOptions {
  /// Intervals of the source and the target sequence that are blended.
  MorphInterval source, target;
  /// Number of frames of the morph, both ends included; 0: the mean of both intervals.
  int frames = 0;
  /// Rigid motion from the target to the source. None: the best fit between the first frames of
  /// both intervals, restricted to rotations about `up` and horizontal translations.
  std::optional<RigidMotion> alignment;
  Vec3 up = Vec3::UnitZ();
};

/// Morphs one sequence into another. The result is the source up to its interval, the morph, and
/// the target after its interval. In the morph, t runs evenly from 0 to 1. Both sequences are
/// sampled at t of their intervals (linearly in time between frames) and blended with α = 3t² -
/// 2t³, so the change starts and ends smoothly. The first frame of the morph is that of the source,
/// the last one that of the aligned target.
///
/// `mesh`: the common connectivity. Throws InputError: sequences with different connectivity,
/// intervals outside the sequences.
MeshSequence morph(const MeshSequence& source, const MeshSequence& target, const TriangleMesh& mesh,
                   const MorphOptions& options, const Progress& progress = {});

/// Best rotation about `up` and horizontal translation that take q to p; heights are not changed.
RigidMotion ground_alignment(const Points& q, const Points& p, const Vec3& up);

// Non-rigid registration: a mesh takes the shape of another one with different triangles.

/// A pair of corresponding points for fit_to_target().
struct LandmarkPair {
  int node = 0;            ///< node of the mesh that is fitted
  Vec3 at = Vec3::Zero();  ///< corresponding position on the target
};

/// Options of fit_to_target().
struct TargetFitOptions {
  /// Number of stages; each relaxes the shape and increases the weight of the target.
  int stages = 8;
  int iterations = 6;            ///< iterations per stage
  double initial_weight = 0.01;  ///< μ in the first stage, relative to the mean weight at a node
  double final_weight = 10;      ///< μ in the last stage
};

/// Result of fit_to_target().
struct TargetFit {
  Points positions;
  /// Distance of nodes from the target, model units.
  double mean_distance = 0, largest_distance = 0;
  double landmark_distance = 0;  ///< largest distance of a landmark, model units
  int inverted = 0;  ///< number of triangles whose normal points against that of the nearby target
};

/// Registers `mesh` to the surface of `target`. The best similarity of the landmarks is followed by
/// iterations for
///
///     min ½ Σ_i Σ_j |(v_j - v_i) - R_i (p_j - p_i)|² + μ Σ_i |v_i - c_i|² + Λ Σ_landmarks |v - u|²
///
/// c_i is the nearest point of the target whose normal is within 90° of that of the node. μ
/// increases from stage to stage, and each stage takes the previous shape as p. Each iteration
/// computes R_i, then c_i, then v. Landmarks are imposed by the large weight Λ. Give at least four
/// that are not coplanar.
///
/// Throws InputError: fewer than three landmarks, a node out of range, no triangles. O(stages ·
/// (factorization + iterations · nodes · log triangles)). Sources: [Xu2007], section on morphing;
/// [Amberg2007] (stages).
TargetFit fit_to_target(const TriangleMesh& mesh, const TriangleMesh& target,
                        const std::vector<LandmarkPair>& landmarks,
                        const TargetFitOptions& options = {}, const Progress& progress = {});

/// Lets the fitted mesh follow the frames of the target. Each node keeps its position relative to
/// the triangle of the target that is nearest to it in frame `frame`: barycentric coordinates, and
/// an offset in the axes of the triangle. `fitted`: node positions as registered to that frame.
MeshSequence transfer_target_motion(const ShellMesh& shells, const Points& fitted,
                                    const MeshSequence& target, const TriangleMesh& target_mesh,
                                    int frame);

/// A pair of corresponding points of two sequences, for registered_target().
struct MorphLandmark {
  Vec3 from = Vec3::Zero();  ///< on the source; the nearest node is the landmark
  Vec3 to = Vec3::Zero();    ///< on the target
};

/// Result of registered_target().
struct RegisteredTarget {
  MeshSequence sequence;   ///< the frames of the target, with the faces of the source
  TargetFit fit;           ///< quality of the registration
  double target_size = 0;  ///< size of the target in the registered frame, model units
};

/// Gives a target with other faces the faces of the source, so that morph() accepts it: registers
/// the mesh in frame `source_frame` to the target in frame `target_frame` (fit_to_target()), and lets
/// it follow the target (transfer_target_motion()). Of closed meshes with opposite orientation the
/// target is inverted first.
///
/// `mesh`: any frame of the source, converted by prepare(). Frames are 0-based. Throws InputError
/// like prepare() and fit_to_target(), and for frames out of range.
RegisteredTarget registered_target(const MeshSequence& source, const TriangleMesh& mesh,
                                   int source_frame, const MeshSequence& target, int target_frame,
                                   const std::vector<MorphLandmark>& landmarks,
                                   const TargetFitOptions& options = {},
                                   const Progress& progress = {});

}  // namespace batten
