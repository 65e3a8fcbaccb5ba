// SPDX-License-Identifier: MPL-2.0
// Displacement boundary conditions of CalculiX decks of a model.
#pragma once

#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "batten/io/decks/deck_elements.h"

namespace batten {

/// The supports of a deck as node sets, local coordinate systems and rows of *BOUNDARY.
///
/// Supports along the axes x, y, z refer to the set of their curve, or to a set SUPPORT_1, SUPPORT_2,
/// … of their own. Nodes of other supports get a local coordinate system (*TRANSFORM) in which each
/// of their conditions concerns one component.
class DeckSupports {
 public:
  /// `line_sets`: name of the node set of each of model.lines. Throws DeckLimitError if directions
  /// and rotations at a node have no common coordinate system, InputError for a support without nodes.
  DeckSupports(const std::vector<const SkinnedRegion*>& regions, const ModelElements& model,
               const DeckDiscretization& elements, const ShellDeck& deck,
               const std::vector<std::string>& line_sets);

  void write_sets(std::ostream& out) const;      ///< *NSET and *TRANSFORM
  void write_boundary(std::ostream& out) const;  ///< rows of *BOUNDARY
  /// A vector at a node in the coordinate system of its loads.
  Vec3 local(int node, const Vec3& v) const;

 private:
  // Conditions of one node in the local coordinate system `axes`.
  struct Node {
    std::vector<Vec3> directions, rotations;
    std::vector<double> values;
    Mat3 axes = Mat3::Identity();
  };
  struct Set {
    std::string name;
    std::vector<int> nodes;  // empty: the set of a curve
    const ShellDeck::Support* support;
  };
  void find_axes();

  double load_factor_;
  std::vector<Set> sets_;
  std::map<int, Node> nodes_;  // of supports that are not along the axes
};

}  // namespace batten
