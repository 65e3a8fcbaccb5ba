// A mesh takes the shape of another one, whose triangles are others.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

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
