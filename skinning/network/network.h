// Character lines as one network: arcs between nodes.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fem/curve.h"
#include "batten/skinning/character_line.h"

namespace batten {

struct NetworkOptions {
  /// Ends and lines that come nearer than this meet, model units. 0: 1e-3 of the size.
  double tolerance = 0;
  /// Largest distance between a line and the curves of its arcs where nothing had to be repaired,
  /// model units. 0: 1e-4 of the size.
  double fit_tolerance = 0;
  /// A line is cut where it turns by more, degrees.
  double corner_angle = 20;
  /// Two arcs that meet at a node and go on in one direction within this angle get one tangent
  /// there, degrees; those of one line do in any case (it is C1). Each end has one partner at most,
  /// the straightest.
  double straight_angle = 20;
};

/// One end of an arc.
struct ArcEnd {
  int arc = -1;
  bool end = false;  ///< the arc's end, otherwise its start
  bool operator==(const ArcEnd&) const = default;
};

/// A piece of a character line between two nodes.
struct NetworkArc {
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
  std::array<ArcEnd, 2> on{};  ///< the arc end that goes on at its start, end; arc -1: none
  double length = 0;           ///< model units
  double deviation = 0;        ///< largest distance of `curve` from `input`, model units
};

struct NetworkNode {
  Vec3 position;
  std::vector<ArcEnd> ends;  ///< arc ends that meet here; of a closed arc both
};

/// Something about the network that the user should know. Positions in model units.
struct NetworkFinding {
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
    Apart          ///< a part of the network without connection to the rest
  };
  Kind kind;
  std::vector<std::string> lines;  ///< names, as given
  Vec3 where = Vec3::Zero();
  double distance = 0;    ///< how far apart they were
  bool repaired = false;  ///< otherwise only listed
  std::string text;       ///< a sentence for the user
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
/// What is repaired and what is only listed: NetworkFinding.
class CharacterLineNetwork {
 public:
  /// Throws InputError: no line, two lines of one name, a line without curve or length, numbers
  /// that are not finite, a tolerance below 0. Cost: about O(n log n) for n lines of bounded
  /// length.
  explicit CharacterLineNetwork(const std::vector<CharacterLine>& lines,
                                const NetworkOptions& options = {}, const Progress& progress = {});

  const std::vector<CharacterLine>& lines() const { return lines_; }  ///< the lines as given
  const std::vector<NetworkArc>& arcs() const { return arcs_; }
  const std::vector<NetworkNode>& nodes() const { return nodes_; }
  const std::vector<NetworkFinding>& findings() const { return findings_; }
  /// Diagonal of the box around all lines, model units.
  double size() const { return size_; }
  double tolerance() const { return tolerance_; }
  /// Indices of the arcs that have a name, their own or that of their line, along the line.
  /// Throws InputError, with the nearest name, when there is none.
  std::vector<int> arcs_of(const std::string& name) const;
  /// Unit tangent of an arc at an end, away from the node.
  Vec3 direction(const ArcEnd& end) const;

 private:
  std::vector<CharacterLine> lines_;
  std::vector<NetworkArc> arcs_;
  std::vector<NetworkNode> nodes_;
  std::vector<NetworkFinding> findings_;
  std::vector<std::vector<int>> arcs_of_line_;
  double size_ = 1, tolerance_ = 0;
};

}  // namespace batten
