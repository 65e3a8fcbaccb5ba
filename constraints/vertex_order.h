// An order of free unknowns from the graph of a mesh's vertices.
#pragma once

#include <array>
#include <vector>

#include "batten/constraints/affine_reduction.h"

namespace batten {

/// Of each dof: its vertex, twice; of a dof of an edge: the two ends.
using DofVertices = std::vector<std::array<int, 2>>;

/// An order to factor `reduced` = DᵀKD in, for SparseCholesky::analyze: vertices are ordered in the
/// graph of those that `reduced` couples (elimination_order), each with all of its dofs, and the
/// dof of an edge comes right behind the end that is eliminated first. A graph with a sixth of the
/// unknowns is ordered in a tenth of the time, and because vertices and edges stay together the
/// factor is smaller than in an order of the unknowns: by a fifth to a quarter against AMD on
/// sheets, by half where rows along curves tie dofs together. O(entries of `reduced`), and the
/// order of the vertices. Throws InputError: vertices of another number of dofs; a coupled
/// reduction.
std::vector<int> vertex_order(const AffineReduction& reduction, const SparseMatrix& reduced,
                              const DofVertices& vertices, Expected expected);

}  // namespace batten
