// Nodes that no shell has go with the shells that their elements hang on.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// How nodes go with the shells that elements of one kind connect them to.
enum class AttachmentRule {
  Stay,   ///< they do not
  Rigid,  ///< with all that hangs together, as one rigid body
  Smooth  ///< they deform with them
};

struct AttachmentOptions {
  /// One for each NonShellElement::Kind. Rigid elements and averages say themselves how they move:
  /// Stay or not is all that counts.
  std::array<AttachmentRule, 7> rule_of_kind = {
      AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Smooth, AttachmentRule::Rigid,
      AttachmentRule::Rigid,  AttachmentRule::Rigid,  AttachmentRule::Smooth};
  AttachmentRule of(NonShellElement::Kind kind) const {
    return rule_of_kind[static_cast<size_t>(kind)];
  }
};

/// The connections that keep their shape while the shells deform, as form features: each rigid
/// element; each bush between two nodes that shells or rigid elements have, with its length and
/// direction; each beam between nodes that only rigid elements have (a bolt between two spiders).
/// Elements over the same nodes make one. `has_face`: nodes of shells.
std::vector<FormFeature> connections(std::span<const NonShellElement> elements,
                                     const std::vector<char>& has_face,
                                     const AttachmentOptions& options);

/// Places the nodes that the deformation did not place. `before`, `after`: all nodes (n×3);
/// `placed`: those whose place `after` is known, with their rotation in `rotations`.
///
/// 1. Rigid elements carry their other nodes by the best rotation and shift of those that are placed
///    (exact where these moved rigidly); the reference of an average goes by the same with its
///    weights. Of one node, or of nodes on one line, the nodes' own mean rotation decides the rest.
/// 2. What else hangs together, and on placed nodes: R, t the best motion of these, carried rigidly
///    by it, or smoothly: logarithms q of the rotations relative to R are harmonic on the graph of
///    the elements, and edges keep their vectors in the least-squares sense,
///
///        min Σ_e w_e |(y_i - y_j) - R((q_i + q_j)/2) (p_i⁰ - p_j⁰)|²,   p = R y + t,   w_e = 1/l_e²
///
///    over all pairs of nodes of an element. Both share one factor. Rigid motions are exact.
/// 3. Again, for what hangs on those.
///
/// Nodes that hang on nothing stay, and so do those whose placed nodes all stay. Returns the nodes
/// that were placed, ascending. Throws NoSolutionError when the factor fails.
/// O(pairs) and the factor.
std::vector<int> propagate_to_attached(const Points& before, Points& after,
                                       std::vector<char> placed, std::vector<Mat3> rotations,
                                       std::span<const NonShellElement> elements,
                                       const AttachmentOptions& options);

}  // namespace batten
