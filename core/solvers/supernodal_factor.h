// SPDX-License-Identifier: MPL-2.0
// Supernodal Cholesky factors: their layout, and the interface of the libraries that compute them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Expected reuse of a factorization, which selects the effort spent on a fill-reducing order.
///
/// - `once`: AMD.
/// - `many`: many factorizations of one pattern, or thousands of solves. For 10,000 unknowns or
///   more, METIS is tried in addition to AMD, and the factor with fewer entries is kept.
///
/// Measured on surface meshes, METIS takes ten times as long as an analysis with AMD. At 100,000
/// unknowns it saves a quarter of every factorization and a sixth of every solve, and pays off
/// after 10 factorizations or 400 solves. At 14,000 unknowns it pays off after 40 factorizations or
/// 800 solves, and for smaller systems hardly ever. An order that the caller knows from the
/// geometry (nested_dissection_order()) costs next to nothing and is as good. Without CHOLMOD only
/// AMD is available.
enum class FactorReuse { once, many };

/// Layout of a supernodal factor L. A supernode is a set of consecutive columns with the same rows
/// below them. It is stored by columns as one dense block: first its own columns (a lower triangle;
/// entries above the diagonal are not read), then the rows below.
struct SupernodalPattern {
  int count = 0;                    // number of supernodes
  const int* columns = nullptr;     // count+1: first column of each supernode, then the matrix size
  const int* row_starts = nullptr;  // count+1: first index in `rows` of each supernode
  // Row indices of each supernode, ascending; the indices of its own columns come first.
  const int* rows = nullptr;
  const int* value_starts = nullptr;  // count+1: offset of each supernode's block in the values
};

/// Supernodes of a Cholesky factor that a partial triangular solve visits; created by
/// SparseCholesky::subset().
struct SolveSubset {
  /// Number of entries of the factor that the forward and the backward sweep of the partial solve
  /// read in total. A full solve reads 2 SparseCholesky::factor_entries().
  long entries = 0;

  long analysis = 0;  // identifies the symbolic analysis to which the subset belongs
  // Flag for each supernode, and for each chunk of supernodes: 1 if the sweep visits it, else 0.
  std::vector<char> forward, backward, chunk_forward, chunk_backward;
};

/// Cholesky factorization P A Pᵀ = L Lᵀ, with a permutation P, in dense supernodal blocks.
/// Implementation detail of SparseCholesky; make_supernodal_factor() (linear_solver_backend.h)
/// creates one that a given library computes.
class SupernodalFactor {
 public:
  virtual ~SupernodalFactor() = default;

  /// Symbolic analysis of the matrix A, which must have at least one row. `order`: elimination
  /// order of the unknowns; empty: automatic.
  virtual void analyze(const SparseMatrix& A, const std::vector<int>& order,
                       FactorReuse factor_reuse) = 0;

  /// Computes the numeric values of the factor of A. Returns an error message, or "" on success.
  virtual std::string factorize(const SparseMatrix& A) = 0;

  /// Supernodal pattern of the factor; order() gives the elimination order. Both are valid after a
  /// successful factorize() and unchanged until the next analyze().
  virtual SupernodalPattern pattern() const = 0;
  virtual const int* order() const = 0;

  /// Values of the factor from the last factorize(). The caller may overwrite them: the next
  /// factorize() recomputes all of them.
  virtual double* values() = 0;
};

// Implementations of make_supernodal_factor() and elimination_order() for each library:
// supernodal_factor_cholmod.cpp (not in every build) and supernodal_factor_eigen.cpp.

std::unique_ptr<SupernodalFactor> make_cholmod_factor();
std::vector<int> cholmod_elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);

std::unique_ptr<SupernodalFactor> make_eigen_factor();
std::vector<int> eigen_elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);

/// Error message for a Cholesky pivot that is not positive; `unknown`: index of its unknown.
inline std::string not_positive_definite(long unknown) {
  return "the matrix is not positive definite (pivot of unknown " + std::to_string(unknown) +
         "): a motion is not constrained; fix more points, or use beta > 0";
}

/// Relative pivot threshold: the matrix is treated as singular if a pivot is at most this fraction
/// of the corresponding diagonal entry of the matrix. Bending problems with 100,000 unknowns stay
/// above 1e-10.
inline constexpr double kSingularPivot = 1e-14;

}  // namespace batten
