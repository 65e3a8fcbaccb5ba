// SPDX-License-Identifier: MPL-2.0
// Stresses, displacements and natural modes of a shell whose shape changes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/core/progress.h"

namespace batten {

/// Evaluates the maxima over all load cases while a shape changes, for example while a slider
/// moves; reuses everything that stays the same.
///
///     ShellEvaluator evaluator({definition, load_cases});
///     for (const Points& shape : shapes) evaluator.at(layout, shape).von_mises;
///
/// All functions poll `progress` at intervals of some milliseconds and then throw CancelledError.
/// at() also reports the stages "constraints", "assembly", "ordering", "factorization", "solving"
/// and "stresses" to it.
class ShellEvaluator {
 public:
  explicit ShellEvaluator(ShellProblem problem) : problem_(std::move(problem)) {}
  ShellEvaluator(const ShellEvaluator&) = delete;  // members refer to one another
  ShellEvaluator& operator=(const ShellEvaluator&) = delete;

  /// Largest displacement and largest von Mises stress over all load cases.
  struct MaxValues {
    double displacement = 0, von_mises = 0;
  };
  /// Evaluates a shape, with the sections, supports and loads that ShellProblem computes for it.
  ///
  /// A shape close to the one that was factored last is solved with that factorization as the
  /// preconditioner (ShellModel::solve()); the results then have a relative error of about 1e-7.
  /// Apart from this error, they do not depend on the shapes before.
  ///
  /// Throws the exceptions of ShellModel and of the functions in ShellProblem, and InputError if
  /// there is no load case. After an exception, no shape counts as evaluated, and at() may be called
  /// again. Cost: one stiffness matrix, and one factorization unless the shape is close to another
  /// one; one solve and one recovery of stresses per load case.
  MaxValues at(const ModelLayout& layout, const Points& shape, const Progress& progress = {});

  /// Results at given locations for the load case with the largest stress.
  struct Field {
    std::string load_case;
    std::vector<float> von_mises;  ///< per location: larger von Mises stress of top and bottom side
    std::vector<float> displacement;  ///< x, y, z of each location, one location after the other
  };
  /// Results for the shape of the last call of at(). Throws InputError if at() has not been called.
  Field field(const std::vector<Location>& locations, const Progress& progress = {}) const;

  /// Natural modes at given locations.
  struct ModeShapes {
    std::vector<double> frequencies;  ///< natural frequencies, ascending, 1/time
    /// Per mode: x, y, z of each location, one location after the other. The largest displacement
    /// of a mode has length 1.
    std::vector<std::vector<float>> displacements;
  };
  /// Up to `count` natural modes for the shape of the last call of at(); fewer if the shell has too
  /// few unknowns. Throws the exceptions of natural_modes(), and InputError if at() has not been
  /// called.
  ModeShapes mode_shapes(const std::vector<Location>& locations, int count,
                         const Progress& progress = {});

 private:
  /// A solved load case. The stresses refer to the other members.
  struct Solved {
    std::string name;
    Points displacement;
    ShellTemperature temperature;
    std::unique_ptr<const ShellStresses> stresses;
  };
  void update(const ModelLayout& layout, const Points& shape);
  Points solve(const ShellLoadCase& load_case, size_t index);
  void factor();
  std::unique_ptr<const Solved> recovered(const std::string& name, const Points& displacement,
                                          const ShellTemperature& temperature) const;
  const ShellAssembler& assembler() const {
    return similar_ ? similar_->assembler : shell_->assembler();
  }
  void require_shape() const;

  ShellProblem problem_;
  std::optional<ShellModel> shell_;             // factored for its shape
  std::unique_ptr<const ShellSystem> similar_;  // system of `shape_`; null: that of the shell
  std::optional<AffineReduction> reduction_;    // of the constraints of `similar_`
  Points shape_;
  ShellDefinition definition_;               // of `shape_`
  std::vector<Points> displacements_;        // of the load cases of the last shape
  std::unique_ptr<const Solved> governing_;  // null: no shape has been evaluated
};

}  // namespace batten
