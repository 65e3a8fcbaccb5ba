// Fill-reducing elimination orders, and the subsets of a factor that partial solves visit.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

// Expected reuse of a factorization.

/// Expected reuse of a factorization, which selects the effort spent on a fill-reducing order.
///
/// - `once`: AMD.
/// - `many`: many factorizations of one pattern, or thousands of solves. From 10,000 unknowns on,
///   METIS is tried in addition to AMD, and the factor with fewer entries is kept.
///
/// Measured on surface meshes, METIS takes ten times as long as an analysis with AMD. At 100,000
/// unknowns it saves a quarter of every factorization and a sixth of every solve, and pays off
/// after 10 factorizations or 400 solves. At 14,000 unknowns it pays off after 40 or 800, below
/// that hardly ever. An order that the caller knows from the geometry (nested_dissection_order())
/// costs next to nothing and is as good. Without CHOLMOD only AMD is available.
enum class FactorReuse { once, many };

/// Fill-reducing elimination order of the nodes of a graph, first eliminated first.
///
/// `graph`: lower triangle of the adjacency matrix including the diagonal; its values are ignored.
/// For `once` the order is AMD. For `many` it is nested dissection (METIS) with minimum degree on
/// the leaves, which takes four times as long and pays off from about 1,000 nodes on. Smaller
/// graphs get AMD, as do all if CHOLMOD or its METIS is missing. Throws NoSolutionError if memory
/// runs out.
std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);

// Partial triangular solves.

/// Supernodes that a partial solve visits; created by SparseCholesky::subset() for one analysis.
struct SolveSubset {
  /// Entries of the factor that both sweeps read together. A full solve reads 2 factor_entries().
  long entries = 0;

  long analysis = 0;  // identifies the analysis it belongs to
  // Flags: whether each supernode, and each chunk of supernodes, is visited by a sweep.
  std::vector<char> forward, backward, chunk_forward, chunk_backward;
};

}  // namespace batten
