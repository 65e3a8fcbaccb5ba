// SPDX-License-Identifier: MPL-2.0
// Finds the closed loops of a curve network that bound surfaces.
#pragma once

#include "batten/core/progress.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// Finds the loops that bound surfaces in a curve network of any genus, open or closed, planar or
/// not.
///
/// The method is based on [Zhuang2013], "A general and efficient method for finding cycles in 3D
/// curve networks". It differs in one point: loops are selected, instead of cyclic orders of edges
/// at nodes. Free edges, internal walls, dangling edges and nodes at which surfaces only touch
/// therefore need no special cases.
///
/// 1. Tracing. Loops are traced from every corner, that is, every pair of edges at a node. The
/// initial surface normal is that of the plane of the two edges. It is parallel-transported along
/// the edges. At each node the continuations are tried in the order of interior angle, twist and
/// number of skipped edges (region_loops.h). Dangling edges are ignored.
///
/// 2. Costs. The cost of a loop is the sum of its interior angles divided by π (n - 2 for a planar
/// n-gon), plus terms for twist, non-planarity, skipped edges and nodes visited twice. The gain of
/// a loop is 1.25 times the number of its edges, minus the cost. A pair of loops with a common edge
/// has the additional cost 0.53 (φ / 90°)². φ is the fold angle between both loops: 0° if one loop
/// continues the other, 180° if one lies on the other.
///
/// 3. Selection. The set of loops with the largest total gain is selected, with at most
/// `max_faces_per_edge` loops per edge. Branch and bound with a dual bound proves that the set is
/// optimal, unless the search is cut short (loop_selection.h, FoundRegions::optimal).
///
/// 4. Closed models. If free edges remain, a closed model is searched for, with an extra gain of
/// 0.6 per edge of a loop. Candidates are the selected loops, and loops with a mean interior angle
/// of up to 120°, because these are unlikely to be free boundaries. A propeller thus gets its blade
/// surfaces, not its ribs. If edges remain unused, a closed model that uses all edges is searched
/// for. Such models contain thin wedges, whose faces are folded by 170° or more at the sharp edge.
/// In this search, loops have the interior angles of planar loops, and no fold costs more than a
/// fold of 90°.
///
/// Examples: a planar grid gets its cells, not its outline; a wire box gets six faces; a torus gets
/// no disc in its hole.
///
/// Ambiguity. A smooth or long boundary of an open shell stays open, because its interior angles
/// are near 180°; it is listed in `ambiguous_regions`. A decision is also listed there if a
/// different set of loops would reduce the gain by less than 15 % of 1.25 per edge of the loops
/// concerned.
///
/// Special cases:
/// - A network of only two loops is an annulus if the loops resemble the two boundary circles of an
///   annulus.
/// - A loop that is connected to no other loop, but lies on a face (within 2 % of the size of the
///   face), gets no surface and is listed as ambiguous.
/// - Unused edges that extend from the boundary of a face to the inside, close to the hole-filling
///   triangulation of the face (within 10 % of its size), become inner edges of the face.
/// - A closed chain of free edges inside a planar face, and in its plane, becomes a hole of that
///   face, because another part of the model is attached to the face or passes through it.
///
/// User specifications take precedence: requested faces are placed before all others, and excluded
/// loops are never selected. Otherwise the result depends only on the network; ties are broken by
/// the order of the edges. Cost: about 0.1 s for 200 edges of a typical network; seconds if dozens
/// of edges connect the same two nodes.
///
/// Throws InputError if a name does not exist, if the specified edges do not form a closed loop, or
/// if specifications contradict each other. The message is written for the user.
FoundRegions find_regions(const CurveNetwork& network, const RegionSearchOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
