// One deforming mesh turns gradually into another.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

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


// A mesh takes the shape of another one, whose triangles are others.

struct LandmarkPair {
  int node = 0;            ///< of the mesh that is fitted
  Vec3 at = Vec3::Zero();  ///< its place on the target
};

struct TargetFitOptions {
  int stages = 8;      ///< each lets the mesh come nearer to the target, and forgets what it was
  int iterations = 6;  ///< in each stage
  double initial_weight =
      0.01;  ///< weight of the target in the first stage, of the mean weight at a node
  double final_weight = 10;  ///< and in the last
};

struct TargetFit {
  Points positions;
  double mean_distance = 0, largest_distance = 0;  ///< of nodes from the target, model units
  double landmark_distance = 0;                    ///< largest distance of a landmark
  int inverted = 0;  ///< triangles whose normal is against that of the target beside them
};

/// The nodes of `mesh` onto the surface of `target`: first the similarity that fits the landmarks
/// best, then
///
///     min ½ Σ_i Σ_j |(v_j - v_i) - R_i (p_j - p_i)|² + μ Σ_i |v_i - c_i|² + Λ Σ_landmarks |v - u|²
///
/// c_i: the nearest point of the target whose normal is within 90° of the node's. μ grows stage by
/// stage; each stage starts with the shape before as p. Rounds find R_i, then c_i, then v. Landmarks
/// are held at the end by their weight; give at least four, not in one plane.
///
/// Throws InputError: fewer than three landmarks, a node that is not there, no triangles.
/// O(stages · (factor + rounds · nodes · log triangles)). Source: Xu et al. 2007, section on
/// morphing; Amberg, Romdhani, Vetter 2007 (stages).
TargetFit fit_to_target(const TriangleMesh& mesh, const TriangleMesh& target,
                        const std::vector<LandmarkPair>& landmarks,
                        const TargetFitOptions& options = {}, const Progress& progress = {});

/// The fitted mesh follows the target through its frames: each node keeps its place in the triangle
/// of the target that it is nearest to at the frame of the fit (barycentric, and along the normal).
/// `frame`: where `fitted` was fitted.
MeshSequence transfer_target_motion(const ShellMesh& shells, const Points& fitted,
                                    const MeshSequence& target, const TriangleMesh& target_mesh,
                                    int frame);

}  // namespace batten
