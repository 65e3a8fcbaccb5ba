// SPDX-License-Identifier: MPL-2.0
// Traces candidate loops of a curve network and computes their costs.
#pragma once

#include "batten/skinning/search/region_graph.h"

namespace batten {

/// Cost coefficients of loops. Unit: an interior angle of 180°; a planar n-gon costs n - 2.
struct LoopCosts {
  double covered = 1.25;  ///< gain of a loop per edge use
  /// Additional gain per edge use in the search for a closed model.
  double closed = 0.6;
  /// Cost of two loops that meet at an edge with a fold angle of 90°. It grows with the square of
  /// the angle and is divided by max_faces_per_edge - 1 if that is more than 1.
  double fold = 0.53;
  /// Discount per fillet end in the outline of a planar face: a point at which a straight edge
  /// continues smoothly in a curved one (see fillet_ends()). A fillet counts as one corner, not as
  /// two sides.
  double fillet_end = 0.28;
  double twist = 0.5;         ///< times the squared twist between corner planes, in units of 90°
  double nonplanarity = 1.0;  ///< times the square of LoopCandidate::nonplanarity
  double jump = 0.3;          ///< per edge that leaves a node of the loop into its surface
  double revisits = 1.5;      ///< per node visited twice, except at bridges
};

/// A candidate loop, with its cost and the directions into its surface.
struct LoopCandidate {
  EdgeLoop loop;  ///< in canonical order, see canonical()
  /// Σ interior angles / π + costs of twist, non-planarity, skipped edges, revisits.
  double cost = 0;
  /// For each edge use, the direction into the surface at the start and end of the edge (not of the
  /// travel), as an angle in the edge's frame (GraphEdge), radians.
  std::vector<std::array<double, 2>> side;
  double nonplanarity = 0;  ///< RMS distance from the least-squares plane, over (length / 2π)
  double inside_deg = 0;    ///< mean interior angle, degrees
  int revisits = 0;         ///< nodes and edges visited more than once, except at bridges
  /// Gain of selecting this loop alone.
  double gain(const LoopCosts& costs) const {
    return costs.covered * static_cast<double>(loop.size()) - cost;
  }
};

/// Measures a closed loop: surface normals, interior angles, twist, non-planarity and cost.
///
/// The plane of the two edges at a corner gives the surface normal if they meet at 15° to 165°.
/// Between such corners the normal is parallel-transported. Its difference at the next corner is
/// the twist, which is distributed over the length. If there is no such corner, the area vector of
/// the loop gives the normal. The surface lies on the side towards which the loop turns in total.
/// In the outline of a planar face with fillets, the turning of the curved edges is included, as
/// for a polygon: n - 2 for n edges, minus `fillet_end` per fillet end. Cost: O(edges).
LoopCandidate measure_loop(const RegionGraph& graph, const EdgeLoop& loop, const LoopCosts& costs);

/// Fold angle in degrees between two surfaces at a common edge (use i of a, use j of b): 0 if one
/// continues the other, 180 if one lies on the other. Root mean square along the edge.
double fold_deg(const LoopCandidate& a, size_t i, const LoopCandidate& b, size_t j);

/// True if an edge that leaves a node of the loop goes into its surface: within 30° of the corner
/// plane, and between the two edges of the corner.
bool leaves_into(const RegionGraph& graph, const LoopCandidate& loop, const EdgeEnd& end);

/// Result of trace_loops().
struct TracedLoops {
  std::vector<LoopCandidate> loops;  ///< distinct loops in canonical order
  bool complete = true;              ///< false: the work limit was reached
};

/// Traces loops from each corner of the network (best-first search).
///
/// For each pair of edges at a node, the surface between them is followed. Its normal is
/// parallel-transported along the edge. At the next node the continuations are ordered by cost:
/// interior angle (swept within the surface from the incoming edge), twist and skipped edges. A
/// step costs the difference to the best continuation at its node, and the cheapest closed paths
/// are kept. The first of them is the face that a planar graph would have there; the others are
/// close to it. The work per corner is bounded. Loops in the plane of the pair are added first
/// (loop_in_plane()).
TracedLoops trace_loops(const RegionGraph& graph, const LoopCosts& costs, const Progress& progress);

}  // namespace batten
