// Traces loops that could bound a surface, and computes what each costs.
#pragma once

#include "batten/skinning/search/region_graph.h"

namespace batten {

/// Prices of loops, in units of half a turn: a plane n-gon costs n - 2.
struct LoopCosts {
  double covered = 1.25;  ///< what a loop is given for each side of an arc that it takes
  /// What a side that is covered is worth more in the search for a closed model.
  double closed = 0.6;
  /// For each arc with two loops that turn against each other by 90 degrees; it grows with the
  /// square of the angle, and is divided by max_faces_per_edge - 1 where more than two may meet.
  double fold = 0.53;
  /// What a loop costs less for each place where a straight arc goes on in a curved one, in the
  /// outline of a plane face (fillet_ends): a fillet is one corner, not two sides.
  double fillet_end = 0.28;
  double twist = 0.5;  ///< times the square of the twist between corner planes, in quarter turns
  double nonplanarity = 1.0;  ///< times the square of LoopCandidate::nonplanarity
  double jump = 0.3;          ///< for each arc that leaves a node of the loop into its surface
  double revisits = 1.5;      ///< for each node that it passes twice, but for bridges
};

/// A loop, and how a surface would lie at it by its corners.
struct LoopCandidate {
  EdgeLoop loop;    ///< canonical
  double cost = 0;  ///< Σ of inside angles / π + prices of twist, bend, jumps, repeats
  /// For each use of an arc the direction into the surface, as an angle in the arc's frame, at the
  /// arc's own start and end.
  std::vector<std::array<double, 2>> side;
  double nonplanarity = 0;  ///< rms distance from the plane of least squares over (length / 2π)
  double inside_deg = 0;    ///< mean of the inside angles
  int revisits = 0;         ///< nodes and arcs that are passed twice, but for bridges
  double gain(const LoopCosts& costs) const {
    return costs.covered * static_cast<double>(loop.size()) - cost;
  }
};

/// Measures a closed loop. Corner planes (of the arcs before and after a corner) give the surface's
/// normal where arcs meet at 15 to 165 degrees; between such corners the normal is carried along
/// without turning about the line, and what is missing at the next corner is its twist, spread over
/// the length. Without such a corner the area vector of the loop gives the normal. The surface is
/// on the side to which the loop turns in all. The outline of a plane face with fillets costs what
/// its arcs turn too, as a polygon does: n - 2 for n arcs, less `fillet_end`s. O(arcs).
LoopCandidate measure_loop(const RegionGraph& graph, const EdgeLoop& loop, const LoopCosts& costs);

/// Returns by how many degrees two surfaces that share an arc (use i of a, j of b) turn against
/// each other, as the root mean square along it: 0 when one continues the other, 180 when one lies
/// on the other.
double fold_deg(const LoopCandidate& a, size_t i, const LoopCandidate& b, size_t j);

/// Returns whether an arc that leaves a node of the loop goes into its surface: within 30 degrees
/// of the corner's plane, between the arcs of the corner.
bool leaves_into(const RegionGraph& graph, const LoopCandidate& loop, const EdgeEnd& end);

/// The loops that were traced.
struct TracedLoops {
  std::vector<LoopCandidate> loops;  ///< loops in canonical order, each once
  bool complete = true;              ///< false: the work limit was met
};

/// Traces loops from each corner of the network.
///
/// From each pair of arcs at a node the surface between them is followed: its normal is carried
/// along the arc, and at the next node arcs are tried in the order in which a ray meets them that
/// turns in the surface from the arc behind. A way on costs as much as it is worse than the best
/// one at its node (angle turned, twist, arcs jumped over), and the cheapest closed ways are kept:
/// the first is the face that a plane graph would have there, the others are near to it. The work
/// at each corner is bounded. Loops in the plane of the pair come first (loop_in_plane).
TracedLoops trace_loops(const RegionGraph& graph, const LoopCosts& costs, const Progress& progress);

}  // namespace batten
