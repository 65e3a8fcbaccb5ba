// Named linear constraints on the dofs of a curve, a surface or a mesh.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Constraints on n unknowns for each of x, y, z, gathered one by one:
///
///     uncoupled   Σ_m a_m q_m = d          the same coefficients for x, y and z, three right-hand
///                                          sides (a point, a fixed dof)
///     coupled     Σ_m a_m · q_m = d        a_m a 3-vector: one equation that mixes x, y and z (a
///                                          normal, a plane)
///
/// Rows that belong together share a name, which errors and reports use. Nothing is checked until
/// AffineReduction looks at all of them together.
class ConstraintSet {
 public:
  struct Entry {
    int dof;
    double coefficient;
  };
  struct CoupledEntry {
    int dof;
    Vec3 coefficient;
  };
  struct Constraint {
    int name;  ///< index into names()
    std::vector<Entry> entries;
    Vec3 value;
  };
  struct CoupledConstraint {
    int name;
    std::vector<CoupledEntry> entries;
    double value;
  };

  /// Whether the set is coupled from the start: so it is for a matrix that mixes x, y and z itself.
  enum class Kind { Uncoupled, Coupled };
  explicit ConstraintSet(int dof_count, Kind kind = Kind::Uncoupled)
      : dof_count_(dof_count), kind_(kind) {}

  int dof_count() const { return dof_count_; }
  bool coupled() const { return kind_ == Kind::Coupled || !coupled_constraints_.empty(); }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  const std::vector<CoupledConstraint>& coupled_constraints() const { return coupled_constraints_; }
  const std::vector<std::string>& names() const { return names_; }

  /// q_dof = value.
  void fix(const std::string& name, int dof, const Vec3& value);
  /// Throws InputError on a dof out of range, or a number that is not finite.
  void add(const std::string& name, std::vector<Entry> entries, const Vec3& value);
  void add_coupled(const std::string& name, std::vector<CoupledEntry> entries, double value);

  /// The same constraints on q - constant·byᵀ instead of q, for a vector `constant` of n numbers:
  /// with 1 at the position dofs of a surface, the constraints on the surface moved by -by. Far
  /// from the origin, solving the moved problem saves the digits that the coordinates would take.
  ConstraintSet translated(const VecX& constant, const Vec3& by) const;

  /// Largest |row - value| at dofs q (n×3), over all rows.
  double max_residual(const Points& q) const;

 private:
  int name_index(const std::string& name);
  int dof_count_;
  Kind kind_;
  std::vector<std::string> names_;
  std::vector<Constraint> constraints_;
  std::vector<CoupledConstraint> coupled_constraints_;
};

}  // namespace batten
