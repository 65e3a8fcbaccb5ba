// Shapes that run straight, or as splines, across sections: lofts.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// The shape nearest (ModelLayout::nearest()) to one that runs through sections as a spline: on each
/// line across them the cubic through their points, with ends that are not flat; straight between
/// two (section_surface.h). Sections are, of a ring, its rims; of a region with four corners the
/// side that one of `sections` is part of and the opposite side; and inner lines that run along
/// them. Other regions bend least. Every line is held as always. Dofs are in absolute coordinates.
///
/// Throws InputError: no ring and no sections, a section that is no line of the model, or no side of
/// a region with four corners. ConflictError, NoSolutionError. Cost: one factor of one coordinate.
Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections);

struct LoftedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// loft_shape() on a mesh that is fine enough for it: triangles in which the surface through the
/// sections is missed by more than `most`, model units, are halved, in at most four rounds (between
/// the noses of two sections the mesh of their lines would be too coarse). Smooth joins are planned
/// again then.
LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most);

}  // namespace batten
