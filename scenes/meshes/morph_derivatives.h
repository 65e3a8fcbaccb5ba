// SPDX-License-Identifier: MPL-2.0
// Derivatives of an edited mesh with respect to the parameters of its scene.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/scenes/meshes/mesh_dimension.h"
#include "batten/scenes/meshes/morph_solver.h"

namespace batten {

/// Derivative of the edited mesh with respect to one parameter.
struct MorphDerivative {
  Parameter parameter;
  /// Derivative of the vertex positions (n×3), model units per unit of the parameter (degrees for
  /// angles).
  Points rate;
  std::vector<double> dimensions;  ///< derivative of each dimension
  double error = 0;                ///< estimated error of `rate` relative to its largest entry
  /// Why there is no derivative; empty: there is one. Another value of the parameter may contradict
  /// the constraints.
  std::string missing;
};

/// Tolerance of a MorphSolver for derivatives: the errors of its solutions are larger by a factor of up
/// to 70 (slowest modes of the iteration), and differences multiply them by 500.
inline constexpr double kDerivativeTolerance = 1e-13;

/// A small change of a parameter, to begin with: 0.1 degrees, 0.1 % of a scale or a load, or 0.1 %
/// of the size of the mesh.
double parameter_step(const Parameter& parameter, double size);

/// Derivatives of the edited mesh with respect to `parameters` at the values of `scene`.
///
/// Central differences of order six: D₆ = (16 D₄(h) - D₄(2h)) / 15 from those of order four, D₄(h) =
/// (8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / 12h, with a step h that displaces a vertex by about 0.1 % of
/// the size of the mesh. The edits must be solved to convergence (kDerivativeTolerance), so that the
/// derivatives are exact to about 1e-9 of their largest entry. The estimated error is that of D₄(h);
/// the step is halved, at most twice, while it exceeds 1e-8. Cost: seven to nineteen solutions a
/// parameter, without factorizations for the values of the first edit (with one each for the scales
/// of features, and for edits that follow). Throws the exceptions of MorphSolver::solve().
std::vector<MorphDerivative> morph_derivatives(MorphSolver& solver, const DeformScene& scene,
                                               const std::vector<Parameter>& parameters,
                                               const std::vector<MeshDimension>& dimensions,
                                               const Progress& progress = {});

}  // namespace batten
