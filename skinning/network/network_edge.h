// Arcs, nodes and findings of a network of lines.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// One end of an arc.
struct EdgeEnd {
  int edge = -1;
  bool end = false;  ///< the arc's end, otherwise its start
  bool operator==(const EdgeEnd&) const = default;
};

/// A piece of a character line between two nodes.
struct NetworkEdge {
  std::string name;  ///< name of its line; "name.1", "name.2", … along a line that was cut
  int line = 0;      ///< index into the lines as they were given
  /// Runs against the line as it was given: arcs have a direction of their own, that of the
  /// network.
  bool reversed = false;
  /// X(t), C1, from nodes[0] to nodes[1] exactly. t runs from 0 to arc length / size of the
  /// network, rounded to 2⁻³⁰ and at even speed, |X'| ≈ size: the same numbers in mm and in m. At
  /// an end that goes on (`on`), X' is the same vector on both sides to the last bit, up to sign.
  HermiteCurve curve;
  /// The piece of the user's line that the arc is, in the arc's direction.
  std::shared_ptr<const InputCurve> input;
  std::array<int, 2> nodes{};  ///< nodes at its start and end; equal: closed
  std::array<EdgeEnd, 2>
      continuation{};    ///< the arc end that goes on at its start, end; arc -1: none
  double length = 0;     ///< model units
  double deviation = 0;  ///< largest distance of `curve` from `input`, model units
};

struct NetworkNode {
  Vec3 position;
  std::vector<EdgeEnd> ends;  ///< arc ends that meet here; of a closed arc both
};

/// Something about the network that the user should know. Positions in model units.
struct NetworkDiagnostic {
  enum class Kind {
    EndsJoined,    ///< ends that lay apart are one node now
    EndOnLine,     ///< T-junction: an end that met the middle of a line, which was cut there
    Crossing,      ///< two lines that crossed, cut there
    SelfCrossing,  ///< a line that crossed itself, cut there
    Duplicate,     ///< a line that runs along another one from end to end, left out
    Overlap,       ///< lines that run along each other in part; shared pieces are kept once
    NearMiss,      ///< an end, or a crossing, that lies apart by 1 to 5 tolerances: not joined
    Dangling,      ///< an end that meets nothing
    Short,         ///< a line or piece shorter than the tolerance, left out
    Disconnected   ///< a part of the network without connection to the rest
  };
  Kind kind;
  std::vector<std::string> lines;  ///< names, as given
  Vec3 where = Vec3::Zero();
  double distance = 0;    ///< how far apart they were
  bool repaired = false;  ///< otherwise only listed
  std::string text;       ///< a sentence for the user
};

}  // namespace batten
