// Faces of any number of corners, their dual mesh and its rows. Internal.
#pragma once

#include <vector>

#include "batten/mesh/regions/local_global_solver.h"

namespace batten {

/// As in DualLaplacianOptions.
struct DualLaplacianEnergyOptions {
  bool edge_midpoints, fits_scale;
  double membrane, checkerboard_penalty;
};

/// Face across each edge of each face (edge k: corner k to k+1), or -1. Throws InputError, see
/// DualLaplacianDeformer.
std::vector<std::vector<int>> face_adjacency(const std::vector<std::vector<int>>& faces,
                                             int vertex_count);

/// The triangles of a mesh as faces.
std::vector<std::vector<int>> faces_of(const TriangleMesh& mesh);

/// Twice the area of a polygon, times its mean normal.
Vec3 area_vector(const std::vector<int>& face, const Points& points);

/// Weights Σ w = 1, nearest to 1/k, with Σ w_j r_j upright on the plane of the r_j.
VecX tangent_free_weights(const Eigen::Matrix3Xd& r);

/// The rows of the energy of DualLaplacianDeformer, one element and one cell a face.
ArapEnergy dual_laplacian_energy(const TriangleMesh& mesh,
                                 const std::vector<std::vector<int>>& faces,
                                 const DualLaplacianEnergyOptions& options);

}  // namespace batten
