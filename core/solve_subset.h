// The part of a triangular solve that is worth doing.
#pragma once

#include <vector>

namespace batten {

/// Which supernodes of a factor a solve visits; made by SparseCholesky::part for one analysis.
struct SolveSubset {
  /// Entries of the factor that both sweeps read together; a full solve reads 2 factor_entries().
  long entries = 0;

  long analysis = 0;  // for which it was made
  // Of each supernode, and of each chunk of them: is it visited?
  std::vector<char> forward, backward, chunk_forward, chunk_backward;
};

}  // namespace batten
