// Inside of make_nodes: what came together at nodes, and what the user is told of it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/network/arcs.h"
#include "batten/skinning/network/cuts.h"
#include "batten/skinning/network/network_contacts.h"

namespace batten::netting {

/// A place of a strand that may become part of a node.
struct Mark {
  int strand = 0;
  double s = 0;  ///< arc length
  int end = -1;  ///< 0, 1: of the strand; -1: inside of it
  Vec3 point;
  bool own = false;  ///< inside of its line, or a corner of it: the line passes through
};

/// Two marks that are near enough to become one node.
struct Link {
  int p, q;
  long long rank;  ///< distance in steps; links are taken in this order
  double distance;
  bool contact;
};

/// All marks, and the nodes that they became.
struct NodeMarks {
  std::vector<Mark> marks;
  std::vector<std::array<int, 2>> ends;   ///< marks of each strand's ends; -1: a closed strand
  std::vector<int> node_of;               ///< node of each mark
  std::vector<std::vector<int>> members;  ///< marks of each node, ascending
  std::vector<Link> refused;              ///< contacts that did not fit into one node
  /// Where each strand is cut: arc lengths, ascending, and nodes.
  struct Stop {
    double s;
    int node;
  };
  std::vector<std::vector<Stop>> stops;

  /// Largest distance of these marks from p.
  double radius(const std::vector<int>& some, const Vec3& p) const;
  /// Whether two marks of one strand belong to one pass of it through one node.
  bool same_place(const Strands& all, int p, int q, double tolerance) const;
};

/// Adds findings in sentences.
class NodeFindings {
 public:
  using Kind = NetworkFinding::Kind;
  NodeFindings(const Strands& all, double tolerance, const std::vector<CharacterLine>& lines,
               std::vector<NetworkFinding>& findings)
      : all_(all),
        strands_(all.strands),
        tolerance_(tolerance),
        lines_(lines),
        findings_(findings) {}

  /// Name of the line that the strand is a part of.
  const std::string& name_of(int strand) const { return lines_[strands_[strand].line].name; }
  void tell(Kind kind, std::vector<std::string> names, const Vec3& where, double distance,
            bool repaired, const std::string& text);

  /// Ends that were joined, lines that were cut, ends that meet nothing.
  void tell_of_nodes(const NodeMarks& marks, const NodesAndCuts& result);
  /// Places that come near each other without a common node.
  void tell_of_misses(const NodeMarks& marks, const Contacts& contacts);

 private:
  void tell_of_node(const NodeMarks& marks, const std::vector<int>& members, const Vec3& p,
                    bool left_out);
  void tell_of_dangling(const NodesAndCuts& result, const std::vector<int>& degrees);
  void tell_of_miss(const Contact& c, bool refused);
  std::vector<std::string> names_of(const std::vector<int>& strands) const;
  bool meet_nearby(const NodeMarks& marks, const Contact& c) const;

  const Strands& all_;
  const std::vector<Strand>& strands_;
  const double tolerance_;
  const std::vector<CharacterLine>& lines_;
  std::vector<NetworkFinding>& findings_;
};

}  // namespace batten::netting
