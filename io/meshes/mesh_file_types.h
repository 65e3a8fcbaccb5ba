// Basic types of mesh files: sets, write options, and the rounding error of a written file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A named set of nodes or of faces in a mesh file. One of the two lists is empty; the other holds
/// ascending, unique indices. A node set and a face set may have the same name.
struct MeshSet {
  std::string name;   ///< name; in LS-DYNA and Nastran the id
  std::string title;  ///< title (LS-DYNA only)
  std::vector<int> nodes, faces;
  std::string colour = {};  ///< colour of the faces, "#rrggbb"; empty: none
};

/// Options for writing a mesh file.
struct MeshWriteOptions {
  /// Nastran only: moved small-field GRIDs (8 columns per number) are written as large-field GRIDs
  /// (GRID*, 16 columns, two lines). Ignored by other formats.
  bool large_field_nodes = false;
  /// Final folder, for callers that write to a temporary folder and then move the files; empty:
  /// files stay where they are written. A deck of several files is rejected if it would overwrite a
  /// file that was read.
  std::filesystem::path destination_folder = {};
};

/// Rounding error caused by the width of the file's number fields.
struct MeshRounding {
  double largest = 0;         ///< largest |written − given| of a coordinate, in model units
  long max_error_label = -1;  ///< number (label) of that node; -1: all coordinates are exact
};

}  // namespace batten
