// Propagates the deformation of shells to attached nodes, which belong to other elements only.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// How nodes of elements of one kind follow the shells that they are connected to.
enum class AttachmentRule {
  Stay,   ///< they keep their position
  Rigid,  ///< with everything connected to them as one rigid body
  Smooth  ///< they deform smoothly with the shells
};

/// Options of connections() and propagate_to_attached().
struct AttachmentOptions {
  /// One rule for each NonShellElement::Kind. For rigid and interpolation elements the motion
  /// follows from the element itself; only Stay or not Stay matters.
  std::array<AttachmentRule, 7> rule_of_kind = {
      AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Rigid,
      AttachmentRule::Rigid,  AttachmentRule::Rigid,  AttachmentRule::Smooth};
  /// The rule of an element kind.
  AttachmentRule of(NonShellElement::Kind kind) const {
    return rule_of_kind[static_cast<size_t>(kind)];
  }
};

/// Connections that keep their shape while the shells deform, as form features. These are every
/// rigid element; every bush between two nodes of shells or rigid elements, which keeps its length
/// and direction; and every beam between nodes that belong only to rigid elements (a bolt between
/// two spiders). Elements with the same nodes give one feature. `has_face`: one flag per node,
/// nonzero for nodes of shells.
std::vector<FormFeature> connections(std::span<const NonShellElement> elements,
                                     const std::vector<char>& has_face,
                                     const AttachmentOptions& options);

/// Computes the positions of the nodes that the deformation of the shells did not determine.
/// `before`: original positions of all nodes (n×3). `after`: new positions; known for nodes with
/// `placed` set, whose rotations are in `rotations`; the others are filled in.
///
/// 1. Rigid elements move their other nodes by the best rigid motion of the known ones (exact if
///    these moved rigidly). The reference node of an interpolation element moves by the weighted
///    best motion of the others. If there is only one known node, or all are collinear, the mean
///    rotation of these nodes determines the rest.
/// 2. Any other elements that are connected to known nodes form bodies. Let R, t be the best rigid
///    motion of the known nodes of a body. The body follows it rigidly, or smoothly: the logarithms
///    q of the rotations relative to R are harmonic on the graph of the elements, and edges keep
///    their vectors in the least-squares sense,
///
///       min Σ_e w_e |(y_i - y_j) - R((q_i + q_j)/2) (p_i⁰ - p_j⁰)|²,   p = R y + t,   w_e = 1/l_e²
///
///    over all pairs of nodes of an element. Both problems share one factorization. Rigid motions
///    are reproduced exactly.
/// 3. Repeat, for elements connected to the nodes found so far.
///
/// Nodes that are connected to nothing stay, and so do nodes whose known nodes all stayed. The
/// result lists the nodes that were moved, ascending. Throws NoSolutionError if the factorization
/// fails. O(pairs) plus the factorization.
std::vector<int> propagate_to_attached(const Points& before, Points& after,
                                       std::vector<char> placed, std::vector<Mat3> rotations,
                                       std::span<const NonShellElement> elements,
                                       const AttachmentOptions& options);

}  // namespace batten
