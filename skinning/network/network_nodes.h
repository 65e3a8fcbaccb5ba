// Which places of lines are one node, and the pieces between nodes.
#pragma once

#include <vector>
#include <array>
#include <string>

#include "batten/skinning/network/contacts.h"
#include "batten/skinning/network/network_edge.h"
#include "batten/core/eigen.h"

namespace batten::detail {

// Pieces of strands between nodes. Internal.

/// A piece of a strand between two nodes.
struct CurveInterval {
  int sampled_curve = 0;
  double s0 = 0, s1 = 0;  ///< arc lengths; s1 above the strand's length: across its seam
  std::array<int, 2> nodes{};
  std::vector<int> shared;  ///< lines that ran along it, whose piece was left out
};

struct NetworkTopology {
  std::vector<Vec3> nodes;               ///< positions
  std::vector<CurveInterval> intervals;  ///< by strand, along it

  /// Number of ends of cuts at each node.
  std::vector<int> degrees() const;
};


/// Ends, contacts and corners become nodes, the nearest first: two nodes become one where all
/// places then lie within the tolerance of the new one, which is the mean of the places inside of
/// lines and at their corners where there are any, of ends otherwise. What is repaired, left out
/// and found is added to `diagnostics`.
NetworkTopology make_nodes(const SampledCurves& sampled_curves, const Contacts& contacts,
                           double tolerance, const std::vector<CharacterLine>& lines,
                           std::vector<NetworkDiagnostic>& diagnostics);


// Inside of make_nodes: what came together at nodes, and what the user is told of it.

/// A place of a strand that may become part of a node.
struct NodeCandidate {
  int sampled_curve = 0;
  double s = 0;  ///< arc length
  int end = -1;  ///< 0, 1: of the strand; -1: inside of it
  Vec3 point;
  bool own = false;  ///< inside of its line, or a corner of it: the line passes through
};

/// Two marks that are near enough to become one node.
struct MergeCandidate {
  int p, q;
  long long rank;  ///< distance in steps; links are taken in this order
  double distance;
  bool contact;
};

/// All marks, and the nodes that they became.
struct NodeCandidates {
  std::vector<NodeCandidate> candidates;
  std::vector<std::array<int, 2>> ends;   ///< marks of each strand's ends; -1: a closed strand
  std::vector<int> node_of;               ///< node of each mark
  std::vector<std::vector<int>> members;  ///< marks of each node, ascending
  std::vector<MergeCandidate> rejected;   ///< contacts that did not fit into one node
  /// Where each strand is cut: arc lengths, ascending, and nodes.
  struct SplitPoint {
    double s;
    int node;
  };
  std::vector<std::vector<SplitPoint>> split_points;

  /// Largest distance of these marks from p.
  double radius(const std::vector<int>& some, const Vec3& p) const;
  /// Whether two marks of one strand belong to one pass of it through one node.
  bool is_same_passage(const SampledCurves& all, int p, int q, double tolerance) const;
};

/// Adds findings in sentences.
class NodeDiagnostics {
 public:
  using Kind = NetworkDiagnostic::Kind;
  NodeDiagnostics(const SampledCurves& all, double tolerance,
                  const std::vector<CharacterLine>& lines,
                  std::vector<NetworkDiagnostic>& diagnostics)
      : all_(all),
        sampled_curves_(all.sampled_curves),
        tolerance_(tolerance),
        lines_(lines),
        diagnostics_(diagnostics) {}

  /// Name of the line that the strand is a part of.
  const std::string& name_of(int sampled_curve) const {
    return lines_[sampled_curves_[sampled_curve].line].name;
  }
  void add(Kind kind, std::vector<std::string> names, const Vec3& where, double distance,
           bool repaired, const std::string& text);

  /// Ends that were joined, lines that were cut, ends that meet nothing.
  void report_nodes(const NodeCandidates& candidates, const NetworkTopology& result);
  /// Places that come near each other without a common node.
  void report_near_misses(const NodeCandidates& candidates, const Contacts& contacts);

 private:
  void report_node(const NodeCandidates& candidates, const std::vector<int>& members, const Vec3& p,
                   bool left_out);
  void report_dangling_ends(const NetworkTopology& result, const std::vector<int>& degrees);
  void report_near_miss(const Contact& c, bool rejected);
  std::vector<std::string> names_of(const std::vector<int>& sampled_curves) const;
  bool meet_nearby(const NodeCandidates& candidates, const Contact& c) const;

  const SampledCurves& all_;
  const std::vector<SampledCurve>& sampled_curves_;
  const double tolerance_;
  const std::vector<CharacterLine>& lines_;
  std::vector<NetworkDiagnostic>& diagnostics_;
};

}  // namespace batten::detail
