// Regions of a mesh whose shape should survive an edit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct FeatureRegion {
  std::string name;
  std::vector<int> faces;     ///< triangles; none: those with at least one corner in `vertices`
  std::vector<int> vertices;  ///< not looked at when there are faces
  std::optional<Mat3> rotation = {};  ///< the user's, instead of the estimate's mean
  double scale = 1;                   ///< above 0
};

/// The connected components (along edges) of the vertices whose mask is not 0, each ascending,
/// sorted by their lowest vertices. Throws InputError when the mask has another size than the mesh.
/// O(mesh).
std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask);

/// The triangles of a region, ascending. Throws InputError that names the region: numbers out of
/// range, nothing in it.
std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region);

}  // namespace batten
