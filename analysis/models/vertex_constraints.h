// SPDX-License-Identifier: MPL-2.0
// Constraints at vertices where supports or ties along several curves meet.
#pragma once

#include <vector>

#include "batten/analysis/models/shell_ties.h"

namespace batten {

/// Replaces constraints that nearly depend on others at the same vertex by springs.
///
/// Along two curves that meet at an angle of almost 0, 90 or 180 degrees, the constraints at their
/// common vertex may differ by a small angle only: on a plate that is simply supported along x = 0
/// and symmetric about a curve that is nearly y = 0, the constraints are w_y = 0 and
/// w_y + ε w_x = 0. Imposed exactly, they clamp the vertex (w_x = 0) for every ε ≠ 0, and not for
/// ε = 0. The continuous problem has no such constraint: a rotation at a point has no energy.
///
/// The constraints at a vertex (of coincident vertices of adjacent regions) are made orthogonal in
/// the given order, ties first. Constraints are measured as linear forms of the displacement
/// gradient on the middle surface; ε is the norm of what a constraint adds to those before it,
/// relative to its norm (of a support: its norm on the gradients that the ties permit). A constraint
/// with ε < ε₀ = 0.95 becomes a spring on its violation v = ε · (what it adds):
///
///     E = ½ k v²,   k = α / (1 - (ε/ε₀)²) · { D11 t³      rotations
///                                           { A11 t h²    gradients in the tangent plane
///                                           { A11 t       displacements,       α = 10
///
/// so the result depends continuously on ε: the constraint vanishes with ε, and becomes exact at
/// ε₀. h: length of an element edge; A, D: SectionIntegrals, Q and Q/12 for one material. Constraints that contradict those before them are kept, so that
/// they are reported. Equations with dofs of other points (edge midpoints) are not changed.
///
/// `shape`: absolute dofs of the middle surface; `sections`: one for all regions, or one per region.
/// Cost: O(constraints · log constraints).
void relax_dependent_constraints(const ModelLayout& model, const Points& shape,
                                 const std::vector<ShellSection>& sections, ShellTies& ties);

}  // namespace batten
