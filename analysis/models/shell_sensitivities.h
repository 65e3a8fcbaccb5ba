// Sensitivities: derivatives of displacement and compliance of a shell with respect to its shape.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"

namespace batten {

/// Sensitivities of the load cases of a shell with respect to changes of its shape, by the adjoint
/// method (ShellModel::goal_change()): the systems of changed shapes are assembled, but not
/// factored. Thickness and material stay the same, and point supports stay at the same material
/// points.
///
///     const ShellSensitivities sensitivities(layout, shape, problem, {{"wind", tip, {0, 0, 1}}});
///     const auto rate = shape_derivative([&](double d) { return shape_for(height + d); }, 0.1);
///     sensitivities.along(*rate)[0].displacement;   // per unit of the height
///
/// Reference: docs/theory/shells.md.
class ShellSensitivities {
 public:
  /// A load case, and a displacement whose derivative is sought: the displacement of the surface
  /// point nearest to `at`, along `direction` (any length except zero).
  struct Goal {
    std::string load_case;
    Vec3 at, direction;
  };
  /// Derivatives, with respect to the shape, of the displacement and of the compliance of one goal.
  struct Derivatives {
    double displacement = 0;  ///< derivative of the displacement along Goal::direction
    double compliance = 0;    ///< derivative of the work of the loads, Fᵀu
  };

  /// Solves the load cases and their adjoint problems. Throws the exceptions of ShellModel and of
  /// the functions in `problem`, and InputError if a load case does not exist or a direction is
  /// zero. Cost: one factorization, three solves per goal.
  ShellSensitivities(const ModelLayout& layout, const Points& shape, ShellProblem problem,
                     const std::vector<Goal>& goals);

  /// Derivatives of all goals. `shape_rate`: rate of change of the shape's dofs (n×3). The system
  /// is differentiated by central differences. Throws InputError for a rate of the wrong size.
  /// Cost: two stiffness matrices and two sets of loads.
  std::vector<Derivatives> along(const Points& shape_rate) const;

 private:
  // A goal: load F of its load case, solution u of K u = F, and the vector G for which the
  // displacement of the goal is Gᵀu. The adjoint solutions solve K adjoint_of_G = G and K
  // adjoint_of_F = F with zero prescribed displacements. adjoint_of_G gives the derivative of the
  // displacement Gᵀu, adjoint_of_F that of the compliance Fᵀu.
  struct SolvedGoal {
    std::string load_case;
    Points F, u, G, adjoint_of_G, adjoint_of_F;
  };
  std::vector<ShellLoadCase> load_cases(const Points& shape) const;

  ShellProblem problem_;
  ShellModel shell_;
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
