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

/// How FeatureRegionDeformer keeps them; (5), (6), (10): its equations.
struct FeatureRegionOptions {
  enum class Kind {
    Soft,  ///< rows (6) with `weight`: regions keep their shape nearly, and join softly
    Hard   ///< p = s R' p⁰ + t exactly, eliminated: three unknowns a region
  } kind = Kind::Hard;
  enum class Rhs {
    Estimate,  ///< L V', the Laplacian vectors of the estimate
    Original   ///< L V, as the paper has it: they do not turn, and resist large bends
  } rhs = Rhs::Estimate;
  enum class Mean {
    Squared,  ///< mean_rotation: min Σ A_f ‖R' - R_f‖²
    Robust    ///< median_rotation: min Σ A_f ‖R' - R_f‖, equation (10)
  } mean = Mean::Squared;
  double weight = 2e7;  ///< Soft: see below; without unit
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
