// SPDX-License-Identifier: MPL-2.0
// Interface of linear solvers, and the choice of their back end at run time.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/solvers/supernodal_factor.h"

namespace batten {

/// Solver of sparse symmetric positive definite linear systems. Back ends: SparseCholesky (default)
/// on one machine; DistributedSolver on several MPI processes (docs/distributed.md).
class LinearSolverBackend {
 public:
  virtual ~LinearSolverBackend() = default;

  /// Whether factorize() accepts the matrix A without a new symbolic analysis. Back ends without
  /// symbolic analysis accept every matrix.
  virtual bool has_pattern_of(const SparseMatrix& A) const;
  /// Performs the symbolic analysis of the matrix A. `order`: elimination order of the unknowns;
  /// empty: automatic. Back ends that choose their own order ignore `order`.
  virtual void analyze(const SparseMatrix& A, const std::vector<int>& order);
  /// Factors the symmetric matrix A, of which only the lower triangle is stored. Returns false if A
  /// is not positive definite.
  virtual bool factorize(const SparseMatrix& A) = 0;
  /// Reason why the last factorize() failed; empty if it succeeded.
  virtual const std::string& message() const = 0;
  /// Solves A x = b in place for the last factorized n×n matrix A: b (n×k) is overwritten by x.
  virtual void solve_in_place(Eigen::Ref<MatX> b) const = 0;
};

/// Function that creates a linear solver; called once for each linear system. If the function is
/// empty, SparseCholesky is used.
using BackendFactory = std::function<std::unique_ptr<LinearSolverBackend>()>;

// Libraries of SparseCholesky.

/// Library on which a SparseCholesky is based.
enum class CholeskyLibrary {
  Cholmod,  ///< CHOLMOD orders (AMD, METIS), Batten computes the factor; not in every build
  Eigen     ///< Eigen orders (AMD) and computes the factor; in every build
};

/// Libraries for sparse Cholesky factorization that this build contains, the default first: CHOLMOD
/// if available, otherwise Eigen.
std::span<const CholeskyLibrary> cholesky_libraries();
/// Name of a Cholesky library: "CHOLMOD" or "Eigen".
const char* library_name(CholeskyLibrary library);

/// Creates a supernodal Cholesky factor, without values, that the given library will compute.
/// Throws InputError if this build does not contain the library.
std::unique_ptr<SupernodalFactor> make_supernodal_factor(
    CholeskyLibrary library = cholesky_libraries().front());

/// Fill-reducing elimination order of the nodes of a graph, first eliminated first, by the default
/// library.
///
/// `graph`: lower triangle of the adjacency matrix including the diagonal; its values are ignored.
/// FactorReuse::once gives AMD. FactorReuse::many gives nested dissection (METIS) with minimum
/// degree on the leaves, which takes four times as long and pays off for 1,000 nodes or more. AMD
/// is used for smaller graphs, and for all graphs if CHOLMOD or METIS is not available. Throws
/// NoSolutionError if memory runs out.
std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);

}  // namespace batten
