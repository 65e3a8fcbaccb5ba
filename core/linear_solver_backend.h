// A factor that another program part keeps in place of SparseCholesky.
#pragma once

#include <functional>
#include <memory>

#include "batten/core/eigen.h"

namespace batten {

/// Factors a symmetric positive definite matrix and solves with it, where SparseCholesky does not:
/// on several machines (docs/distributed.md).
class LinearSolverBackend {
 public:
  virtual ~LinearSolverBackend() = default;
  /// A: the lower triangle. Throws NoSolutionError when A is not positive definite.
  virtual void factorize(const SparseMatrix& A) = 0;
  /// b, n×k, becomes x with A x = b.
  virtual void solve_in_place(Eigen::Ref<MatX> b) const = 0;
};

/// Makes one for each system; empty: SparseCholesky.
using BackendFactory = std::function<std::unique_ptr<LinearSolverBackend>()>;

}  // namespace batten
