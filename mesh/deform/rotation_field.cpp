#include "batten/mesh/deform/rotation_field.h"

#include <algorithm>
#include <numbers>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"

namespace batten {

RotationField::RotationField(const DeformSystem& system, long handles)
    : reduction_(system.rotations, AffineReduction::Values::Later),
      turns_(MatX::Zero(handles, 3)),
      right_(MatX::Zero(static_cast<long>(system.turned_by.size()), 3)) {}

// 1 on a handle's own vertices, 0 on everything else that is held, harmonic between.
void RotationField::solve_weights(const DeformSystem& system, const TriangleMesh& mesh) {
  const long handles = turns_.rows();
  MatX indicator = MatX::Zero(static_cast<long>(system.turned_by.size()), handles);
  for (size_t r = 0; r < system.turned_by.size(); ++r)
    if (system.turned_by[r] >= 0) indicator(static_cast<long>(r), system.turned_by[r]) = 1;
  weights_ = reduction_.particular(indicator);
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
    turns_.row(static_cast<long>(h)) = edit.handles[h].turn;
  if (reduction_.dropped_rows() > 0) {  // only they can contradict
    for (size_t k = 0; k < system.turned_by.size(); ++k)
      if (const int h = system.turned_by[k]; h >= 0)
        right_.row(static_cast<long>(k)) = turns_.row(h);
    try {
      reduction_.set_right(right_);
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
  in_chunks(logs.rows(), [&](long first, long last) {
    for (int c = 0; c < 3; ++c) {
      auto column = logs.col(c).segment(first, last - first);
      column.setZero();
      for (long h = 0; h < turns_.rows(); ++h)
        if (turns_(h, c) != 0)
          column += turns_(h, c) * weights_.col(h).segment(first, last - first);
    }
  });
}

void RotationField::factor_around(const DeformSystem& system, const TriangleMesh& mesh,
                                  std::vector<char> told) {
  if (told == told_) return;
  told_.clear();  // until the factor is there
  number_.assign(told.size(), -1);
  int open = 0;
  for (size_t c = 0; c < told.size(); ++c)
    if (!told[c]) number_[c] = open++;
  reduced_ = reduction_.reduce(laplacian_of(system, mesh));
  std::vector<Triplet> entries;
  for (int c = 0; c < reduced_.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced_, c); e; ++e)
      if (number_[e.row()] >= 0 && number_[c] >= 0)
        entries.emplace_back(number_[e.row()], number_[c], e.value());
  if (open > 0) {
    SparseMatrix rest(open, open);
    rest.setFromTriplets(entries.begin(), entries.end());
    around_.analyze(rest);
    if (!around_.factorize(rest))
      throw NoSolutionError("the field of rotations: " + around_.message());
  }
  told_ = std::move(told);
}

void RotationField::pass_through(const DeformSystem& system, const TriangleMesh& mesh,
                                 const std::vector<std::pair<int, Vec3>>& given, Points& logs) {
  const SparseMatrix& D = reduction_.D();
  const RowMatrix by_rows = D;
  MatX change = MatX::Zero(D.cols(), 3);
  std::vector<char> told(D.cols(), 0);
  for (const auto& [dof, log] : given)
    for (RowMatrix::InnerIterator e(by_rows, dof); e; ++e) {  // one at most: turns are only equal
      if (told[e.col()]) continue;
      told[e.col()] = 1;
      change.row(e.col()) = log.transpose() - logs.row(dof);
    }
  factor_around(system, mesh, std::move(told));
  const auto open = std::count(told_.begin(), told_.end(), 0);
  MatX load = MatX::Zero(open, 3);
  for (int c = 0; c < reduced_.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced_, c); e; ++e) {
      const int i = number_[e.row()], j = number_[c];
      if (i >= 0 && j < 0) load.row(i) -= e.value() * change.row(c);
      if (i < 0 && j >= 0) load.row(j) -= e.value() * change.row(e.row());
    }
  if (open > 0) around_.solve_in_place(load);
  for (int c = 0; c < D.cols(); ++c)
    if (number_[c] >= 0) change.row(c) = load.row(number_[c]);
  logs += D * change;
}

}  // namespace batten
