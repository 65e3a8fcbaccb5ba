// Sets of mesh files, options for writing these files, and what rounding cost.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// A set of a mesh file. A node set has nodes only, a face set faces only, as ascending indices,
/// each once. A node set and a face set may have the same name.
struct MeshSet {
  std::string name;   ///< its name; in LS-DYNA and Nastran its id
  std::string title;  ///< its title; in LS-DYNA only
  std::vector<int> nodes, faces;
};

/// An element of a deck that is no shell, or a connection of nodes, by its nodes. Where the deck
/// leaves a node out (an end to the ground, a middle node), it is not there.
struct OtherElement {
  enum class Kind {
    Solid,  ///< corners, then middle nodes, in the deck's order
    Beam,   ///< bars and beams too: the ends, then a node that gives its direction, if there is one
    Bush,   ///< springs, dampers, gaps, fasteners: as a beam
    Rigid,  ///< the independent node first
    Average,  ///< the reference node first, which follows the others
    Mass,     ///< one node
    Other     ///< something else
  };
  Kind kind = Kind::Other;
  std::string name;             ///< as the deck calls it: CHEXA, RBE2, C3D8, *MPC, …
  long label = 0;               ///< its number; 0 without one
  std::vector<int> nodes;       ///< indices of the mesh's nodes
  std::vector<double> weights;  ///< Average: one for each node but the first
};

/// How a mesh file is written.
struct MeshWriteOptions {
  /// In Nastran decks, small-field GRIDs (8 columns a number) that moved become large-field ones
  /// (GRID*, 16 columns, two lines). Other formats are not changed by it.
  bool wide_nodes = false;
  /// The folder into which a program moves the files in the end; empty: they stay where they are
  /// written. A deck of several files is not written where it would replace one that was read.
  std::filesystem::path appears_in = {};
};

/// What rounding to the file's fields cost.
struct MeshRounding {
  double largest = 0;  ///< largest |written - given| of one coordinate, model units
  long at_label = -1;  ///< number of that node; -1 when every coordinate was written exactly
};

}  // namespace batten
