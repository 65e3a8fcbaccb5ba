// SPDX-License-Identifier: MPL-2.0
// Merges contacts and curve ends into network nodes and splits the sampled curves at them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/network/contacts.h"
#include "batten/skinning/network/network_edge.h"

namespace batten::detail {

// Curve segments between nodes.

/// A segment of a sampled curve between two nodes.
struct CurveInterval {
  int sampled_curve = 0;
  /// Arc lengths of its ends; s1 above the curve's length: crosses the seam.
  double s0 = 0, s1 = 0;
  std::array<int, 2> nodes{};
  std::vector<int> shared;  ///< input curves that coincide with this segment and were removed
};

/// Nodes and the curve segments between them.
struct NetworkTopology {
  std::vector<Vec3> nodes;               ///< node positions, model units
  std::vector<CurveInterval> intervals;  ///< ordered by sampled curve, then along it

  /// Number of segment ends at each node (valence).
  std::vector<int> degrees() const;
};

/// Merges curve ends, contacts and corners into nodes, and splits the curves there.
///
/// Candidates are merged in order of increasing distance. Two nodes are merged only if all their
/// points then lie within `tolerance` of the merged node. Its position is the mean of the points in
/// the interior and at the corners of curves if there are any, otherwise the mean of the ends.
/// Repairs, removed segments and defects are appended to `diagnostics`.
NetworkTopology make_nodes(const SampledCurves& sampled_curves, const Contacts& contacts,
                           double tolerance, const std::vector<CharacterLine>& lines,
                           std::vector<NetworkDiagnostic>& diagnostics);

// Implementation details of make_nodes().

/// A point of a sampled curve that may become part of a node.
struct NodeCandidate {
  int sampled_curve = 0;
  double s = 0;  ///< arc length from the start of the curve, model units
  int end = -1;  ///< 0 or 1: start or end of the curve; -1: interior point
  Vec3 point;
  bool own = false;  ///< the input curve passes through: an interior point or a corner of it
};

/// Two node candidates that are close enough to be merged.
struct MergeCandidate {
  int p, q;
  long long rank;  ///< distance, rounded to 2⁻²⁰ tolerances; candidates are merged in this order
  double distance;
  bool contact;
};

/// All node candidates and the nodes into which they were merged.
struct NodeCandidates {
  std::vector<NodeCandidate> candidates;
  std::vector<std::array<int, 2>> ends;  ///< candidates at the ends of each curve; -1: closed curve
  std::vector<int> node_of;              ///< node of each candidate
  std::vector<std::vector<int>> members;  ///< candidates of each node, ascending
  std::vector<MergeCandidate> rejected;  ///< contacts that could not be merged within the tolerance
  /// Positions at which each sampled curve is split: arc length (ascending) and node.
  struct SplitPoint {
    double s;
    int node;
  };
  std::vector<std::vector<SplitPoint>> split_points;

  /// Largest distance of the given candidates from p.
  double radius(const std::vector<int>& some, const Vec3& p) const;
  /// True if two candidates of one curve belong to the same passage of it through one node.
  bool is_same_passage(const SampledCurves& all, int p, int q, double tolerance) const;
};

/// Formats diagnostics as sentences for the user and collects them.
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

  /// Name of the input curve to which a sampled curve belongs.
  const std::string& name_of(int sampled_curve) const {
    return lines_[sampled_curves_[sampled_curve].line].name;
  }
  void add(Kind kind, std::vector<std::string> names, const Vec3& where, double distance,
           bool repaired, const std::string& text);

  /// Reports merged ends, split curves and dangling ends.
  void report_nodes(const NodeCandidates& candidates, const NetworkTopology& result);
  /// Reports points that come close to each other without a common node.
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
