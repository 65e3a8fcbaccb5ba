// The two halves of a round of the alternation, over the rings of all nodes. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/sequence/node_graph.h"

namespace batten {

/// R_i of all nodes for which `is_prescribed` is empty or 0, from
///
///     M_i = Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ,   R_i = nearest_rotation(M_i)
///
/// and the energy Σ_i Σ_j w_ij |(v_j - v_i) - R_i (p_j - p_i)|² with the rotations of all nodes, the
/// kept ones too, as Σ w (|e|² + |e⁰|²) - 2 tr(R_iᵀ M_i). `parts`: scratch of the sum, one number a
/// chunk. A ring whose edges lie on one line leaves R_i undetermined: it gets the nearest to the
/// rotation it had. In parallel; the same bits on any number of threads.
double local_step(const NodeGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& is_prescribed, std::vector<Mat3>& rotations,
                  std::vector<double>& parts);

/// Right side of the linear step for displacements x = v - p: of node i
///
///     Σ_j w_ij [½ (R_i + R_j) - 1] (p_i - p_j)
void global_step_rhs(const NodeGraph& graph, const RowPoints& rest,
                     const std::vector<Mat3>& rotations, RowPoints& loads);

}  // namespace batten
