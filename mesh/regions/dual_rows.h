// Faces of any number of corners, their dual mesh and its rows. Internal.
#pragma once

#include <vector>

#include "batten/mesh/regions/turning_rows.h"

namespace batten {

/// As in DualLaplacianOptions.
struct DualRowOptions {
  bool edge_middles, fits_scale;
  double membrane, primal;
};

/// Face across each edge of each face (edge k: corner k to k+1), or -1. Throws InputError, see
/// DualLaplacianDeformer.
std::vector<std::vector<int>> faces_across(const std::vector<std::vector<int>>& faces,
                                           int vertex_count);

/// The triangles of a mesh as faces.
std::vector<std::vector<int>> faces_of(const TriangleMesh& mesh);

/// Twice the area of a polygon, times its mean normal.
Vec3 area_vector(const std::vector<int>& face, const Points& points);

/// Weights Σ w = 1, nearest to 1/k, with Σ w_j r_j upright on the plane of the r_j.
VecX upright_weights(const Eigen::Matrix3Xd& r);

/// The rows of the energy of DualLaplacianDeformer, one element and one cell a face.
TurningRows dual_rows(const TriangleMesh& mesh, const std::vector<std::vector<int>>& faces,
                      const DualRowOptions& options);

}  // namespace batten
