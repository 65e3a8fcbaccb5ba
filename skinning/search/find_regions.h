// Which loops of arcs bound surfaces.
#pragma once

#include "batten/core/progress.h"
#include "batten/skinning/search/regions.h"

namespace batten {

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
