// SPDX-License-Identifier: MPL-2.0
// Tie constraints between adjacent regions of a model, and springs.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/constraints/constraint_set.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Springs that support or connect a shell: soft ones, and stiff ones (penalty) where exact
// constraints are not possible.

/// Collection of springs with the energy ½ k (Σ_m a_m · q_m - value)², summed over springs.
///
/// q_m: displacement at dof m; a_m: coefficients. Each spring acts at a quadrature point of a curve
/// or an area; k is the stiffness per length or area, times the length or area that the point
/// represents. On curves that cross elements anywhere, exact constraints would be too many or too
/// few. Springs that are a thousand times as stiff as the adjacent elements avoid both (see
/// shell_ties()).
class ShellSprings {
 public:
  using Entries = std::vector<ConstraintSet::CoupledEntry>;
  enum class Kind {
    Support,   ///< a support or a tie
    Stiffener  ///< a part of the shell, whose rigid motions cause no force (Stiffeners)
  };
  struct Spring {
    int name;         ///< index of the spring's name in names()
    Entries entries;  ///< coefficient vector of each dof; each dof occurs once
    double stiffness, value;
    Kind kind = Kind::Support;
  };

  explicit ShellSprings(int dof_count) : dof_count_(dof_count) {}
  /// Adds the spring with the energy ½ · stiffness · (Σ_m a_m · q_m - value)². `entries`: dofs m
  /// with their coefficients a_m; entries with the same dof are summed. Springs with the same
  /// `name` share one entry of names().
  void add(const std::string& name, const Entries& entries, double stiffness, double value,
           Kind kind = Kind::Support);

  bool empty() const { return springs_.empty(); }
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Stiffness matrix (lower triangle), 3n×3n over [x; y; z].
  SparseMatrix stiffness() const;
  /// Load vector (n×3) of the prescribed values: Σ stiffness · value · coefficients over springs.
  Points load() const;
  /// Scalar force of a spring for the displacement q (n×3). The force of the spring on the shell at
  /// dof m is this value times a_m.
  static double pull(const Spring& spring, const Points& q);

 private:
  int dof_count_;
  std::vector<std::string> names_;
  std::vector<Spring> springs_;
};

/// Ties and supports of a shell: exact constraints, and springs, for example along embedded curves.
struct ShellTies {
  ConstraintSet constraints;
  ShellSprings springs;
};

/// Creates the ties between regions that share a curve, so that they deform as one shell;
/// constraints are named "joined curve NAME". Positions and derivatives along the curve are equal
/// on both sides, and so is the rotation ω about it,
///
///     ω = -(n · U_y - b/|x_t| n · U_t)/a,     y = a (τ × n) + b τ,  τ = x_t/|x_t|,
///
/// where n is the normal, x_t the derivative along the curve, y a direction into the region and U
/// the displacement of the region. Moments are thus transferred across smooth joins and across
/// creases of any angle, also if three or more regions meet. Along `hinges`, regions share
/// positions and derivatives only.
///
/// If the curve follows element edges on both sides, the ties are exact constraints, with ω equal
/// at vertices and edge midpoints. If the curve is embedded in a region, springs along it tie
/// positions and ω. Their stiffness per length is
///
///     α A11 t/h  and  α D11 t³/h,     α = 1000, h the length of an element edge,
///
/// so that springs deform a thousandth as much as an element (penalty coupling of Kirchhoff-Love
/// shells on non-matching meshes, [Herrema2019]).
///
/// Constraints and springs refer to the dofs of the model. `shape`: absolute dofs of the middle
/// surface; `sections`: one for all regions, or one per region. Throws InputError if a hinge is not
/// a curve of the model, or belongs to one region only. Reference: docs/theory/shells.md.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const std::vector<ShellSection>& sections,
                     const std::vector<std::string>& hinges = {});

}  // namespace batten
