// A network as the search for regions needs it: arcs as polylines with frames, and which of them
// meet.
#pragma once

#include <array>
#include <string>
#include <vector>
#include <optional>

#include "batten/skinning/search/regions.h"

namespace batten {

/// An arc as kPieces straight pieces of equal parameter length, with a frame carried along it
/// without turning about the tangent (parallel transport, by double reflection; Wang, Jüttler,
/// Zheng, Liu 2008). A direction across the arc is one angle in that frame, from u towards v. A
/// direction that keeps its angle does not twist about the arc.
struct GraphEdge {
  static constexpr int kPieces = 16;

  std::string name, line;
  CharacterLine::Role role =
      CharacterLine::Role::Outline;  ///< inner curves and holes bound nothing
  std::array<int, 2> nodes{};
  double length = 0;
  std::array<Vec3, kPieces + 1> points, tangents, u, v;  ///< u × v = tangent
  /// ∫ of the curvature towards u and towards v: the angle by which the arc turns there, radians.
  double turning_u = 0, turning_v = 0;

  bool closed() const { return nodes[0] == nodes[1]; }
  /// Returns the unit direction away from the node at the start (false) or end (true).
  Vec3 out(bool end) const { return end ? Vec3(-tangents.back()) : tangents.front(); }
  double angle(bool end, const Vec3& across) const;
  Vec3 across(bool end, double angle) const;
  /// Returns a direction across the arc at one end, carried to the other end.
  Vec3 parallel_transported(bool from_end, const Vec3& across) const;
};

/// The graph that arcs and nodes make.
struct RegionGraph {
  std::vector<GraphEdge> edges;
  std::vector<Vec3> nodes;
  std::vector<std::vector<EdgeEnd>> ends;  ///< arc ends at each node
  /// Arcs of outlines that lie on a cycle or between cycles: what is left when dangling arcs are
  /// taken away again and again until none dangles.
  std::vector<bool> core;
  std::vector<bool> bridge;    ///< without the arc its part would be two
  std::vector<int> component;  ///< connected part of each arc, numbered in the order of arcs
  int component_count = 0;
  double size = 1;

  RegionGraph() = default;
  /// How an arc begins and ends.
  enum class EndTangents {
    OfPieces,  ///< as its first two pieces tell: small hooks of a hand do not count
    OfCurve    ///< as its curve does: at the nose of a section it does not run along the chord
  };
  /// Makes the graph from the curves of a network. O(arcs).
  explicit RegionGraph(const CurveNetwork& network, EndTangents tangents = EndTangents::OfPieces);
  /// Makes it from polylines of two points or more between nodes. Throws InputError: fewer points,
  /// numbers that are not finite, no length.
  RegionGraph(std::vector<Vec3> nodes, std::vector<std::array<int, 2>> edge_nodes,
              const std::vector<std::vector<Vec3>>& polylines, std::vector<std::string> names);

  int node_before(const OrientedEdge& use) const { return edges[use.edge].nodes[use.reversed]; }
  int node_after(const OrientedEdge& use) const { return edges[use.edge].nodes[!use.reversed]; }
  /// Return the unit tangent in the direction of travel where the use begins, and where it ends.
  Vec3 leaving(const OrientedEdge& use) const { return edges[use.edge].out(use.reversed); }
  Vec3 arriving(const OrientedEdge& use) const { return -edges[use.edge].out(!use.reversed); }
  /// Returns the arc of this name, or all arcs of the line of this name; empty when there is none.
  std::vector<int> edges_named(const std::string& name) const;
  /// Returns points along the loop, `per_edge` for each arc, none repeated.
  std::vector<Vec3> sampled(const EdgeLoop& loop, int per_edge) const;

 private:
  void connect();
  void find_core();
  void find_components();
};

/// Returns a loop from its lowest arc on, in the direction that comes first in order: equal loops
/// become the same.
EdgeLoop canonical(const EdgeLoop& loop);
/// Returns the arcs of a loop, ascending.
std::vector<int> edges_of(const EdgeLoop& loop);


// Loops of arcs that lie in one plane.

/// Sine of 15 degrees: corners nearer to straight have no plane.
inline constexpr double kMinCornerSine = 0.2588;

/// A loop in one plane, but for 3e-4 of the network's size.
struct PlanarFace {
  Vec3 at, normal;
  double tolerance = 0, area = 0;
  std::vector<Vec3> outline;  ///< a polygon, counter-clockwise around the normal
  /// Whether all points lie in the plane and inside of the outline, not on it.
  bool contains(const std::vector<Vec3>& points) const;
};
/// Returns nothing for a loop that lies in no plane.
std::optional<PlanarFace> planar_face(const RegionGraph& graph, const EdgeLoop& loop);

/// Whether an arc is straight, but for 1e-3 of its length.
bool is_straight(const GraphEdge& edge);

/// Returns at how many places straight arcs of a loop go on in curved ones, where all of it lies in
/// one plane but for 3e-4 of the network's size: the outline of a part that was drawn with straight
/// edges and fillets. 0 for any other loop.
int fillet_ends(const RegionGraph& graph, const EdgeLoop& loop);

/// Returns the loop that arrives by `in`, goes on by `out`, and then goes on by the arcs in the
/// plane of these two that turn most to the inside: a face of the plane graph that the arcs in this
/// plane make. `normal`: of the plane; the loop runs counter-clockwise around it. Empty where both
/// arcs do not lie in such a plane, the way does not come home, or runs around the outside.
/// O(arcs at the nodes of the loop).
EdgeLoop loop_in_plane(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out,
                       const Vec3& normal);

}  // namespace batten
