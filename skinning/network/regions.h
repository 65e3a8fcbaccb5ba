// Which loops of a network bound surfaces.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/network.h"

namespace batten {

/// An arc on its way around a loop.
struct ArcUse {
  int arc = 0;
  bool reversed = false;
  bool operator==(const ArcUse&) const = default;
};
using ArcLoop = std::vector<ArcUse>;

/// One surface to be: where it ends, and what lies on it.
struct NetworkRegion {
  std::string name;  ///< the user's, or "region 1", "region 2", …
  /// The outline, then holes; of a ring its two rims. An arc may occur twice in a loop (a slit that
  /// the surface lies on both sides of).
  std::vector<ArcLoop> loops;
  bool ring = false;
  std::vector<int> inner;  ///< arcs that lie on the surface, inside
  bool asked = false;      ///< the user's word
  double cost = 0;         ///< cost of the loop; 0 for one that is asked for
};

/// What the user says first. Names are those of arcs, or of lines (then all their arcs).
struct RegionWord {
  enum class Kind {
    Surface,  ///< a surface with these loops
    Nothing   ///< no surface in this loop (loops[0])
  };
  Kind kind = Kind::Surface;
  std::string name;                             ///< name of the region
  std::vector<std::vector<std::string>> loops;  ///< lines of each loop, in any order and direction
  bool ring = false;                            ///< loops are the two rims of a ring
  std::vector<std::string> inner;
  std::string where;  ///< for messages: "scene.toml:8:1: "
};

struct RegionOptions {
  std::vector<RegionWord> words;
  /// At most so many regions meet at an arc; more make branching surfaces, which are not oriented.
  int most_at_arc = 2;
};

/// A choice that could as well have been another.
struct RegionChoice {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> arcs;  ///< names of the arcs that it is about
  std::string text;               ///< sentences for the user: what to say to have it otherwise
  std::vector<ArcLoop> chosen;
  std::vector<std::vector<ArcLoop>> alternatives;  ///< best first
  std::vector<double> margins;                     ///< cost of each over the chosen one, relative
};

struct FoundRegions {
  std::vector<NetworkRegion> regions;  ///< asked for, then found, these in canonical order
  std::vector<RegionChoice> choices;
  std::vector<int> rims;  ///< arcs with one region
  std::vector<int> bare;  ///< arcs with none
  bool optimal = true;    ///< the least cost is proved; false: the search was cut short
};

/// The loops that bound surfaces, on a network of any genus, open or closed, not planar.
///
/// After Zhuang, Zou, Carr, Ju, "A general and efficient method for finding cycles in 3D curve
/// networks" (2013), in our own way: what is chosen is loops, not orders of arcs at nodes, so that
/// rims, walls, dangling arcs and nodes where surfaces only touch need no exceptions.
///
/// 1. Loops are traced from every corner (two arcs at a node): the surface's normal, arcs' plane at
///    corners, is carried along arcs without turning, and at each node ways on are tried in the
///    order of inside angle, twist and arcs jumped over (region_loops.h). Dangling arcs are no
///    ways.
/// 2. A loop costs Σ inside angles / π (a plane n-gon: n - 2), its twist, its distance from a
///    plane, arcs that it jumps over, nodes that it passes twice. It is given 1.25 for each side of
///    an arc that it covers. Two loops on one arc pay 0.53 (δ / 90°)², δ by how much they turn
///    against each other: 0 where one continues the other, 180° where it lies on it.
/// 3. The set of loops that is worth most, with at most `most_at_arc` on an arc, is chosen, proved
///    by a dual bound and branch and bound, or cut short (region_selection.h; `optimal`).
///
/// So a plane grid has its cells and not its outline, a wire box six faces, a torus no disc in its
/// hole. A smooth rim, or a long one, around an open shell at a crease stays open: its inside
/// angles are near 180 degrees. It is a choice, as is whatever another set of loops would change
/// for less than 15 % of what the arcs concerned are worth. Two loops and nothing else are a ring
/// where they are like rims. A loop apart from all others that lies on a region (within 2 % of its
/// size) is left bare, and a choice. Bare arcs that hang into a region and lie near its plain
/// filling (within 10 %) are its inner lines.
///
/// Words come first: what they ask for takes its room, what they refuse is never chosen. The rest
/// depends on the network alone, ties go by the order of arcs. Cost: about 0.1 s for 200 arcs of a
/// usual network; seconds where dozens of arcs join the same two nodes.
///
/// Throws InputError, in words for the user: names that are not there, words whose arcs do not
/// close a loop or that contradict each other.
FoundRegions find_regions(const CharacterLineNetwork& network, const RegionOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
