// SPDX-License-Identifier: MPL-2.0
// Propagation of the deformation of shells to attached nodes, which belong only to other elements.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Rule by which the nodes of a non-shell element follow the shells to which the element is
/// connected.
enum class AttachmentRule {
  Stay,   ///< the nodes keep their positions
  Rigid,  ///< the nodes move with all connected elements as one rigid body
  Smooth  ///< the nodes deform smoothly with the shells
};

/// Options of connections() and propagate_to_attached().
struct AttachmentOptions {
  /// Attachment rule of each NonShellElement::Kind, in the order of the enumerators. For rigid and
  /// interpolation elements, the rules Rigid and Smooth are equivalent.
  std::array<AttachmentRule, 7> rule_of_kind = {
      AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Rigid,
      AttachmentRule::Rigid,  AttachmentRule::Rigid,  AttachmentRule::Smooth};
  /// Attachment rule of an element kind.
  AttachmentRule of(NonShellElement::Kind kind) const {
    return rule_of_kind[static_cast<size_t>(kind)];
  }
};

/// Connections that keep their shape while the shells deform, as form features. The connections are
/// all rigid elements, all bushes between two nodes of shells or rigid elements, and all beams
/// between nodes that belong only to rigid elements (a bolt between two spiders). Several elements
/// with equal sets of nodes give one feature. `has_face`: one flag per node, nonzero for nodes of
/// shells.
std::vector<FormFeature> connections(std::span<const NonShellElement> elements,
                                     const std::vector<char>& has_face,
                                     const AttachmentOptions& options);

/// Computes the positions of nodes of non-shell elements after a deformation of the shells.
/// `before`: original positions of all nodes (n×3). `placed`: one flag per node, nonzero if the new
/// position is known. `rotations`: one rotation per node, used for known nodes. `after`: new
/// positions (n×3), given for known nodes and computed for the others.
///
/// 1. Rigid elements move their unknown nodes by the best-fitting rigid motion of the known nodes
///    (exact if these moved rigidly). The reference node of an interpolation element moves by the
///    weighted best-fitting motion of the other nodes. If there is only one known node or all known
///    nodes are collinear, their mean rotation completes the motion.
/// 2. All other elements that are connected to known nodes form bodies. Let R, t be the
///    best-fitting rigid motion of the known nodes of a body. The body follows this motion rigidly,
///    or it deforms smoothly: the logarithms q of the rotations relative to R are harmonic on the
///    graph of the elements, and edges e = ij of length l_e keep their vectors in the least-squares
///    sense,
///
///       min Σ_e w_e |(y_i - y_j) - R((q_i + q_j)/2) (p_i⁰ - p_j⁰)|²,   p = R y + t,   w_e = 1/l_e²
///
///    over all pairs of nodes of an element (p⁰: original positions). The problems for q, y share
///    one factorization. Rigid motions are reproduced exactly.
/// 3. Steps 1 and 2 are repeated for elements connected to the nodes computed so far.
///
/// A node keeps its position if it is not connected to a known node, or only to known nodes that
/// did not move. Returns the indices of the moved nodes, ascending. Throws NoSolutionError if the
/// factorization fails. O(pairs) plus the factorization.
std::vector<int> propagate_to_attached(const Points& before, Points& after,
                                       std::vector<char> placed, std::vector<Mat3> rotations,
                                       std::span<const NonShellElement> elements,
                                       const AttachmentOptions& options);

}  // namespace batten
