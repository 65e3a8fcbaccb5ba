// The rotation of a shell about a line, as rows on the dofs of one side. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {

using CoupledEntries = std::vector<ConstraintSet::CoupledEntry>;

// ω of shell_ties.h, a form of the displacement's dofs; each function adds factor · ω to a row.
class LineRotation {
 public:
  LineRotation(const JoinEdge& side, const Points& shape) : side_(side), shape_(shape) {}

  void at_vertex(int k, double factor, CoupledEntries& row) const;
  void at_edge_midpoint(int k, double factor, CoupledEntries& row) const;  // of the k-th edge
  void at_fraction(double f, double factor, CoupledEntries& row) const;

 private:
  Vec3 evaluate(const ConstraintEntries& entries) const;
  void add(const ConstraintEntries& across, const ConstraintEntries& along, double factor,
           CoupledEntries& row) const;
  const JoinEdge& side_;
  const Points& shape_;
};

// The part of a place along a direction, as a row.
inline CoupledEntries along(const Vec3& direction, const ConstraintEntries& position) {
  CoupledEntries row;
  for (const auto& e : position) row.push_back({e.dof, e.coefficient * direction});
  return row;
}

// Directions of a support at length 1. Throws InputError: none, or one of length zero.
std::vector<Vec3> unit_directions(const std::string& support, const std::vector<Vec3>& directions);

// Adds a row whose entries may name a dof more than once.
void add_summed(const std::string& name, const CoupledEntries& entries, double value,
                ConstraintSet& set);

}  // namespace batten
