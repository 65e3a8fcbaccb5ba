// What the search for regions sees of a network: arcs as frames along polylines, and who meets
// whom.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/search/regions.h"

namespace batten {

/// An arc as kPieces straight pieces of equal parameter length, with a frame carried along it
/// without turning about the tangent (parallel transport, by double reflection; Wang, Jüttler,
/// Zheng, Liu 2008). A direction across the arc is one angle in that frame: from u towards v. What
/// keeps its angle does not twist about the arc.
struct RegionArc {
  static constexpr int kPieces = 16;

  std::string name, line;
  std::array<int, 2> nodes{};
  double length = 0;
  std::array<Vec3, kPieces + 1> points, tangents, u, v;  ///< u × v = tangent
  /// ∫ of the curvature along u and along v: what the arc turns by towards them, radians.
  double turn_u = 0, turn_v = 0;

  bool closed() const { return nodes[0] == nodes[1]; }
  /// Unit direction away from the node at the start (false) or end (true).
  Vec3 out(bool end) const { return end ? Vec3(-tangents.back()) : tangents.front(); }
  double angle(bool end, const Vec3& across) const;
  Vec3 across(bool end, double angle) const;
  /// A direction across the arc at one end, carried to the other.
  Vec3 carried(bool from_end, const Vec3& across) const;
};

struct RegionGraph {
  std::vector<RegionArc> arcs;
  std::vector<Vec3> nodes;
  std::vector<std::vector<ArcEnd>> ends;  ///< arc ends at each node
  /// Arcs that lie on some cycle or between cycles: what is left when dangling arcs are taken off,
  /// and what dangles then, until none does.
  std::vector<bool> core;
  std::vector<bool> bridge;  ///< without the arc its part would fall apart
  std::vector<int> part;     ///< connected part of each arc, numbered in the order of arcs
  int part_count = 0;
  double size = 1;

  RegionGraph() = default;
  /// Makes the graph from the curves of a network. O(arcs).
  explicit RegionGraph(const CharacterLineNetwork& network);
  /// Makes it from polylines of two points or more between nodes. Throws InputError: fewer points,
  /// numbers that are not finite, no length.
  RegionGraph(std::vector<Vec3> nodes, std::vector<std::array<int, 2>> arc_nodes,
              const std::vector<std::vector<Vec3>>& polylines, std::vector<std::string> names);

  int node_before(const ArcUse& use) const { return arcs[use.arc].nodes[use.reversed]; }
  int node_after(const ArcUse& use) const { return arcs[use.arc].nodes[!use.reversed]; }
  /// Unit tangent in the direction of travel where the use begins and where it ends.
  Vec3 leaving(const ArcUse& use) const { return arcs[use.arc].out(use.reversed); }
  Vec3 arriving(const ArcUse& use) const { return -arcs[use.arc].out(!use.reversed); }
  /// Arcs of a name: of an arc's own, or of all arcs of a line; empty when there is none.
  std::vector<int> named(const std::string& name) const;
  /// Points along the loop, `per_arc` for each arc, none repeated.
  std::vector<Vec3> sampled(const ArcLoop& loop, int per_arc) const;

 private:
  void connect();
  void find_core();
  void find_parts();
};

/// A loop from its lowest arc on, in the direction that comes first: equal loops become the same.
ArcLoop canonical(const ArcLoop& loop);
/// Arcs of a loop, ascending.
std::vector<int> arcs_of(const ArcLoop& loop);

}  // namespace batten
