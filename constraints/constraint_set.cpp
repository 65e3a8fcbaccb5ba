// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/constraint_set.h"

#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void check_dof(const std::string& name, int dof, int count) {
  if (dof < 0 || dof >= count)
    throw InputError("constraint '" + name + "' names dof " + std::to_string(dof) + " of " +
                     std::to_string(count));
}

}  // namespace

int ConstraintSet::name_index(const std::string& name) {
  // Equations of one constraint are added consecutively, so search from the end.
  for (auto i = isize(names_) - 1; i >= 0; --i)
    if (names_[i] == name) return i;
  names_.push_back(name);
  return isize(names_) - 1;
}

void ConstraintSet::fix(const std::string& name, int dof, const Vec3& value) {
  add(name, {{dof, 1.0}}, value);
}

void ConstraintSet::add(const std::string& name, std::vector<Entry> entries, const Vec3& value) {
  bool finite = value.allFinite();
  for (const auto& e : entries) {
    check_dof(name, e.dof, dof_count_);
    finite = finite && std::isfinite(e.coefficient);
  }
  if (!finite) throw InputError("constraint '" + name + "': a value is not finite");
  constraints_.push_back({name_index(name), std::move(entries), value});
}

void ConstraintSet::add_coupled(const std::string& name, std::vector<CoupledEntry> entries,
                                double value) {
  bool finite = std::isfinite(value);
  for (const auto& e : entries) {
    check_dof(name, e.dof, dof_count_);
    finite = finite && e.coefficient.allFinite();
  }
  if (!finite) throw InputError("constraint '" + name + "': a value is not finite");
  coupled_constraints_.push_back({name_index(name), std::move(entries), value});
}

ConstraintSet ConstraintSet::translated(const VecX& constant, const Vec3& by) const {
  ConstraintSet set = *this;
  for (Constraint& row : set.constraints_)
    for (const Entry& e : row.entries) row.value -= e.coefficient * constant[e.dof] * by;
  for (CoupledConstraint& row : set.coupled_constraints_)
    for (const CoupledEntry& e : row.entries) row.value -= constant[e.dof] * e.coefficient.dot(by);
  return set;
}

double ConstraintSet::max_residual(const Points& q) const {
  double worst = 0;
  for (const auto& row : constraints_) {
    Vec3 sum = -row.value;
    for (const auto& e : row.entries) sum += e.coefficient * q.row(e.dof).transpose();
    for (const double x : sum)
      if (!(std::abs(x) <= worst)) worst = std::abs(x);  // NaN counts as the largest
  }
  for (const auto& row : coupled_constraints_) {
    double sum = -row.value;
    for (const auto& e : row.entries) sum += q.row(e.dof).dot(e.coefficient);
    if (!(std::abs(sum) <= worst)) worst = std::abs(sum);
  }
  return worst;
}

}  // namespace batten
