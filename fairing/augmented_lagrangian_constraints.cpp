#include "batten/fairing/augmented_lagrangian_constraints.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"

namespace batten {
namespace {

// Rows along element edges have up to eight.
constexpr size_t kMany = 9;
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

  // Whole triangles: where a line leaves little of one inside, that would move too easily.
  const SparseMatrix K =
      SurfaceAssembler(surface.mesh(), surface.kind()).stiffness(SurfaceStiffness::isotropic(0, 1));
  SparseMatrix N = D.transpose() * SparseMatrix(K.selfadjointView<Eigen::Lower>()) * D;
  constexpr double least = 1e-10;  // of the diagonal: keeps it definite where nothing else does
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
    // Rounding leaves a floor.
    if (!(largest > enough * s.cwiseAbs().maxCoeff()) || !(largest < 0.5 * last)) break;
    last = largest;
    force += weights.asDiagonal() * left;
  }
  return s;
}

}  // namespace batten
