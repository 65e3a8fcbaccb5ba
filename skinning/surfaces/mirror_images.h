// SPDX-License-Identifier: MPL-2.0
// Half models: mirror images of curves, and of specifications of joins and faces, in a plane of
// symmetry.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/search/regions.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The plane of symmetry of a half model.
struct SymmetryPlane {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitX();  ///< normal vector of any length above zero
  /// Curves within this distance of the plane count as lying in the plane, model units. 0: 1e-3 of
  /// the diagonal of the bounding box of all curves.
  double tolerance = 0;
};

/// Adds the mirror images of the curves of a half model, named "mirrored NAME". A curve that ends
/// in the plane continues in its mirror image; curves in the plane are not mirrored.
///
/// Throws InputError if a curve crosses the plane, or if the normal has length zero. O(curves).
void add_mirror_images(const SymmetryPlane& plane, std::vector<CharacterLine>& lines);

/// The join specifications `joins`, and the mirror image of each one whose curve is mirrored.
///
/// `lines`: all curves, including the mirror images. A specification may name an edge, such as
/// "rail.2", whose mirror image is "mirrored rail.2". The specifications in `joins` come last in
/// the result and take precedence over mirror images. O(joins · log curves).
std::vector<JoinSpec> with_mirror_images(const std::vector<JoinSpec>& joins,
                                         const std::vector<CharacterLine>& lines);

/// The face specifications `regions` and their mirror images. A face is not mirrored if it has
/// curves in both halves of the model, or if `regions` contains its mirror image. `lines`: all
/// curves, including the mirror images. O(n²) for n faces.
std::vector<RegionSpec> with_mirror_images(const std::vector<RegionSpec>& regions,
                                           const std::vector<CharacterLine>& lines);

}  // namespace batten
