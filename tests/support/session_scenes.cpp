// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/session_scenes.h"

#include <Eigen/Eigenvalues>

#include "batten/constraints/affine_reduction.h"

namespace batten_test {

Modes::Modes(const ConstraintSet& constraints, const SparseMatrix& K, const SparseMatrix& M) {
  const AffineReduction reduction(constraints);
  free = reduction.free_dofs();
  mass = MatX(reduction.reduce(M)).selfadjointView<Eigen::Lower>();
  const MatX stiffness = MatX(reduction.reduce(K)).selfadjointView<Eigen::Lower>();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> solver(stiffness, mass);
  lambda = solver.eigenvalues();
  phi = solver.eigenvectors();
}

MatX Modes::of(const Points& x) const { return phi.transpose() * mass * x(free, Eigen::all); }

}  // namespace batten_test
