// SPDX-License-Identifier: MPL-2.0
// Morphing between deforming meshes, and non-rigid registration of a mesh to a target.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// Rotation-aware blend between two shapes p and q of one mesh. Let R_i be the rotation of the
/// one-ring of node i from p to q. The rotations are interpolated by their logarithms, the
/// remaining stretch of the edges linearly. For α between 0 and 1 the edges
///
///     e_ij = R_i^α [ (1 - α) (p_j - p_i) + α R_iᵀ (q_j - q_i) ]
///
/// are reproduced in the least-squares sense. α = 0 gives p and α = 1 gives q, to rounding. The
/// logarithms of neighbouring nodes are chosen nearest to each other, so that parts with large
/// rotations rotate together and keep their size. The centroid of each connected component moves on
/// a straight line.
///
/// One factorization serves all shapes and all α. A blend costs two rotation fits and one solve,
/// about 3 ms for 10,000 nodes. References: [Xu2007], section on morphing; [Alexa2000].
class ShapeBlend {
 public:
  explicit ShapeBlend(const TriangleMesh& mesh);
  ~ShapeBlend();
  ShapeBlend(ShapeBlend&&) noexcept;
  ShapeBlend& operator=(ShapeBlend&&) noexcept;

  /// Blends the shapes p (for `alpha` = 0) and q (for `alpha` = 1), nodes × 3 each. Throws
  /// InputError if the numbers of nodes differ, and NoSolutionError if a factorization fails.
  const Points& blend(const Points& p, const Points& q, double alpha);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// An interval of frames of a sequence that is blended in a morph.
struct MorphInterval {
  int first = 0, last = 0;  ///< 0-based first and last frame, both included; last > first
};

/// Throws InputError if an interval contains fewer than two frames or is not within the sequence.
/// `which`: name of the sequence in the message.
void check(const MorphInterval& interval, const MeshSequence& sequence, const char* which);

/// Options of morph().
struct MorphOptions {
  /// The intervals of the source and of the target sequence that are blended.
  MorphInterval source, target;
  /// Number of frames of the morph, including both ends; 0: mean number of frames of the source and
  /// target intervals.
  int frames = 0;
  /// Rigid motion that aligns the target with the source. Empty: the best fit between the first
  /// frames of the two intervals by a rotation about `up` and a horizontal translation; see
  /// ground_alignment().
  std::optional<RigidMotion> alignment;
  Vec3 up = Vec3::UnitZ();
};

/// Morphs one sequence into another. The result consists of the source before its interval, the
/// morph, and the aligned target after its interval. In the morph, a parameter t increases evenly
/// from 0 to 1. The source and target intervals are sampled at their fraction t (linearly in time)
/// and blended with α = 3t² - 2t³, so the change starts and ends smoothly. The first frame of the
/// morph is that of the source interval, the last one the last frame of the aligned target
/// interval.
///
/// `mesh`: any frame of the source, converted by prepare(). Throws InputError if the sequences have
/// different connectivity or check() rejects an interval.
MeshSequence morph(const MeshSequence& source, const MeshSequence& target, const TriangleMesh& mesh,
                   const MorphOptions& options, const Progress& progress = {});

/// Best-fitting rigid motion from the points q to the points p (n×3 each), restricted to rotations
/// about `up` and horizontal translations.
RigidMotion ground_alignment(const Points& q, const Points& p, const Vec3& up);

// Non-rigid registration: fits a mesh to the shape of another mesh with different triangles.

/// A pair of corresponding points for fit_to_target().
struct LandmarkPair {
  int node = 0;            ///< node index of the mesh that is fitted
  Vec3 at = Vec3::Zero();  ///< corresponding position on the target
};

/// Options of fit_to_target().
struct TargetFitOptions {
  /// Number of stages. Each stage takes the result of the previous stage as reference shape, and
  /// increases the weight of the target.
  int stages = 8;
  int iterations = 6;  ///< iterations per stage
  /// Weight of the distances from the target (μ in fit_to_target()) in the first stage, relative to
  /// the mean number of edges at a node.
  double initial_weight = 0.01;
  double final_weight = 10;  ///< weight in the last stage, relative to the mean edges per node
};

/// Result of fit_to_target().
struct TargetFit {
  Points positions;  ///< fitted node positions, nodes × 3
  /// Mean and largest distance of the nodes from the target, model units.
  double mean_distance = 0, largest_distance = 0;
  double landmark_distance = 0;  ///< largest distance of a landmark from its target, model units
  /// Number of fitted triangles whose normal points opposite to the target's normal near them.
  int inverted = 0;
};

/// Registers `mesh` to the surface of `target` (non-rigid registration). The best-fitting
/// similarity of the landmarks gives the initial shape. The iterations then solve
///
///     min ½ Σ_i Σ_j |(v_j - v_i) - R_i (p_j - p_i)|² + μ Σ_i |v_i - c_i|² + Λ Σ_landmarks |v - u|²
///
/// for the node positions v_i, with neighbours j of node i. p_i are the positions and R_i the
/// rotations of the reference shape, and u is the target point of a landmark. c_i is the nearest
/// point of the target whose normal is within 90° of the normal at the node. The weight μ increases
/// from stage to stage, and each stage takes the result of the previous one as reference shape p.
/// Each iteration computes R_i, then c_i, then v. Λ is a large weight, which imposes the landmarks.
/// Provide at least four landmarks that are not coplanar.
///
/// Throws InputError if there are fewer than three landmarks, a node is out of range, or a mesh has
/// no triangles. O(stages · (factorization + iterations · nodes · log triangles)). References:
/// [Xu2007], section on morphing; [Amberg2007] (stages).
TargetFit fit_to_target(const TriangleMesh& mesh, const TriangleMesh& target,
                        const std::vector<LandmarkPair>& landmarks,
                        const TargetFitOptions& options = {}, const Progress& progress = {});

/// Transfers the motion of a target sequence to a mesh that was fitted to one of its frames. Each
/// node keeps its position relative to the nearest triangle of the target in that frame, given by
/// barycentric coordinates and an offset in the axes of the triangle. `shells`: the faces of the
/// mesh. `fitted`: node positions of the mesh, fitted to frame `frame` (0-based) of `target`.
MeshSequence transfer_target_motion(const ShellMesh& shells, const Points& fitted,
                                    const MeshSequence& target, const TriangleMesh& target_mesh,
                                    int frame);

/// A pair of corresponding points of two sequences, for registered_target().
struct MorphLandmark {
  Vec3 from = Vec3::Zero();  ///< point on the source; its nearest node is the landmark
  Vec3 to = Vec3::Zero();    ///< corresponding point on the target
};

/// Result of registered_target().
struct RegisteredTarget {
  MeshSequence sequence;   ///< target sequence with the faces of the source
  TargetFit fit;           ///< node positions and quality of the registration
  double target_size = 0;  ///< TriangleMesh::size() of the registered target frame, model units
};

/// Converts a target sequence with different faces to the faces of the source, as required by
/// morph(). The mesh in frame `source_frame` of the source is registered to the target in frame
/// `target_frame` by fit_to_target(), and then follows the target by transfer_target_motion(). If
/// both meshes are closed and have opposite orientations, the target is inverted first.
///
/// `mesh`: any frame of the source, converted by prepare(). Frames are 0-based. Throws InputError
/// like prepare() and fit_to_target(), and if a frame is out of range.
RegisteredTarget registered_target(const MeshSequence& source, const TriangleMesh& mesh,
                                   int source_frame, const MeshSequence& target, int target_frame,
                                   const std::vector<MorphLandmark>& landmarks,
                                   const TargetFitOptions& options = {},
                                   const Progress& progress = {});

}  // namespace batten
