// SPDX-License-Identifier: MPL-2.0
// Derivatives of the properties of a model and of its stresses with respect to the parameters.
#pragma once

#include <map>
#include <optional>
#include <string>

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

}  // namespace batten
