// SPDX-License-Identifier: MPL-2.0
// Lofts between sections with corners: detects the sections in a network, and makes the rails
// between corresponding points of neighbouring sections.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// The sections of a loft in order, and the guides: curves that already connect the sections.
struct LoftPlan {
  /// A chain of network edges, closed or open.
  struct Section {
    EdgeLoop edges;
    bool closed = false;
  };
  std::vector<Section> sections;         ///< at least two, all closed or all open
  std::vector<std::vector<int>> guides;  ///< for each guide, its node on each section
};

/// Plans a loft if the network consists of a row of sections and of guides that meet each section
/// once.
///
/// Closed sections: without its bridges (edges whose removal disconnects it), the network consists
/// of simple closed chains; or all closed curves are sections, and all others guides. At least one
/// section has a corner. Open sections: each part of the network is one open chain, and all have
/// the same number of interior corners, at least one; or all curves meet only one curve, the guide,
/// and not all of them lie in a plane. Consecutive sections must face each other (loft_order()).
/// Returns nullopt for other networks. Cost: O(n³) for n sections.
std::optional<LoftPlan> find_loft(const CurveNetwork& network);

/// Plans a loft through the named curves, in this order. The other curves of the network are guides
/// and must meet every section. Returns nullopt if this is not the case, if closed sections have no
/// corner, or if open sections have neither a guide nor the same number of interior corners, at
/// least one. O(edges).
std::optional<LoftPlan> loft_through(const CurveNetwork& network,
                                     const std::vector<std::string>& sections);

/// Makes the missing rails of a loft: "rail 1", "rail 2", … through corresponding points of all
/// sections, as cubic splines with not-a-knot end conditions.
///
/// The section with the most corners (including its ends and the points on guides) determines the
/// number of rails. Sections are compared after a similarity transformation that maps the centroid,
/// the mean radius and the normal of one onto those of the next one. The corners of the next
/// section are assigned, in cyclic order, such that the sum of their squared distances from the
/// rails is least; the remaining rails meet the next section at the nearest point. A single rail
/// gets a second one, through the points that are farthest from it (the nose of an aerofoil).
/// The result does not depend on the directions and start points of the sections.
///
/// Cost: O(n m³) for n sections with m corners.
std::vector<CharacterLine> loft_rails(const CurveNetwork& network, const LoftPlan& plan);

/// The faces between consecutive sections and consecutive rails and guides: four sides each. With
/// guides, the first and the last of closed sections bound faces, too (the ribs of a wing).
///
/// `network`: the network of the curves of `planned` and of `rails`, in this order. Returns nullopt
/// if a rail does not meet every section once, or if the rails and guides bound no such faces.
/// O(edges²).
std::optional<FoundRegions> loft_faces(const CurveNetwork& network, const CurveNetwork& planned,
                                       const LoftPlan& plan,
                                       const std::vector<CharacterLine>& rails);

/// Names of the rails of loft_rails() that run through a corner of some section.
std::vector<std::string> rails_at_corners(const CurveNetwork& network, const LoftPlan& plan,
                                          const std::vector<CharacterLine>& rails);

/// Gap tolerance that keeps rails apart, such as those along a thick trailing edge: a tenth of the
/// least distance between the ends of two rails; infinite for a single rail.
double rail_tolerance(const std::vector<CharacterLine>& rails);

}  // namespace batten
