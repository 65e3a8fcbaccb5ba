// Character lines as one network: arcs between nodes.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/network/network_edge.h"

namespace batten {

struct NetworkOptions {
  /// Ends and lines that come nearer than this meet, model units. 0: 1e-3 of the size; where less
  /// than half of the lines' ends and crossings then meet another line, as in drawings by hand, what
  /// the ends' gaps to the nearest other line ask for (an end that runs out beyond a crossing by less than
  /// 2e-2 of the size meets what it crosses). Of the gaps up to 2e-2 of the size (half of all ends
  /// at least must have one) it is 1.4 times the largest, where that is at most twice the one that
  /// four fifths do not exceed, and 1.4 times the latter otherwise; never above 2e-2 of the size.
  double tolerance = 0;
  /// Largest distance between a line and the curves of its arcs where nothing had to be repaired,
  /// model units. 0: 1e-4 of the size.
  double fit_tolerance = 0;
  /// A line is cut where it turns by more, degrees.
  double corner_angle = 20;
  /// Two arcs that meet at a node and go on in one direction within this angle get one tangent
  /// there, degrees; those of one line do in any case (it is C1). Each end has one partner at most,
  /// the straightest.
  double tangent_angle = 20;
};

/// Lines joined where their ends meet each other or the middle of other lines, and cut where they
/// cross.
///
/// The result depends on the lines as curves only (arcs are ordered and directed by where they lie;
/// names move with their lines): shuffled lines make the same bits, lines given backwards the same
/// nodes and arcs to rounding. Nodes and arcs are in that canonical order. A closed smooth line
/// that meets nothing has one node, where it lies farthest along a fixed direction.
///
/// Repairs move a curve by no more than the tolerance: ends are drawn to their common node (the
/// mean of ends; a line's own point where an end meets its middle or a corner), fading out along
/// the arc; turning to a common tangent moves it by half a tolerance more at most. A node takes no
/// more ends than lie within the tolerance of it, the nearest first; what is left over is a near
/// miss. Lines touch, rather than overlap, where they run along each other for less than
/// 3 √(tolerance · size), unless they coincide.
/// What is repaired and what is only listed: NetworkDiagnostic.
class CurveNetwork {
 public:
  /// Throws InputError: no line, two lines of one name, a line without curve or length, numbers
  /// that are not finite, a tolerance below 0, lines that are drawn over each other again and again.
  /// Cost: about O(n log n) for n lines of bounded length.
  explicit CurveNetwork(const std::vector<CharacterLine>& lines, const NetworkOptions& options = {},
                        const Progress& progress = {});

  const std::vector<CharacterLine>& lines() const { return lines_; }  ///< the lines as given
  const std::vector<NetworkEdge>& edges() const { return edges_; }
  const std::vector<NetworkNode>& nodes() const { return nodes_; }
  const std::vector<NetworkDiagnostic>& diagnostics() const { return diagnostics_; }
  /// Diagonal of the box around all lines, model units.
  double size() const { return size_; }
  double tolerance() const { return tolerance_; }
  /// Share of the lines' ends that meet another line within 1e-3 of the size; with the places at
  /// which lines cross where less than half of the ends do; 1 where a tolerance was asked for. Below 0.5, a larger tolerance() was looked for (NetworkOptions).
  double joined_fraction() const { return joined_fraction_; }
  /// Indices of the arcs that have a name, their own or that of their line, along the line.
  /// Throws InputError, with the nearest name, when there is none.
  std::vector<int> edges_of(const std::string& name) const;
  /// Unit tangent of an arc at an end, away from the node.
  Vec3 direction(const EdgeEnd& end) const;

 private:
  std::vector<CharacterLine> lines_;
  std::vector<NetworkEdge> edges_;
  std::vector<NetworkNode> nodes_;
  std::vector<NetworkDiagnostic> diagnostics_;
  std::vector<std::vector<int>> edges_of_line_;
  double size_ = 1, tolerance_ = 0, joined_fraction_ = 1;
};

}  // namespace batten
