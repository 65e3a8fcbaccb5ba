// SPDX-License-Identifier: MPL-2.0
// Non-rigid registration: springs that attract a mesh to a target surface, on which they slide.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A point of a target surface.
struct TargetPoint {
  Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();
  bool at_boundary = false;  ///< on the boundary of the target
};

/// Finds the point of a target that is closest to p, among those whose normal n has n·along > 0; all
/// points, if `along` is zero. Called by several threads at once.
using ClosestTargetPoint =
    std::function<std::optional<TargetPoint>(const Vec3& p, const Vec3& along)>;

/// Options of TargetFollower.
struct TargetFollowerOptions {
  /// Details of the target up to about six times this length are smoothed, model units; 0: twice
  /// the mean edge length of the mesh.
  double smoothing = 0;
  /// Points of the target that are farther away are ignored, model units; 0: a tenth of the size of
  /// the mesh.
  double reach = 0;
  /// Distance of the mesh from the target, on the side of the normals of the target, model units:
  /// half the thickness for a middle surface and the scan of one side of a sheet.
  double offset = 0;
};

/// Distances of vertices from a target.
struct TargetDistance {
  int vertices = 0;  ///< vertices with a point of the target
  int ignored = 0;   ///< vertices without one
  double rms = 0, largest = 0;
};

/// Springs between vertices of a mesh and the closest points of a target surface. In each iteration
/// they are attached to the closest points of the current shape, so that they slide on the target:
///
///     min ½ E(p) + ½ ℓ⁻⁴ Σ_v A_v |p_v - c_v|²
///
/// with mixed areas A_v, the smoothing length ℓ, and the closest points c_v of the previous shape.
/// E is the bending energy of FormFeatureDeformer, for which DeformProblem::Bending::Hinges has no
/// bias at boundaries. Features and constraints stay exact, and the matrix does not change: an
/// iteration costs closest points and a solve. Vertices whose
/// closest point is beyond the reach, at the boundary of the target, or has a normal that deviates by
/// more than 60 degrees have no spring. Reference: [Amberg2007].
class TargetFollower {
 public:
  /// Keeps a reference to `mesh`. `vertices`: those that follow. Finds out whether the normals of mesh
  /// and target have the same orientation. Throws InputError if no vertex has a closest point within
  /// the reach.
  TargetFollower(const TriangleMesh& mesh, std::vector<int> vertices, ClosestTargetPoint closest,
                 const TargetFollowerOptions& options = {});

  /// Finds the vertices that have a point of the target in this shape (n×3, all vertices). Returns
  /// true if they are others than before: the problem must then be set up again.
  bool find_vertices(const Points& shape);
  /// The springs, one for each of these vertices: soft constraints on their positions, with the names
  /// "NAME at vertex V".
  std::vector<LinearConstraint> springs(const std::string& name,
                                        DeformProblem::Weighting weighting) const;
  /// The end of each spring for the current shape. Vertices that have lost their point are attracted
  /// to their current position. O(n log(target)).
  std::vector<Vec3> closest_points(const Points& shape) const;

  /// Distances of the following vertices from the target, minus the offset.
  TargetDistance distance(const Points& shape) const;
  const TargetFollowerOptions& options() const { return options_; }

 private:
  std::vector<std::optional<Vec3>> find(const Points& shape,
                                        const std::vector<int>& vertices) const;
  void orient(const Points& shape);

  const TriangleMesh* mesh_;
  std::vector<int> vertices_;
  ClosestTargetPoint closest_;
  TargetFollowerOptions options_;
  double orientation_ = 1;  // 1 or -1: normals of the mesh and of the target
  std::vector<int> with_spring_;
  VecX areas_;
};

}  // namespace batten
