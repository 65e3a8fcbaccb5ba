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
/// driven ones, those of [[fair]], and those at a bound in both directions.
///
/// The derivatives are central differences over a change of about 1e-4 of the model's size, and
/// one-sided ones at the bound of a parameter. Their relative error is about 1e-7. Cost: three
/// shapes per parameter, with one factorization for all values of loads. Throws the exceptions of
/// solve_shape().
std::vector<ShapeDerivative> shape_derivatives(const Scene& scene, const BuiltModel& made,
                                               const SolvedShape& shape,
                                               const Progress& progress = {});

}  // namespace batten
