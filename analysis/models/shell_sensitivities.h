// SPDX-License-Identifier: MPL-2.0
// Sensitivities: derivatives of displacement, compliance and stress of a shell with respect to its
// shape.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/analysis/models/von_mises_norm.h"

namespace batten {

/// Sensitivities of the load cases of a shell with respect to changes of its shape, by the adjoint
/// method (ShellModel::goal_change()): the systems of changed shapes are assembled, but not
/// factored. Supports, loads and thicknesses change with the shape as `problem` defines them; for
/// example, a point support stays at the surface point nearest to a given point.
///
///     const ShellSensitivities sensitivities(layout, shape, problem, {{"wind", tip, {0, 0, 1}}}, 8);
///     const Points rate = (shape_for(height + d) - shape_for(height - d)) / (2 * d);
///     sensitivities.along(rate)[0].displacement;    // per unit of the height
///
/// Reference: docs/theory/shells.md.
class ShellSensitivities {
 public:
  /// A load case, and a displacement whose derivative is sought: the displacement of the material
  /// point that is nearest to `at`, along `direction` (any length except zero).
  struct Goal {
    std::string load_case;
    Vec3 at, direction;
  };
  /// Quantities of one goal, or their derivatives.
  struct Quantities {
    double displacement = 0;    ///< displacement along Goal::direction
    double compliance = 0;      ///< work of the loads, Fᵀu
    double von_mises_norm = 0;  ///< P-norm of the von Mises stress (von_mises_norm.h)
    double mass = 0;            ///< mass of the shell (shell_mass()), the same for all goals
  };

  /// Solves the load cases and their adjoint problems. `norm_exponent`: P of
  /// Quantities::von_mises_norm; empty: it is not computed. Throws the exceptions of ShellModel,
  /// of von_mises_norm() and of the functions in `problem`, and InputError if a load case does not
  /// exist or a direction is zero. Cost: one factorization, three or four solves per goal.
  ShellSensitivities(const ModelLayout& layout, const Points& shape, ShellProblem problem,
                     const std::vector<Goal>& goals, std::optional<double> norm_exponent = {});

  /// Values of all goals.
  std::vector<Quantities> values() const;
  /// Derivatives of all goals. `shape_rate`: rate of change of the shape's dofs (n×3). The system
  /// is differentiated by central differences over 1e-5 of the model's size, but at most a tenth of
  /// the thickness. Throws InputError for a rate of the wrong size, or one that is not finite.
  /// Cost: two stiffness matrices and two sets of loads.
  std::vector<Quantities> along(const Points& shape_rate) const;

 private:
  // A goal: load F of its load case, solution u of K u = F, the vector G for which the displacement
  // of the goal is Gᵀu, and the norm of the stresses of u. The adjoint solutions solve
  // K adjoint_of_G = G, and so on, with zero prescribed displacements. adjoint_of_G gives the
  // derivative of the displacement Gᵀu, adjoint_of_F that of the compliance Fᵀu, adjoint_of_norm
  // that of the norm.
  struct SolvedGoal {
    std::string load_case;
    Points F, u, G, adjoint_of_G, adjoint_of_F;
    VonMisesNorm norm;
    Points adjoint_of_norm;
  };
  // The problem for a changed shape.
  struct Change {
    ShellSystem system;
    std::vector<ShellLoadCase> cases;
    double added_mass;
  };
  static double mass_of(const Change& change) {
    return shell_mass(change.system.assembler) + change.added_mass;
  }
  // `follows`: supports, loads and thicknesses are those of the changed shape; otherwise, supports
  // and thicknesses are those of the shell.
  Change change_to(const Points& shape, bool follows) const;
  std::array<Change, 2> changes_along(const Points& step) const;
  Quantities changes(const SolvedGoal& goal, const Change& change) const;

  ShellProblem problem_;
  ShellModel shell_;
  std::optional<double> norm_exponent_;
  std::vector<SolvedGoal> goals_;
};

}  // namespace batten
