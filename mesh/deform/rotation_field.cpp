#include "batten/mesh/deform/rotation_field.h"

#include <algorithm>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"

namespace batten {

RotationField::RotationField(const DeformSystem& system, long handles)
    : reduction_(system.rotations, AffineReduction::RhsMode::Deferred),
      handle_rotations_(MatX::Zero(handles, 3)),
      rhs_(MatX::Zero(static_cast<long>(system.rotated_by.size()), 3)) {}

// 1 on a handle's own vertices, 0 on everything else that is held, harmonic between.
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
  if (!factor.factorize(reduced))
    throw NoSolutionError("the field of rotations: " + factor.message());
  MatX load = reduction_.D().transpose() * MatX(L.selfadjointView<Eigen::Lower>() * -weights_);
  factor.solve_in_place(load);
  weights_.noalias() += reduction_.D() * load;
}

void RotationField::evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs) {
  for (size_t h = 0; h < edit.handles.size(); ++h)
    handle_rotations_.row(static_cast<long>(h)) = edit.handles[h].rotation_vector;
  if (reduction_.redundant_count() > 0) {  // only they can contradict
    for (size_t k = 0; k < system.rotated_by.size(); ++k)
      if (const int h = system.rotated_by[k]; h >= 0)
        rhs_.row(static_cast<long>(k)) = handle_rotations_.row(h);
    try {
      reduction_.set_rhs(rhs_);
    } catch (const ConflictError& e) {
      std::vector<ConflictError::Conflict> conflicts = e.conflicts();
      for (auto& c : conflicts) {
        c.amount *= 360 / std::numbers::pi;  // logarithms are half the angle
        c.unit = " degrees of turn";
      }
      throw ConflictError(std::move(conflicts));
    }
  }
  // By hand: Eigen's product may ask for memory.
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
                                   std::vector<char> prescribed) {
  if (prescribed == prescribed_) return;
  prescribed_.clear();  // until the factor is there
  free_index_.assign(prescribed.size(), -1);
  int open = 0;
  for (size_t c = 0; c < prescribed.size(); ++c)
    if (!prescribed[c]) free_index_[c] = open++;
  reduced_ = reduction_.reduce(laplacian_of(system, mesh));
  std::vector<Triplet> entries;
  for (int c = 0; c < reduced_.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced_, c); e; ++e)
      if (free_index_[e.row()] >= 0 && free_index_[c] >= 0)
        entries.emplace_back(free_index_[e.row()], free_index_[c], e.value());
  if (open > 0) {
    SparseMatrix rest(open, open);
    rest.setFromTriplets(entries.begin(), entries.end());
    free_factor_.analyze(rest);
    if (!free_factor_.factorize(rest))
      throw NoSolutionError("the field of rotations: " + free_factor_.message());
  }
  prescribed_ = std::move(prescribed);
}

void RotationField::prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                              const std::vector<std::pair<int, Vec3>>& given, Points& logs) {
  const SparseMatrix& D = reduction_.D();
  const RowMatrix by_rows = D;
  MatX change = MatX::Zero(D.cols(), 3);
  std::vector<char> prescribed(D.cols(), 0);
  for (const auto& [dof, log] : given)
    for (RowMatrix::InnerIterator e(by_rows, dof); e; ++e) {  // one at most: turns are only equal
      if (prescribed[e.col()]) continue;
      prescribed[e.col()] = 1;
      change.row(e.col()) = log.transpose() - logs.row(dof);
    }
  factorize_free(system, mesh, std::move(prescribed));
  const auto open = std::count(prescribed_.begin(), prescribed_.end(), 0);
  MatX load = MatX::Zero(open, 3);
  for (int c = 0; c < reduced_.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced_, c); e; ++e) {
      const int i = free_index_[e.row()], j = free_index_[c];
      if (i >= 0 && j < 0) load.row(i) -= e.value() * change.row(c);
      if (i < 0 && j >= 0) load.row(j) -= e.value() * change.row(e.row());
    }
  if (open > 0) free_factor_.solve_in_place(load);
  for (int c = 0; c < D.cols(); ++c)
    if (free_index_[c] >= 0) change.row(c) = load.row(free_index_[c]);
  logs += D * change;
}

}  // namespace batten
