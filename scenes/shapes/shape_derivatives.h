// SPDX-License-Identifier: MPL-2.0
// Derivatives of the shape of a scene with respect to its parameters.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

/// Derivative of a shape with respect to a parameter.
struct ShapeDerivative {
  std::string parameter;
  Points rate;  ///< derivative of the dofs, n×3; 0: the parameter does not change the shape
};

/// Computes the derivatives of a solved shape with respect to all parameters of its scene, except
/// driven ones, those of [[fair]], and those that may not be changed (min = max).
///
/// The derivatives are differences of second order with Richardson extrapolation: central ones, or
/// one-sided ones at the bound of a parameter. The steps change the shape by at most about 1e-4 of
/// its size. Throws InputError if the shape is not in equilibrium, or if its elements change with a
/// parameter (fitted and lofted shapes), and the exceptions of solve_shape(). Cost: about six shapes
/// per parameter, with one factorization for all values of loads.
std::vector<ShapeDerivative> shape_derivatives(const Scene& scene, const BuiltModel& made,
                                               const SolvedShape& shape,
                                               const Progress& progress = {});

}  // namespace batten
