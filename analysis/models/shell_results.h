// SPDX-License-Identifier: MPL-2.0
// Load cases of a shell and their results: maxima, error estimates, equilibrium, validity of the
// theory.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_model.h"
#include "batten/analysis/models/shell_stresses.h"
#include "batten/core/progress.h"

namespace batten {

/// A load case, or a combination of load cases.
struct ShellLoadCase {
  std::string name;
  Points load;  ///< load vector, n×3 (shell_loads.h)
  /// Points of application of point forces, at which stresses are singular.
  std::vector<Vec3> singular_points = {};
  /// Places that the search for the largest stress leaves out (refine_shell()).
  std::vector<SingularPlace> singular_places = {};
  /// Stiffness of loads that follow the surface (follower_stiffness()), for buckling; empty: none.
  SparseMatrix follower = {};
  /// Change of the temperature, whose load (ShellAssembler::thermal_load()) `load` contains.
  ShellTemperature temperature = {};
};

/// A shell whose shape or mesh changes: its definition and its loads as functions of the shape.
/// `layout`: the model; `shape`: absolute dofs of the middle surface on it.
struct ShellProblem {
  /// Computes sections and supports. They may depend on the mesh, for example through the location
  /// of a point support.
  std::function<ShellDefinition(const ModelLayout& layout, const Points& shape)> definition;
  /// Computes the load cases for a shape; their names and order must not depend on the shape.
  std::function<std::vector<ShellLoadCase>(const ModelLayout& layout, const Points& shape,
                                           const ShellDefinition& definition)>
      load_cases;
};

/// Largest displacement of a middle surface. It is sought at the vertices and, in triangles that
/// the trim cuts, at quadrature points inside the trim.
struct MaxDisplacement {
  double value = 0;
  Vec3 vector = Vec3::Zero();
  Location where;  ///< location in the mesh of the model
  Vec3 at = Vec3::Zero();
  /// Estimated error of `value` (ShellStresses::goal_error()); set by evaluate_load_cases().
  double error = 0;
};

/// Results of one load case.
struct ShellCaseResult {
  std::string name;
  Points displacement;  ///< displacement dofs of the model, n×3
  ShellTemperature temperature;
  Resultant load;
  std::vector<SupportReaction> reactions;
  /// Larger one of |Σ forces| / Σ |force| and |Σ moments| / Σ |moment| over all nodal forces of
  /// loads, supports and ties, with moments about centre() (ForceMagnitudes).
  double equilibrium_residual = 0;
  /// Moment of the forces of the ties across gaps between faces (ShellModel::tie_resultant()),
  /// relative to Σ |moment|.
  double tie_moment = 0;
  double energy = 0;             ///< strain energy, without that of springs
  double energy_norm_error = 0;  ///< estimated relative error in the energy norm, see ShellStresses
  MaxDisplacement max_displacement;
  /// Largest von Mises stress outside of ShellLoadCase::singular_places.
  ShellStresses::Peak max_stress;
  Vec3 max_stress_point = Vec3::Zero();  ///< point of `max_stress` on the top or bottom side
  /// Smallest reserve factors by Tsai-Hill and Hoffman; empty: no material has strengths.
  std::optional<ShellStresses::Reserve> tsai_hill = {}, hoffman = {};
  std::vector<StiffenerResult> stiffeners = {};
  /// True if `max_stress` lies within three element lengths of a point force or point support.
  bool near_singularity = false;
};

/// Finds the largest displacement of a middle surface: the largest of seven samples per triangle,
/// and from there a local maximum within the triangle. `moved`: a surface on the same mesh whose
/// positions are the displacements. O(triangles).
MaxDisplacement max_displacement(const Surface& surface, const Surface& moved);

/// Edge length of a triangle: √(twice its area), model units.
double triangle_edge_length(const Surface& surface, int triangle);

/// The point force or point support within three edge lengths of a stress, outside of `known`.
std::optional<Vec3> singular_point_near(const ShellModel& shell, const ShellLoadCase& load_case,
                                        const std::vector<SingularPlace>& known,
                                        const ShellStresses::Peak& peak);

/// Function called after each load case, with the results and the recovered stresses. Both
/// arguments are valid during the call only.
using ShellCaseVisitor = std::function<void(const ShellCaseResult&, const ShellStresses&)>;

/// Solves and evaluates load cases in order, using the factorization of the shell.
///
/// `error_indicators`: if not null, receives the contribution of each triangle to the errors of the
/// energy and of the largest displacement, as input of dorfler_marking(). The contributions to each
/// of the two errors are scaled to the sum 1 and added over all cases. Throws the exceptions of
/// ShellModel::solve(), and CancelledError. Cost per case: two solves, two recoveries of stresses,
/// and two or three error estimates.
std::vector<ShellCaseResult> evaluate_load_cases(const ShellModel& shell,
                                                 const std::vector<ShellLoadCase>& cases,
                                                 const ShellCaseVisitor& visit = {},
                                                 VecX* error_indicators = nullptr,
                                                 const Progress& progress = {});

/// Ratios that show whether thin shell theory and the mesh suit a shape.
struct ThinShellRatios {
  /// Largest thickness / radius of curvature. The theory is valid up to about 0.1.
  double thickness_over_radius = 0;
  /// Largest edge length / √(radius of curvature · thickness). Above 1.5, elements may be too
  /// stiff.
  double edge_over_boundary_layer = 0;
};
/// Computes the largest ratios over the centroids of all triangles of a shell. O(triangles).
ThinShellRatios thin_shell_ratios(const ShellModel& shell);

}  // namespace batten
