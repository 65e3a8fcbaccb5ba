// Stresses, displacements and natural modes of a shell whose shape changes.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/analysis/models/shell_results.h"

namespace batten {

/// Evaluates the maxima over all load cases while a shape changes, for example while a slider
/// moves; reuses everything that stays the same.
///
///     ShellEvaluator evaluator({definition, load_cases});
///     for (const Points& shape : shapes) evaluator.at(layout, shape).von_mises;
class ShellEvaluator {
 public:
  explicit ShellEvaluator(ShellProblem problem) : problem_(std::move(problem)) {}

  /// Maxima over all load cases.
  struct MaxValues {
    double displacement = 0, von_mises = 0;
  };
  /// Evaluates a shape. Sections and supports are taken from ShellProblem::definition for the first
  /// shape on a mesh, and kept for all others on it.
  ///
  /// Throws the exceptions of ShellModel and of the functions of the problem, and InputError if
  /// there is no load case. Cost: one stiffness matrix and one factorization; one solve and one
  /// recovery of stresses per load case.
  MaxValues at(const ModelLayout& layout, const Points& shape);

  /// Results at given locations for the load case with the largest stress.
  struct Field {
    std::string load_case;
    std::vector<float> von_mises;     ///< the larger one of the top and bottom surface
    std::vector<float> displacement;  ///< x, y, z consecutively
  };
  /// The results for the shape of the last at(). Throws InputError without one.
  Field field(const std::vector<Location>& locations) const;

  /// Natural modes at given locations.
  struct ModeShapes {
    std::vector<double> frequencies;  ///< ascending, 1/time
    /// Of each mode, x, y, z consecutively; the largest one has the length 1.
    std::vector<std::vector<float>> displacements;
  };
  /// Up to `count` natural modes for the shape of the last at(); fewer if the shell has too few
  /// unknowns. Throws the exceptions of natural_modes(), and InputError without a shape.
  ModeShapes mode_shapes(const std::vector<Location>& locations, int count) const;

 private:
  void require_shape() const;

  ShellProblem problem_;
  std::optional<ShellModel> shell_;
  std::string governing_case_;  // load case of displacement_
  Points displacement_;         // no rows: no shape has been evaluated
};

}  // namespace batten
