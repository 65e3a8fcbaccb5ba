// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_ties.h"

#include <algorithm>
#include <map>

#include "batten/analysis/models/line_sides.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void tie_rotations(const std::string& name, const JoinEdge& a, const JoinEdge& b,
                   const Points& shape, ConstraintSet& set) {
  const LineRotation of_a(a, shape), of_b(b, shape);
  for (int k = 0; k < a.count(); ++k) {
    CoupledEntries row;
    of_a.at_vertex(k, 1, row);
    of_b.at_vertex(k, -1, row);
    add_summed(name, row, 0, set);
  }
  for (int k = 0; k + 1 < a.count(); ++k) {
    CoupledEntries row;
    of_a.at_edge_midpoint(k, 1, row);
    of_b.at_edge_midpoint(k, -1, row);
    add_summed(name, row, 0, set);
  }
}

// Adds the springs along a curve. stiffness(f): that of the stiffer side.
template <class Stiffness>
void add_springs(const std::string& name, const JoinEdge& a, const JoinEdge& b, const Points& shape,
                 bool hinge, const Stiffness& stiffness, ShellSprings& springs) {
  const LineRotation of_a(a, shape), of_b(b, shape);
  for_each_line_point(a, b, [&](double f, double dl) {
    const SpringStiffness k = stiffness(f);
    ConstraintEntries apart;
    a.add_at(f, 0, 0, 1, apart);
    b.add_at(f, 0, 0, -1, apart);
    for (int c = 0; c < 3; ++c)
      springs.add(name, along(Vec3::Unit(c), apart), k.displacement * dl, 0);
    if (hinge) return;
    CoupledEntries row;
    of_a.at_fraction(f, 1, row);
    of_b.at_fraction(f, -1, row);
    springs.add(name, row, k.rotation * dl, 0);
  });
}

}  // namespace

ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const std::vector<ShellSection>& sections,
                     const std::vector<std::string>& hinges) {
  for (const std::string& hinge : hinges)
    if (model.model_line(hinge).sides.size() < 2)
      throw InputError("hinge '" + hinge + "' is a free edge with one face, expected two faces");
  const int count = static_cast<int>(shape.rows());
  ShellTies ties{ConstraintSet(count, ConstraintSet::Kind::Coupled), ShellSprings(count)};
  LineSides sides(model);
  const Surface surface = model.surface(shape);
  for (const JoinLine& line : model.shared_lines()) {
    const std::string name = "joined curve " + line.name;
    const bool hinge = std::find(hinges.begin(), hinges.end(), line.name) != hinges.end();
    const JoinEdge a = sides(line.sides[0]), b = sides(line.sides[1]);
    if (!a.embedded() && !b.embedded()) {
      add_line_ties(sides.regions(), sides.dof_offsets(), line, ties.constraints);
      if (!hinge) tie_rotations(name, a, b, shape, ties.constraints);
      continue;
    }
    const auto of_side = [&](int s, const JoinEdge& side, double f) {
      const int r = line.sides[s].region;
      return SpringStiffness(surface, sections[sections.size() == 1 ? 0 : r],
                             model.first_triangle(r) + side.where(f).triangle);
    };
    add_springs(
        name, a, b, shape, hinge,
        [&](double f) {
          SpringStiffness k = of_side(0, a, f);
          const SpringStiffness other = of_side(1, b, f);
          k.displacement = std::max(k.displacement, other.displacement);
          k.rotation = std::max(k.rotation, other.rotation);
          return k;
        },
        ties.springs);
  }
  return ties;
}

void ShellSprings::add(const std::string& name, const Entries& entries, double stiffness,
                       double value, Kind kind) {
  poll_every<4096>(isize(springs_));
  auto known = isize(names_) - 1;
  while (known >= 0 && names_[known] != name) --known;
  if (known < 0) {
    known = isize(names_);
    names_.push_back(name);
  }
  std::map<int, Vec3> sum;
  for (const auto& e : entries) sum.try_emplace(e.dof, Vec3::Zero()).first->second += e.coefficient;
  Entries once;
  for (const auto& [dof, coefficient] : sum) once.push_back({dof, coefficient});
  springs_.push_back({known, std::move(once), stiffness, value, kind});
}

SparseMatrix ShellSprings::stiffness() const {
  // Many springs lie in the same triangle, or pair of triangles, and have the same dofs.
  std::map<std::vector<int>, MatX> blocks;
  long next = 0;
  for (const Spring& spring : springs_) {
    poll_every<4096>(next++);
    std::vector<int> dofs;
    VecX row(3 * static_cast<long>(spring.entries.size()));
    for (const auto& e : spring.entries) {
      row.segment<3>(3 * isize(dofs)) = e.coefficient;
      dofs.push_back(e.dof);
    }
    MatX& block =
        blocks.try_emplace(std::move(dofs), MatX::Zero(row.size(), row.size())).first->second;
    block.noalias() += spring.stiffness * row * row.transpose();
  }
  std::vector<Triplet> entries;
  for (const auto& [dofs, block] : blocks)
    for (int i = 0; i < block.rows(); ++i)
      for (int j = 0; j < block.cols(); ++j) {
        const int row = i % 3 * dof_count_ + dofs[i / 3], column = j % 3 * dof_count_ + dofs[j / 3];
        if (row >= column && block(i, j) != 0) entries.emplace_back(row, column, block(i, j));
      }
  SparseMatrix K(3L * dof_count_, 3L * dof_count_);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

Points ShellSprings::load() const {
  Points F = Points::Zero(dof_count_, 3);
  for (const Spring& spring : springs_)
    for (const auto& e : spring.entries)
      F.row(e.dof) += spring.stiffness * spring.value * e.coefficient.transpose();
  return F;
}

double ShellSprings::pull(const Spring& spring, const Points& q) {
  double stretch = -spring.value;
  for (const auto& e : spring.entries) stretch += q.row(e.dof).dot(e.coefficient);
  return -spring.stiffness * stretch;
}

}  // namespace batten
