// Fair shapes of models: curvature that changes as little as their lines allow.
#pragma once

#include "batten/core/progress.h"
#include "batten/fairing/minimum_variation_surface.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Fairs a shape of a model under these rows (those of its lines, and any others), downhill from
/// `start`: minimize_curvature_variation() with the sides of all regions and the weight of Gauss curvature that
/// suits them (large on rings between two rims alone: they become cylinders and cones where they
/// can). A model with rings starts from loft_shape() too (if `options` has no other starts), which does not pinch long ones. Smooth
/// joins stay smooth, and curvature goes on across those that is_curvature_continuous() names. Dofs are
/// in absolute coordinates.
///
/// Of `options`, gauss, sides and joins are chosen here. `constraints` as of
/// ModelLayout::line_constraints(). Throws as minimize_curvature_variation().
MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options = {},
                                   const Progress& progress = {});

}  // namespace batten
