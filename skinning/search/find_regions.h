// Finds which loops of arcs bound surfaces.
#pragma once

#include "batten/core/progress.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// Finds the loops that bound surfaces, on a network of any genus, open or closed, not planar.
///
/// After Zhuang, Zou, Carr, Ju, "A general and efficient method for finding cycles in 3D curve
/// networks" (2013), in our own way: what is chosen is loops, not orders of arcs at nodes, so that
/// rims, walls, dangling arcs and nodes where surfaces only touch need no exceptions.
///
/// 1. Loops are traced from every corner (two arcs at a node). The plane of the two arcs gives the
///    surface's normal there; it is carried along arcs without turning, and at each node the arcs
///    to go on by are tried in the order of inside angle, twist and arcs jumped over
///    (region_loops.h). Dangling arcs are left out.
/// 2. A loop costs Σ inside angles / π (a plane n-gon: n - 2), its twist, its distance from a
///    plane, arcs that it jumps over, nodes that it passes twice. It is given 1.25 for each side of
///    an arc that it covers. Two loops on one arc pay 0.53 (φ / 90°)², with φ the angle by which
///    they turn against each other: 0 where one continues the other, 180° where it lies on it.
/// 3. The set of loops with the largest sum, with at most `max_faces_per_edge` loops on an arc, is chosen.
///    It is proved best by a dual bound and by branch and bound, unless that is cut short
///    (region_selection.h; `optimal`).
///
/// 4. Where that leaves rims, a closed model is looked for: with 0.6 more for each side, among the
///    chosen loops and those that do not run like rims (mean inside angle up to 120 degrees). So a
///    propeller gets its skins rather than its ribs. Where the choice leaves arcs bare (the sharp
///    edge of a thin wedge, whose faces turn against each other by 170 degrees and more), a closed
///    model that takes all arcs is looked for, of loops with the inside angles of plane ones, in
///    which no edge costs more than one of 90 degrees.
///
/// So a plane grid gets its cells and not its outline, a wire box six faces, a torus no disc in its
/// hole. A smooth or long rim of an open shell stays open, because its inside angles are near 180
/// degrees; it is listed as a choice. So is everything that another set of loops would have
/// otherwise for less than 15 % of what the arcs concerned are worth. Two loops and nothing else
/// are a ring when they are like rims. A loop apart from all others that lies on a region (within
/// 2 % of its size) is left bare and listed as a choice. Bare arcs that hang into a region and lie
/// near its plain filling (within 10 % of its size) are its inner lines. A closed chain of arcs with
/// one region each, in a plane region, is a hole of that: something stands there, or goes through.
///
/// The user's words come first: the surfaces that they ask for take their room on the arcs, those
/// that they refuse are never chosen. The rest depends on the network alone; ties go by the order
/// of arcs. Cost: about 0.1 s for 200 arcs of a usual network; seconds where dozens of arcs join
/// the same two nodes.
///
/// Throws InputError, in words for the user: names that are not there, words whose arcs do not
/// close a loop or that contradict each other.
FoundRegions find_regions(const CurveNetwork& network, const RegionSearchOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
