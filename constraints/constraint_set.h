// SPDX-License-Identifier: MPL-2.0
// Named linear constraints on the dofs of a curve, a surface or a mesh.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Collection of linear constraints on n dofs per coordinate x, y, z:
///
///     uncoupled   Σ_m a_m q_m = d          same coefficients for x, y and z, three right-hand
///                                          sides (a point, a fixed dof)
///     coupled     Σ_m a_m · q_m = d        a_m is a 3-vector: one equation that combines x, y
///                                          and z (a normal, a plane)
///
/// Equations that belong to one constraint share a name, which is used in error messages and
/// reports. Compatibility of the constraints is checked only by AffineReduction.
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
  /// One uncoupled constraint: an equation for each of x, y and z, with the same coefficients.
  struct Constraint {
    int name;  ///< index of the constraint's name in names()
    std::vector<Entry> entries;
    Vec3 value;
  };
  /// One coupled constraint: a single equation that combines x, y and z.
  struct CoupledConstraint {
    int name;
    std::vector<CoupledEntry> entries;
    double value;
  };

  /// Whether the system matrix couples x, y and z (Coupled) or not (Uncoupled). An uncoupled set
  /// becomes coupled when the first coupled constraint is added.
  enum class Kind { Uncoupled, Coupled };
  explicit ConstraintSet(int dof_count, Kind kind = Kind::Uncoupled)
      : dof_count_(dof_count), kind_(kind) {}

  int dof_count() const { return dof_count_; }
  /// Whether any equation, or the system matrix, couples x, y and z.
  bool coupled() const { return kind_ == Kind::Coupled || !coupled_constraints_.empty(); }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  const std::vector<CoupledConstraint>& coupled_constraints() const { return coupled_constraints_; }
  const std::vector<std::string>& names() const { return names_; }

  /// Prescribes the x, y and z of one dof: adds the uncoupled constraint q_dof = value.
  void fix(const std::string& name, int dof, const Vec3& value);
  /// Adds the constraint Σ coefficient · q_dof = value over all entries, for x, y and z separately.
  /// add_coupled(): one equation with vectors as coefficients. The two functions throw InputError
  /// if a dof is out of range or a number is not finite.
  void add(const std::string& name, std::vector<Entry> entries, const Vec3& value);
  void add_coupled(const std::string& name, std::vector<CoupledEntry> entries, double value);

  /// Constraints of this set on the dofs q (n×3), rewritten for the translated unknown q - constant
  /// · byᵀ. `constant`: n-vector. If it is 1 at the position dofs of a surface, these are the
  /// constraints on the surface translated by -by. Far from the origin, solving the translated
  /// problem avoids the loss of digits due to large coordinates.
  ConstraintSet translated(const VecX& constant, const Vec3& by) const;

  /// Largest violation of an equation by the dofs q (n×3): |left-hand side - right-hand side|.
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
