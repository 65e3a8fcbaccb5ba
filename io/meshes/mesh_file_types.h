// SPDX-License-Identifier: MPL-2.0
// Basic types for mesh files: sets, options for writing, and the rounding error of a written file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A named set of nodes or of faces in a mesh file. One of the two lists is empty; the other one
/// contains unique indices in ascending order. A node set and a face set may have the same name.
struct MeshSet {
  std::string name;   ///< name of the set; in LS-DYNA and Nastran its id
  std::string title;  ///< title of the set; LS-DYNA only
  std::vector<int> nodes, faces;
  std::string colour = {};  ///< colour of the faces, "#rrggbb"; empty: no colour
};

/// Options for writing a mesh file.
struct MeshWriteOptions {
  /// Nastran only. True: moved GRID cards in small-field format (8 columns per number) are written
  /// in large-field format (GRID*, 16 columns per number, two lines).
  bool large_field_nodes = false;
  /// Final folder of the files, for callers that write to a temporary folder and then move the
  /// files. Empty: the files stay where they are written. A deck of several files is rejected if it
  /// would overwrite a file that was read.
  std::filesystem::path destination_folder = {};
};

/// Rounding error of the written coordinates, caused by the limited width of number fields, and
/// what the file says about directions.
struct MeshRounding {
  double largest = 0;  ///< largest |written − given| of a coordinate, model units
  /// Number in the file of the node with the largest rounding error; -1: all coordinates are exact.
  long max_error_label = -1;
  /// Sentences about cards with directions that are not rotated with the mesh, or only on average.
  std::vector<std::string> notes = {};
};

}  // namespace batten
