// The two halves of a round of the alternation, over the rings of all nodes. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/sequence/ring_graph.h"

namespace batten {

/// R_i of all nodes for which `kept` is empty or 0, from
///
///     M_i = Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ,   R_i = rotation_part(M_i)
///
/// and the energy Σ_i Σ_j w_ij |(v_j - v_i) - R_i (p_j - p_i)|² with the rotations of all nodes, the
/// kept ones too, as Σ w (|e|² + |e⁰|²) - 2 tr(R_iᵀ M_i). `parts`: scratch of the sum, one number a
/// chunk. A ring whose edges lie on one line leaves R_i undetermined: it gets the nearest to the
/// rotation it had. In parallel; the same bits on any number of threads.
double turn_rings(const RingGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& kept, std::vector<Mat3>& turns,
                  std::vector<double>& parts);

/// Right side of the linear step for displacements x = v - p: of node i
///
///     Σ_j w_ij [½ (R_i + R_j) - 1] (p_i - p_j)
void ring_loads(const RingGraph& graph, const RowPoints& rest, const std::vector<Mat3>& turns,
                RowPoints& loads);

}  // namespace batten
