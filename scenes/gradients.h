// SPDX-License-Identifier: MPL-2.0
// Derivatives of the properties of a model and of its stresses with respect to the parameters, and
// effects of loads.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// A quantity and its derivatives with respect to the parameters of a model, by name: all parameters
/// except driven ones, those of [[fair]], which change the mesh, and those with min = max.
struct ValueWithGradient {
  double value = 0;
  std::map<std::string, double> gradient;
};

/// Result of Model::gradients().
struct ModelGradients {
  ValueWithGradient area;                   ///< Model::area(), model units²
  std::optional<ValueWithGradient> volume;  ///< Model::volume(); empty: the surface is open
};

/// Result of Stress::gradients(), for one load case.
struct StressGradients {
  /// Displacement of the point with the largest displacement, in the direction of that displacement.
  /// Its value is StressCase::max_displacement. Where that point jumps to another place, the gradient
  /// does, too.
  ValueWithGradient max_displacement;
  ValueWithGradient compliance;      ///< work of the loads, Fᵀu
  ValueWithGradient von_mises_norm;  ///< P-norm of the von Mises stress, force per area
  ValueWithGradient mass;            ///< mass of the shell; 0: no density
};

/// Effect of a load, a curve offset or a slider on the shape, for a small change from its value in
/// the model. Result of Model::load_effects().
struct LoadEffect {
  std::string parameter;
  double displacement = 0;  ///< largest displacement of the surface per unit of the parameter
  Vec3 at = Vec3::Zero();   ///< where it is, model units
  std::string face;         ///< the face that contains that point
  /// The change that displaces the surface by about 1 % of its size; 0: it has no effect.
  double visible = 0;
};

}  // namespace batten
