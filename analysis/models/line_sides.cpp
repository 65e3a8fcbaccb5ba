// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/line_sides.h"

#include <map>

#include "batten/core/errors.h"

namespace batten {

void LineRotation::at_vertex(int k, double factor, CoupledEntries& row) const {
  ConstraintEntries across, along;
  side_.add_across(k, 1, across);
  side_.add_along(k, 1, along);
  add(across, along, factor, row);
}

void LineRotation::at_edge_midpoint(int k, double factor, CoupledEntries& row) const {
  ConstraintEntries across, along;
  side_.add_across_middle(k, 1, across);
  side_.add_along_middle(k, 1, along);
  add(across, along, factor, row);
}

void LineRotation::at_fraction(double f, double factor, CoupledEntries& row) const {
  ConstraintEntries across, along;
  side_.add_at(f, 1, 0, 0, across);
  side_.add_at(f, 0, 1, 0, along);
  add(across, along, factor, row);
}

void LineRotation::add(const ConstraintEntries& across, const ConstraintEntries& along,
                       double factor, CoupledEntries& row) const {
  const Vec3 y = value_of(across, shape_), x_t = value_of(along, shape_);
  const double speed = x_t.norm();
  const Vec3 tau = x_t / speed, n = y.cross(x_t).normalized();
  const double a = y.dot(tau.cross(n)), b = y.dot(tau);
  constexpr double singular = 1e-9;
  if (!n.allFinite() || !(std::abs(a) > singular * y.norm()))
    throw InputError("the surface is singular along a curve of the shell: it has no normal there");
  for (const auto& e : across) row.push_back({e.dof, -factor * e.coefficient / a * n});
  for (const auto& e : along) row.push_back({e.dof, factor * e.coefficient * b / (speed * a) * n});
}

std::vector<Vec3> unit_directions(const std::string& support, const std::vector<Vec3>& directions) {
  if (directions.empty())
    throw InputError("support '" + support + "' constrains nothing: expected directions");
  std::vector<Vec3> units;
  for (const Vec3& direction : directions) {
    if (!direction.allFinite() || direction.isZero(0))
      throw InputError("support '" + support + "' has a direction of length zero");
    units.push_back(direction.normalized());
  }
  return units;
}

void add_summed(const std::string& name, const CoupledEntries& entries, double value,
                ConstraintSet& set) {
  std::map<int, Vec3> sum;
  for (const auto& e : entries) sum.try_emplace(e.dof, Vec3::Zero()).first->second += e.coefficient;
  CoupledEntries row;
  for (const auto& [dof, coefficient] : sum) row.push_back({dof, coefficient});
  set.add_coupled(name, std::move(row), value);
}

}  // namespace batten
