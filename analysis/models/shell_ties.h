// What makes one shell of the regions of a model.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/constraints/constraint_set.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Springs that hold a shell: soft ones, and stiff ones where no rows can hold it exactly.

/// The energy ½ Σ k (Σ a_m · q_m - value)², each term a quadrature point of a line or an area, k its
/// stiffness per length or area times the length or area that it stands for. On lines that cross
/// elements anyhow rows would be too many or too few; springs a thousand times as stiff as the
/// elements beside them are neither (shell_ties.h).
class ShellSprings {
 public:
  using Entries = std::vector<ConstraintSet::CoupledEntry>;
  struct Spring {
    int name;         ///< index into names()
    Entries entries;  ///< each dof once
    double stiffness, value;
  };

  explicit ShellSprings(int dof_count) : dof_count_(dof_count) {}
  /// Entries that name a dof again are added up.
  void add(const std::string& name, const Entries& entries, double stiffness, double value);

  bool empty() const { return springs_.empty(); }
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Lower triangle, 3n×3n over [x; y; z].
  SparseMatrix stiffness() const;
  /// Σ k value a_m, n×3: what pulls towards the values.
  Points load() const;
  /// The pull of a spring under q: its force on the shell is pull · a_m at each dof.
  static double pull(const Spring& spring, const Points& q);

 private:
  int dof_count_;
  std::vector<std::string> names_;
  std::vector<Spring> springs_;
};


/// Rows that hold exactly, and springs along embedded lines.
struct ShellTies {
  ConstraintSet constraints;
  ShellSprings springs;
};

/// Ties under which regions move as one shell along the lines that they share, "joined line NAME":
/// places and slopes along the line are the same, and so is the rotation ω about it,
///
///     ω = -(n · U_y - b/|x_t| n · U_t)/a,     y = a (τ × n) + b τ,  τ = x_t/|x_t|,
///
/// with y a direction into the region and U its displacement: moments are carried over creases as
/// over smooth joins, whatever their angle, also where three regions or more meet. Along `hinges`
/// regions share places and slopes only.
///
/// Of two runs these are rows: ω is the same at the vertices and in the middles of edges. Where a
/// region has the line embedded, springs along it tie places and ω, per length
///
///     α Q11 t/h  and  α Q11 t³/(12 h),     α = 1000, h the length of an element's edge,
///
/// so that they give a thousandth of what an element gives (Herrema, Johnson, Proserpio, Wu, Kiendl,
/// Hsu 2019: penalty coupling of Kirchhoff-Love shells on meshes that do not match). Everything is
/// on the dofs of the model; `shape`: absolute dofs; `sections`: one, or one for each region. Throws
/// InputError for a hinge that is no line of the model, or has one region only. Source:
/// docs/theory/shells.md.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const std::vector<ShellSection>& sections,
                     const std::vector<std::string>& hinges = {});

}  // namespace batten
