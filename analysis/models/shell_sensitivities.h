// Sensitivities: derivatives of displacement, compliance and stress of a shell with respect to its
// shape.
#pragma once

#include <functional>
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
///     const auto rate = shape_derivative([&](double d) { return shape_for(height + d); }, 0.1);
///     sensitivities.along(*rate)[0].displacement;   // per unit of the height
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
  };

  /// Solves the load cases and their adjoint problems. `norm_exponent`: P of
  /// Quantities::von_mises_norm; 0: it is not computed. Throws the exceptions of ShellModel,
  /// of von_mises_norm() and of the functions in `problem`, and InputError if a load case does not
  /// exist or a direction is zero. Cost: one factorization, three or four solves per goal.
  ShellSensitivities(const ModelLayout& layout, const Points& shape, ShellProblem problem,
                     const std::vector<Goal>& goals, double norm_exponent = 0);

  /// Values of all goals.
  std::vector<Quantities> values() const;
  /// Derivatives of all goals. `shape_rate`: rate of change of the shape's dofs (n×3). The system
  /// is differentiated by central differences. Throws InputError for a rate of the wrong size.
  /// Cost: two stiffness matrices and two sets of loads.
  std::vector<Quantities> along(const Points& shape_rate) const;
  /// Derivative of the mass (shell_mass()), by central differences. Throws as along().
  double mass_along(const Points& shape_rate) const;

  const ShellModel& shell() const { return shell_; }

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
  };
  Change change_to(const Points& shape) const;
  Quantities changes(const SolvedGoal& goal, const Change& change) const;
  double step_along(const Points& shape_rate) const;

  ShellProblem problem_;
  ShellModel shell_;
  double norm_exponent_;
  std::vector<SolvedGoal> goals_;
};

/// Computes the dofs (n×3) of a shape after its parameter has changed by `change`; nullopt if the
/// changed value is not permitted.
using ShapeOfChange = std::function<std::optional<Points>(double change)>;

/// Derivative of a shape with respect to a parameter: the central difference of `shape_of(±step)`,
/// or a one-sided one with `shape_of(0)` if only one direction is permitted. Returns nullopt if
/// neither is permitted. Throws the exceptions of `shape_of`.
std::optional<Points> shape_derivative(const ShapeOfChange& shape_of, double step);

}  // namespace batten
