// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/block_reduction.h"

#include <algorithm>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"

namespace batten {

BlockReduction::BlockReduction(const ConstraintSet& constraints) {
  const AffineReduction reduction(constraints);
  coupled_ = reduction.coupled();
  d0_ = reduction.d0().reshaped();
  const SparseMatrix& D = reduction.D();
  const int copies = coupled_ ? 1 : 3;
  const int rows = static_cast<int>(D.rows()), columns = static_cast<int>(D.cols());
  std::vector<Triplet> entries;
  entries.reserve(copies * static_cast<size_t>(D.nonZeros()));
  for (int c = 0; c < copies; ++c) {
    for (int j = 0; j < columns; ++j)
      for (SparseMatrix::InnerIterator it(D, j); it; ++it)
        entries.emplace_back(c * rows + static_cast<int>(it.row()), c * columns + j, it.value());
    for (const int dof : reduction.free_dofs()) free_rows_.push_back(c * rows + dof);
  }
  D_.resize(copies * rows, copies * columns);
  D_.setFromTriplets(entries.begin(), entries.end());
}

BlockReduction::BlockReduction(const BlockReduction& all, const Points& start,
                               const std::vector<char>& frozen)
    : coupled_(all.coupled_) {
  const int n = all.dof_count();
  std::vector<char> moves(all.free_count(), 1);
  for (int row = 0; row < 3 * n; ++row)
    if (frozen[row % n])
      for (RowMatrix::InnerIterator it(all.D_, row); it; ++it) moves[it.col()] = 0;
  std::vector<int> number(moves.size());
  for (int f = 0; f < all.free_count(); ++f) {
    number[f] = isize(free_rows_);
    if (moves[f]) free_rows_.push_back(all.free_rows_[f]);
  }
  std::vector<Triplet> entries;
  for (int row = 0; row < 3 * n; ++row)
    for (RowMatrix::InnerIterator it(all.D_, row); it; ++it)
      if (moves[it.col()]) entries.emplace_back(row, number[it.col()], it.value());
  D_.resize(3 * n, isize(free_rows_));
  D_.setFromTriplets(entries.begin(), entries.end());
  const Points nearest = all.expand(all.free_part(start));
  d0_ = nearest.reshaped() - D_ * free_part(nearest);
}

VecX BlockReduction::free_part(const Points& x) const {
  VecX y(free_count());
  for (int f = 0; f < free_count(); ++f)
    y[f] = x(free_rows_[f] % dof_count(), free_rows_[f] / dof_count());
  return y;
}

Points BlockReduction::expand(const VecX& y) const {
  const VecX x = D_ * y + d0_;
  return x.reshaped(dof_count(), 3);
}

namespace {

// Smallest number of dofs of a constraint that is imposed by multipliers; constraints along element
// edges have up to eight.
constexpr size_t kMany = 9;
// Stiffness of the penalty over that of the unknowns that it acts on.
constexpr double kTimes = 1e4;

ConstraintSet part_of(const ConstraintSet& constraints, bool many) {
  ConstraintSet part(constraints.dof_count());
  const bool all_few = constraints.coupled();
  for (const auto& row : constraints.constraints())
    if ((row.entries.size() >= kMany && !all_few) == many)
      part.add(constraints.names()[row.name], row.entries, row.value);
  if (!many)
    for (const auto& row : constraints.coupled_constraints())
      part.add_coupled(constraints.names()[row.name], row.entries, row.value);
  return part;
}

}  // namespace

ConstraintSet AugmentedLagrangianConstraints::dense_rows(const ConstraintSet& constraints) {
  return part_of(constraints, true);
}

ConstraintSet AugmentedLagrangianConstraints::sparse_rows(const ConstraintSet& constraints) {
  return part_of(constraints, false);
}

AugmentedLagrangianConstraints::AugmentedLagrangianConstraints(const ConstraintSet& constraints,
                                                               const BlockReduction& reduction,
                                                               const Surface& surface)
    : reduction_(reduction), values_(isize(constraints.constraints()), 3) {
  const int n = reduction.dof_count(), count = isize(constraints.constraints());
  rows_.resize(count, n);
  if (count == 0) return;
  std::vector<Triplet> entries;
  for (int r = 0; r < count; ++r) {
    for (const auto& e : constraints.constraints()[r].entries)
      entries.emplace_back(r, e.dof, e.coefficient);
    values_.row(r) = constraints.constraints()[r].value;
  }
  rows_.setFromTriplets(entries.begin(), entries.end());
  const int each = reduction.free_count() / 3;
  const SparseMatrix D = SparseMatrix(reduction.D()).topLeftCorner(n, each);
  B_ = rows_ * D;
  entries.clear();
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < count; ++r)
      for (RowMatrix::InnerIterator it(B_, r); it; ++it)
        entries.emplace_back(c * count + r, c * each + static_cast<int>(it.col()), it.value());
  block_rows_.resize(3 * count, 3 * each);
  block_rows_.setFromTriplets(entries.begin(), entries.end());

