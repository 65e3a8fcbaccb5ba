// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/rotation_field.h"

#include <algorithm>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"

namespace batten {

RotationField::RotationField(const DeformSystem& system, long handles)
    : reduction_(system.rotations, AffineReduction::RhsMode::Deferred),
      handle_rotations_(MatX::Zero(handles, 3)),
      rhs_(MatX::Zero(static_cast<long>(system.rotated_by.size()), 3)) {}

// Weights: 1 on the own vertices of a handle, 0 on all other constrained ones, harmonic in between.
void RotationField::solve_weights(const DeformSystem& system, const TriangleMesh& mesh) {
  const long handles = handle_rotations_.rows();
  MatX indicator = MatX::Zero(static_cast<long>(system.rotated_by.size()), handles);
  for (size_t r = 0; r < system.rotated_by.size(); ++r)
    if (system.rotated_by[r] >= 0) indicator(static_cast<long>(r), system.rotated_by[r]) = 1;
  weights_ = reduction_.particular_solution(indicator);
  if (reduction_.free_count() == 0 || handles == 0) return;
  const SparseMatrix L = laplacian_of(system, mesh);
  const SparseMatrix reduced = reduction_.reduce(L);
  SparseCholesky factor;
  factor.analyze(reduced);
  if (!factor.factorize(reduced)) throw NoSolutionError("the rotation field: " + factor.message());
  MatX load = reduction_.D().transpose() * MatX(L.selfadjointView<Eigen::Lower>() * -weights_);
  factor.solve_in_place(load);
  weights_.noalias() += reduction_.D() * load;
}

void RotationField::evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs) {
  for (size_t h = 0; h < edit.handles.size(); ++h)
    handle_rotations_.row(static_cast<long>(h)) = edit.handles[h].rotation_vector;
  if (reduction_.redundant_count() > 0) {  // only redundant rows can be contradicted
    for (size_t k = 0; k < system.rotated_by.size(); ++k)
      if (const int h = system.rotated_by[k]; h >= 0)
        rhs_.row(static_cast<long>(k)) = handle_rotations_.row(h);
    try {
      reduction_.set_rhs(rhs_);
    } catch (const ConflictError& e) {
      std::vector<ConflictError::Conflict> conflicts = e.conflicts();
      for (auto& c : conflicts) {
        c.amount *= 180 / std::numbers::pi;
        c.unit = " degrees of rotation";
      }
      throw ConflictError(std::move(conflicts));
    }
  }
  // Explicit loop: Eigen's product may allocate.
  parallel_chunks(logs.rows(), [&](long first, long last) {
    for (int c = 0; c < 3; ++c) {
      auto column = logs.col(c).segment(first, last - first);
      column.setZero();
      for (long h = 0; h < handle_rotations_.rows(); ++h)
        if (handle_rotations_(h, c) != 0)
          column += handle_rotations_(h, c) * weights_.col(h).segment(first, last - first);
    }
  });
}

void RotationField::factorize_free(const DeformSystem& system, const TriangleMesh& mesh,
                                   std::vector<int> prescribed) {
  if (prescribed == prescribed_ && !index_.empty()) return;
  index_.assign(static_cast<size_t>(reduction_.free_count()), 0);  // of the others: below
  for (int k = 0; k < isize(prescribed); ++k) index_[prescribed[k]] = -1 - k;
  int open = 0;
  for (int& index : index_)
    if (index >= 0) index = open++;
  const SparseMatrix reduced = reduction_.reduce(laplacian_of(system, mesh));  // lower triangle
  std::vector<Triplet> entries, coupled;
  for (int c = 0; c < reduced.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced, c); e; ++e) {
      const int i = index_[e.row()], j = index_[c];
      if (i >= 0 && j >= 0) entries.emplace_back(i, j, e.value());
      if (i >= 0 && j < 0) coupled.emplace_back(i, -1 - j, -e.value());
      if (i < 0 && j >= 0) coupled.emplace_back(j, -1 - i, -e.value());
    }
  coupling_ = SparseMatrix(open, isize(prescribed));
  coupling_.setFromTriplets(coupled.begin(), coupled.end());
  change_ = MatX::Zero(isize(prescribed), 3);
  load_ = MatX::Zero(open, 3);
  prescribed_ = std::move(prescribed);
  if (open == 0) return;
  SparseMatrix rest(open, open);
  rest.setFromTriplets(entries.begin(), entries.end());
  free_factor_.analyze(rest);
  if (free_factor_.factorize(rest)) return;
  index_.clear();  // invalid
  throw NoSolutionError("the rotation field: " + free_factor_.message());
}

void RotationField::prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                              const std::vector<std::pair<int, Vec3>>& given, Points& logs) {
  if (unknown_of_dof_.empty()) {
    unknown_of_dof_.assign(static_cast<size_t>(logs.rows()), -1);
    const SparseMatrix& D = reduction_.D();
    for (int c = 0; c < D.cols(); ++c)
      for (SparseMatrix::InnerIterator e(D, c); e; ++e) unknown_of_dof_[e.row()] = c;
  }
  std::vector<int> prescribed;
  for (const auto& [dof, log] : given)
    if (unknown_of_dof_[dof] >= 0) prescribed.push_back(unknown_of_dof_[dof]);
  factorize_free(system, mesh, sorted_unique(std::move(prescribed)));
  std::vector<char> is_set(prescribed_.size(), 0);  // the first value of an unknown applies
  for (const auto& [dof, log] : given) {
    if (unknown_of_dof_[dof] < 0) continue;
    const int k = -1 - index_[unknown_of_dof_[dof]];
    if (std::exchange(is_set[k], 1) == 0) change_.row(k) = log.transpose() - logs.row(dof);
  }
  load_.noalias() = coupling_ * change_;
  if (load_.rows() > 0) free_factor_.solve_in_place(load_);
  parallel_chunks(logs.rows(), [&](long first, long last) {
    for (long dof = first; dof < last; ++dof)
      if (const int c = unknown_of_dof_[dof]; c >= 0)
        logs.row(dof) += index_[c] >= 0 ? load_.row(index_[c]) : change_.row(-1 - index_[c]);
  });
}

}  // namespace batten
