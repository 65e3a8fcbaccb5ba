#include "batten/analysis/models/shell_springs.h"

#include <algorithm>
#include <map>

#include "batten/core/isize.h"

namespace batten {

void ShellSprings::add(const std::string& name, const Entries& entries, double stiffness,
                       double value) {
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
  springs_.push_back({known, std::move(once), stiffness, value});
}

SparseMatrix ShellSprings::stiffness() const {
  // Many springs lie in one triangle, or pair of triangles, and have the same dofs.
  std::map<std::vector<int>, MatX> blocks;
  for (const Spring& spring : springs_) {
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
