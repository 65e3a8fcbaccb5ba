// Half models: mirror images of curves, and of specifications of joins and faces, in a plane of
// symmetry.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/search/regions.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// A plane of symmetry.
struct SymmetryPlane {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitX();  ///< its length does not matter
  /// Curves within this distance of the plane lie in it, model units; 0: 1e-3 of the diagonal of
  /// the bounding box of all curves.
  double tolerance = 0;
};

/// Adds the mirror images of the curves of a half model, named "mirrored NAME". A curve that ends
/// in the plane continues in its mirror image; curves in the plane are not mirrored.
///
/// Throws InputError for a curve that crosses the plane, and for a normal of length zero.
/// O(curves).
void add_mirror_images(const SymmetryPlane& plane, std::vector<CharacterLine>& lines);

/// Specifications of joins, extended by the mirror images of those whose curve is mirrored.
///
/// `lines`: the curves with their mirror images. Names may be those of edges, such as "rail.2",
/// whose mirror image is "mirrored rail.2". The given specifications come last and take precedence.
std::vector<JoinSpec> with_mirror_images(const std::vector<JoinSpec>& joins,
                                         const std::vector<CharacterLine>& lines);

/// Specifications of faces, extended by their mirror images. A face with curves of both halves, and
/// one whose mirror image is specified, too, are not mirrored. `lines`: as above.
std::vector<RegionSpec> with_mirror_images(const std::vector<RegionSpec>& regions,
                                           const std::vector<CharacterLine>& lines);

}  // namespace batten
