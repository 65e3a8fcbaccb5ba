// Springs that hold a shell: soft ones, and stiff ones where no rows can hold it exactly.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"

namespace batten {

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

}  // namespace batten
