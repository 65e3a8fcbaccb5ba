// Shapes that run straight, or as splines, across sections: lofts.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

bool is_ring(const RegionLayout& region);

/// The shape of least bending across sections only,
///
///     ∫ X_tt² du dv + 1e-4 (rings: 1e-7) · bending in all directions,
///
/// t from section to section: of a ring from rim to rim, of a region with four corners from the side
/// that one of `sections` is part of to the opposite side. Between two lines it is ruled; inner
/// lines are sections too, and the shape is a spline through them. Other regions bend in all
/// directions. Every line is held as always. Dofs are in absolute coordinates.
///
/// Throws InputError: no ring and no sections, a section that is no line of the model, or no side of a region with four
/// corners. ConflictError, NoSolutionError. Cost: one factor of one coordinate.
Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections);

}  // namespace batten
