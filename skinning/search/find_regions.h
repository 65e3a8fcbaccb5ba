// Finds the closed loops of a curve network that bound surfaces.
#pragma once

#include "batten/core/progress.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// Finds the loops that bound surfaces in a curve network of any genus, open or closed, planar or
/// not.
///
/// The method is based on [Zhuang2013], "A general and efficient method for finding cycles in 3D
/// curve networks". It differs in one point: we select loops, not cyclic orders of edges at nodes.
/// Free edges, internal walls, dangling edges and nodes at which surfaces only touch then need no
/// special cases.
///
/// 1. Tracing. Loops are traced from every corner, a pair of edges at a node. The plane of the two
/// edges gives the surface normal there. It is parallel-transported along the edges. At each node
/// the continuations are tried in the order of interior angle, twist and number of skipped edges
/// (region_loops.h). Dangling edges are ignored.
///
/// 2. Costs. The cost of a loop is Σ interior angles / π (n - 2 for a planar n-gon), plus terms for
/// twist, non-planarity, skipped edges and nodes visited twice. Its gain is 1.25 per edge use minus
/// the cost. Two loops on a common edge cost 0.53 (φ / 90°)². φ is their fold angle: 0° if one
/// continues the other, 180° if one lies on the other.
///
/// 3. Selection. The set of loops with the largest total gain is selected, with at most
/// `max_faces_per_edge` loops per edge. A dual bound and branch and bound prove that it is optimal,
/// unless the search is cut short (loop_selection.h; `optimal`).
///
/// 4. Closed models. If free edges remain, a closed model is searched with an extra gain of 0.6 per
/// edge use. Candidates are the selected loops and those with a mean interior angle of up to 120°,
/// which are unlikely to be free boundaries. A propeller thus gets its blade surfaces, not its
/// ribs. If edges remain unused, a closed model that uses all edges is searched. This covers the
/// sharp edge of a thin wedge, whose faces are folded by 170° or more. That search uses loops with
/// the interior angles of planar ones, and no fold costs more than one of 90°.
///
/// Examples: a planar grid gets its cells, not its outline; a wire box gets six faces; a torus gets
/// no disc in its hole.
///
/// Ambiguity. A smooth or long boundary of an open shell stays open, because its interior angles
/// are near 180°; it is listed in `ambiguous_regions`. So is every decision that another set of
/// loops would change for less than 15 % of the gain per edge use (1.25) of the loops concerned.
///
/// Special cases:
/// - Two loops and nothing else form an annulus if they look like the two boundary circles of
///   one.
/// - A loop that is disconnected from all others but lies on a region (within 2 % of its size)
///   gets no surface, and is listed as ambiguous.
/// - Unused edges that extend from the boundary into a region, close to its hole-filling
///   triangulation (within 10 % of its size), become its inner edges.
/// - A closed chain of free edges inside a planar region, and in its plane, becomes a hole of
///   that region: another part stands there or passes through.
///
/// User specifications take precedence: requested surfaces occupy their edges first, excluded loops
/// are never selected. Otherwise the result depends only on the network; ties are broken by the
/// order of the edges. Cost: about 0.1 s for 200 edges of a typical network; seconds if dozens of
/// edges connect the same two nodes.
///
/// Throws InputError if a name does not exist, if the specified edges do not form a closed loop, or
/// if specifications contradict each other. The message is written for the user.
FoundRegions find_regions(const CurveNetwork& network, const RegionSearchOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
