// Sets of mesh files, options for writing these files, and what rounding cost.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A set of a mesh file. A node set has nodes only, a face set faces only, as ascending indices,
/// each once. A node set and a face set may have the same name.
struct MeshSet {
  std::string name;   ///< its name; in LS-DYNA and Nastran its id
  std::string title;  ///< its title; in LS-DYNA only
  std::vector<int> nodes, faces;
  std::string colour = {};  ///< of the faces, "#rrggbb"; "" for none
};

/// How a mesh file is written.
struct MeshWriteOptions {
  /// In Nastran decks, small-field GRIDs (8 columns a number) that moved become large-field ones
  /// (GRID*, 16 columns, two lines). Other formats are not changed by it.
  bool large_field_nodes = false;
  /// The folder into which a program moves the files in the end; empty: they stay where they are
  /// written. A deck of several files is not written where it would replace one that was read.
  std::filesystem::path destination_folder = {};
};

/// What rounding to the file's fields cost.
struct MeshRounding {
  double largest = 0;         ///< largest |written - given| of one coordinate, model units
  long max_error_label = -1;  ///< number of that node; -1 when every coordinate was written exactly
};

}  // namespace batten
