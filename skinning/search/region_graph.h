// SPDX-License-Identifier: MPL-2.0
// The graph on which regions are searched: edges as framed polylines, nodes, and their incidence.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/search/regions.h"

namespace batten {

/// An edge as a polyline of kPieces segments of equal parameter length, with a parallel-transported
/// (rotation-minimising) frame, computed by double reflection [Wang2008].
///
/// A direction across the edge is one angle in the frame, from u towards v. A direction with a
/// constant angle does not twist about the edge.
struct GraphEdge {
  static constexpr int kPieces = 16;

  /// Name of the edge, and of its input curve.
  std::string name, line;
  CharacterLine::Role role =
      CharacterLine::Role::Outline;  ///< role of the input curve; only outlines bound regions
  std::array<int, 2> nodes{};
  double length = 0;
  std::array<Vec3, kPieces + 1> points, tangents, u, v;  ///< u × v = tangent
  /// ∫ of the curvature vector's components along u and v: the angles by which the edge turns,
  /// radians.
  double turning_u = 0, turning_v = 0;

  /// True if the edge starts and ends at the same node.
  bool closed() const { return nodes[0] == nodes[1]; }
  /// Unit tangent at the start (end = false) or end (true) that points away from the node.
  Vec3 out(bool end) const { return end ? Vec3(-tangents.back()) : tangents.front(); }
  /// Angle in radians of a direction across the edge, in the frame at its start or end.
  double angle(bool end, const Vec3& across) const;
  /// Unit direction across the edge with this angle in the frame at its start or end; inverse of
  /// angle().
  Vec3 across(bool end, double angle) const;
  /// Parallel-transports a direction across the edge from one end to the other.
  Vec3 parallel_transported(bool from_end, const Vec3& across) const;
};

/// The edges and nodes of a curve network, with incidence and connectivity.
struct RegionGraph {
  std::vector<GraphEdge> edges;
  std::vector<Vec3> nodes;
  std::vector<std::vector<EdgeEnd>> ends;  ///< edge ends at each node
  /// For each edge, true if it belongs to an outline and lies on a cycle or on a path between
  /// cycles: what remains after dangling edges are removed repeatedly.
  std::vector<bool> core;
  std::vector<bool> bridge;    ///< removing the edge would disconnect its component
  std::vector<int> component;  ///< connected component of each edge, in the order of edges
  int component_count = 0;
  /// Size of the network (bounding-box diagonal), model units.
  double size = 1;

  RegionGraph() = default;
  /// How the tangents at the ends of edges are computed.
  enum class EndTangents {
    OfPieces,  ///< from the first two segments; ignores small hooks in sketches
    OfCurve    ///< exact, from the curve; needed at the nose of an aerofoil
  };
  /// Builds the graph of a curve network. Cost: O(edges).
  explicit RegionGraph(const CurveNetwork& network, EndTangents tangents = EndTangents::OfPieces);
  /// Builds a graph from polylines between nodes. Throws InputError if a polyline has fewer than
  /// two points, non-finite coordinates or zero length.
  RegionGraph(std::vector<Vec3> nodes, std::vector<std::array<int, 2>> edge_nodes,
              const std::vector<std::vector<Vec3>>& polylines, std::vector<std::string> names);

  /// Node at which the use of an edge starts.
  int node_before(const OrientedEdge& use) const { return edges[use.edge].nodes[use.reversed]; }
  /// Node at which the use of an edge ends.
  int node_after(const OrientedEdge& use) const { return edges[use.edge].nodes[!use.reversed]; }
  /// Unit tangents in the direction of travel, at the start (leaving) and end (arriving) of the
  /// use.
  Vec3 leaving(const OrientedEdge& use) const { return edges[use.edge].out(use.reversed); }
  Vec3 arriving(const OrientedEdge& use) const { return -edges[use.edge].out(!use.reversed); }
  /// The edge with this name, or all edges of the input curve with this name; empty if there is
  /// none.
  std::vector<int> edges_named(const std::string& name) const;
  /// Samples the loop at `per_edge` points per edge, without repeated points.
  std::vector<Vec3> sampled(const EdgeLoop& loop, int per_edge) const;

 private:
  void connect();
  void find_core();
  void find_components();
};

/// Canonical form of a loop: starts at its lowest edge, in the lexicographically smaller direction.
/// Equal loops get equal forms.
EdgeLoop canonical(const EdgeLoop& loop);
/// Edges of a loop, ascending.
std::vector<int> edges_of(const EdgeLoop& loop);

// Planar loops.

/// sin 15°: the minimum sine of the angle between two edges at a corner that defines a plane.
inline constexpr double kMinCornerSine = 0.2588;

/// A loop that is planar within 3e-4 of the network size.
struct PlanarFace {
  Vec3 at, normal;
  double tolerance = 0, area = 0;
  std::vector<Vec3> outline;  ///< polygon, counter-clockwise around the normal
  /// True if all points lie in the plane and strictly inside the outline (not on it).
  bool contains(const std::vector<Vec3>& points) const;
};
/// Fits a plane to a loop; empty if the loop is not planar.
std::optional<PlanarFace> planar_face(const RegionGraph& graph, const EdgeLoop& loop);

/// True if an edge is straight within 1e-3 of its length.
bool is_straight(const GraphEdge& edge);

/// Number of points at which a straight edge of the loop continues smoothly in a curved one, if the
/// loop is planar within 3e-4 of the network size: the outline of a part with straight edges and
/// fillets. 0 for any other loop.
int fillet_ends(const RegionGraph& graph, const EdgeLoop& loop);

/// Traces a planar face: the loop that arrives by `in`, leaves by `out`, and at each node takes the
/// edge in their plane that turns most to the inside.
///
/// `normal`: normal of the plane; the loop runs counter-clockwise around it. Returns an empty loop
/// if the two edges do not lie in such a plane, or if the path does not close, exceeds 200 edges or
/// runs around the outside. Cost: O(edges at the nodes of the loop).
EdgeLoop loop_in_plane(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out,
                       const Vec3& normal);

}  // namespace batten
