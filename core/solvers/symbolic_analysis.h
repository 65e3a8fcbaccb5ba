// An order of a graph's nodes that keeps the fill of an elimination small.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

// How often a factor will be used.

/// What the effort for a good order of the unknowns is measured against.
///
/// One factor: AMD. Many factorizations of one pattern, or thousands of solves: from 10,000
/// unknowns on METIS is tried beside AMD and the factor with fewer entries is kept. Measured on
/// sheets, METIS costs ten times AMD's analysis; at 100,000 unknowns it saves a quarter of every
/// factorization and a sixth of every solve and has paid after 10 factorizations or 400 solves,
/// at 14,000 unknowns after 40 or 800, below that hardly ever. An order that the caller knows from
/// the geometry (nested_dissection_order) costs next to nothing and is as good. Eigen's factor has AMD
/// only.
enum class FactorReuse { once, many };


/// The nodes of a graph, the first to eliminate first. `graph`: lower triangle, diagonal included;
/// its values are not looked at. One factor: AMD. Many factors: nested dissection (METIS) with
/// minimum degree below it, which takes four times as long and pays from about 1,000 nodes on, so
/// smaller graphs get AMD. Where CHOLMOD or its METIS is absent: AMD. Throws NoSolutionError when
/// there is not enough memory.
std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);


// The part of a triangular solve that is worth doing.

/// Which supernodes of a factor a solve visits; made by SparseCholesky::part for one analysis.
struct SolveSubset {
  /// Entries of the factor that both sweeps read together; a full solve reads 2 factor_entries().
  long entries = 0;

  long analysis = 0;  // for which it was made
  // Of each supernode, and of each chunk of them: is it visited?
  std::vector<char> forward, backward, chunk_forward, chunk_backward;
};

}  // namespace batten
