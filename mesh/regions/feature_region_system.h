// Inside of FeatureRegionDeformer: rows, unknowns and their factor. Internal.
#pragma once

#include <span>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/regions/feature_region.h"

namespace batten {

/// The rows (5), with the rows (6) of soft regions under them; fixed vertices, handles and hard
/// regions eliminated.
class FeatureRegionSystem {
 public:
  /// `faces`, `corners`: of each region.
  FeatureRegionSystem(const TriangleMesh& mesh, const DeformProblem& problem,
                      const std::vector<std::string>& names,
                      const std::vector<std::vector<int>>& faces,
                      const std::vector<std::vector<int>>& corners,
                      const FeatureRegionOptions& options);

  /// Handle that holds a vertex of the mesh, or a DeformSystem::Holder.
  int constrained_by(int vertex) const { return system_.constrained_by[vertex]; }
  int unknowns() const { return positions_.free_count(); }

  /// Solves for `result` (all vertices). `face_rotation(region, k)`: scale times rotation of face k of a soft
  /// region; `scaled_rotations`: the same of whole regions.
  template <class FaceRotation>
  void solve(const Points& estimate, const DeformEdit& edit, const std::vector<double>& scales,
             const std::vector<Mat3>& scaled_rotations, const FaceRotation& face_rotation,
             Points& result) {
    set_hard_values(edit, scaled_rotations);
    set_curvature_targets(estimate, scales);
    const long first = system_.A.rows();
    for (size_t k = 0; k < edges_.size(); ++k)
      target_.row(first + static_cast<long>(k)) =
          (face_rotation(edges_[k].region, edges_[k].face) * edges_[k].base).transpose();
    solve_positions(edit, result);
  }

 private:
  struct EdgeEquation {
    int region, face;  // face: its place in the region
    int from, to;      // dofs
    double weight;
    Vec3 base;
  };
  void add_edges(const TriangleMesh& mesh, const std::vector<std::vector<int>>& faces,
                 double weight);
  void factorize();
  void set_hard_values(const DeformEdit& edit, const std::vector<Mat3>& scaled_rotations);
  void set_curvature_targets(const Points& estimate, const std::vector<double>& scales);
  void solve_positions(const DeformEdit& edit, Points& result);

  Points points_;  // of the mesh as it was given
  FeatureRegionOptions options_;
  DeformSystem system_;
  std::vector<int> region_of_row_;  // of the rows (5): whose scale they have, or -1
  std::vector<EdgeEquation> edges_;
  AffineReduction positions_;
  RowMatrix A_;
  SparseMatrix B_;
  SparseCholesky factor_;
  MatX rhs_, load_, x_;
  RowPoints target_;
};

}  // namespace batten
