// An order of a graph's nodes that keeps the fill of an elimination small.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/factor_reuse.h"

namespace batten {

/// The nodes of a graph, the first to eliminate first. `graph`: lower triangle, diagonal included;
/// its values are not looked at. One factor: AMD. Many factors: nested dissection (METIS) with
/// minimum degree below it, which takes four times as long and pays from about 1,000 nodes on, so
/// smaller graphs get AMD. Where CHOLMOD or its METIS is absent: AMD. Throws NoSolutionError when
/// there is not enough memory.
std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse);

}  // namespace batten