  // Bending energy of whole triangles: one of which the trim leaves little inside would otherwise
  // move too easily.
  const SparseMatrix K =
      SurfaceAssembler(surface.mesh(), surface.kind()).stiffness(SurfaceStiffness::isotropic(0, 1));
  SparseMatrix N = D.transpose() * SparseMatrix(K.selfadjointView<Eigen::Lower>()) * D;
  constexpr double least = 1e-10;  // fraction of the diagonal: keeps the matrix definite where
                                   // nothing else does
  const VecX diagonal = N.diagonal();
  weights_ = penalty_weights(B_, diagonal, kTimes);
  N += SparseMatrix(B_.transpose() * weights_.asDiagonal() * B_);
  N += SparseMatrix((least * diagonal).asDiagonal());
  factor_.analyze(N);
  if (!factor_.factorize(N)) throw NoSolutionError(factor_.message());
}

void AugmentedLagrangianConstraints::project_onto(Points& x) const {
  if (empty()) return;
  const MatX residual = rows_ * x - values_;
  const MatX zero = MatX::Zero(B_.cols(), 3);
  const MatX correction = solve_augmented_lagrangian(factor_, zero, B_, weights_, residual);
  const VecX step = reduction_.D() * correction.reshaped();
  x += step.reshaped(x.rows(), 3);
}

VecX penalty_weights(const RowMatrix& B, const VecX& diagonal, double times) {
  VecX weights = VecX::Zero(B.rows());
  for (int r = 0; r < B.rows(); ++r) {
    double softness = 0;
    for (RowMatrix::InnerIterator it(B, r); it; ++it)
      softness += it.value() * it.value() / diagonal[it.col()];
    if (softness > 0) weights[r] = times / softness;
  }
  return weights;
}

MatX solve_augmented_lagrangian(const SparseCholesky& factor, const MatX& g, const RowMatrix& B,
                                const VecX& weights, const MatX& residual) {
  if (B.rows() == 0) return -factor.solve(g);
  constexpr int most = 12;
  constexpr double enough = 1e-13;
  MatX force = MatX::Zero(B.rows(), g.cols());
  if (residual.rows() > 0) force = weights.asDiagonal() * residual;
  MatX s;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most; ++k) {
    s = -factor.solve(g + B.transpose() * force);
    MatX left = B * s;
    if (residual.rows() > 0) left += residual;
    const double largest = left.cwiseAbs().maxCoeff();
    // Stops at the tolerance, or when rounding prevents further progress.
    if (!(largest > enough * s.cwiseAbs().maxCoeff()) || !(largest < 0.5 * last)) break;
    last = largest;
    force += weights.asDiagonal() * left;
  }
  return s;
}

void check_fairing_input(const Surface& start, const ConstraintSet& constraints) {
  const int n = start.dof_map().count();
  if (constraints.dof_count() != n)
    throw InputError("found constraints on " + std::to_string(constraints.dof_count()) +
                     " dofs, expected " + std::to_string(n) + " of the surface");
  if (!start.dofs().allFinite()) throw InputError("a dof of the surface is not finite");
  if (!(start.area() > 0)) throw InputError("a surface of area zero cannot be faired");
}

}  // namespace batten
