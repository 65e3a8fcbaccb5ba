// SPDX-License-Identifier: MPL-2.0
// Edges, nodes and diagnostics of a curve network.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// One end of a network edge.
struct EdgeEnd {
  int edge = -1;
  bool end = false;  ///< true: end of the edge; false: start of the edge
  bool operator==(const EdgeEnd&) const = default;
};

/// A network edge: the smooth part of an input curve between two nodes.
struct NetworkEdge {
  std::string name;  ///< name of the input curve; "name.1", "name.2", … if the curve was split
  int line = 0;      ///< index into CurveNetwork::lines()
  /// True if the edge runs against the input curve. The orientation of edges is canonical: it does
  /// not depend on the direction of the input curves.
  bool reversed = false;
  /// C1 cubic curve of the edge, exactly from the position of nodes[0] to that of nodes[1].
  ///
  /// The parameter t runs from 0 to (arc length / network size), rounded to a multiple of 2⁻³⁰,
  /// with almost constant parametric speed ≈ network size. The values of t therefore do not depend
  /// on the length unit. At an end at which another edge continues this one, the derivatives of
  /// both edges are bit-identical, up to sign.
  HermiteCurve curve;
  /// The part of the input curve that this edge represents, in the direction of the edge.
  std::shared_ptr<const InputCurve> input;
  std::array<int, 2> nodes{};  ///< node indices at start and end; equal for a closed edge
  std::array<EdgeEnd, 2>
      continuation{};  ///< edge ends that continue this edge at its start and end; edge = -1: none
  double length = 0;   ///< arc length, model units
  double deviation = 0;  ///< largest distance between `curve` and `input`, model units
};

/// A node of the network: a common end point of edges.
struct NetworkNode {
  Vec3 position;
  /// Edge ends at this node; a closed edge contributes both of its ends.
  std::vector<EdgeEnd> ends;
};

/// A message about the network for the user: a repair or a possible defect. Positions and distances
/// are in model units.
struct NetworkDiagnostic {
  enum class Kind {
    EndsJoined,    ///< curve ends with a gap between them were merged into one node
    EndOnLine,     ///< T-junction: an end met the interior of a curve, which was split there
    Crossing,      ///< two curves crossed and were split at the crossing
    SelfCrossing,  ///< a curve crossed itself and was split at the crossing
    Duplicate,     ///< a curve coincided with another curve entirely; removed
    Overlap,       ///< two curves coincide in part; the common part is kept once
    NearMiss,      ///< gap of 1 to 5 tolerances at an end or crossing; not joined
    Dangling,      ///< a dangling end: a curve end that meets no other curve
    Short,  ///< a curve or segment shorter than the tolerance; removed unless it connects two nodes
    Disconnected  ///< curves that are not connected to the largest component of the network
  };
  Kind kind;
  std::vector<std::string> lines;  ///< names of the input curves involved
  Vec3 where = Vec3::Zero();
  double distance = 0;    ///< width of the gap; length of the curve for Kind::Short
  bool repaired = false;  ///< true: the problem is repaired; false: only reported
  std::string text;       ///< the message, a sentence for the user
};

}  // namespace batten
