// What mesh files have beside the mesh, and what writing them takes and tells.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// A node set has nodes only, a face set faces only; ascending, none twice. One of each may share
/// a name.
struct MeshSet {
  std::string name;   ///< LS-DYNA, Nastran: the id
  std::string title;  ///< LS-DYNA only
  std::vector<int> nodes, faces;
};

struct MeshWriteOptions {
  /// Nastran: small-field GRIDs (8 columns a number) that moved become large-field ones (GRID*, 16
  /// columns, two lines). Other formats have nothing wider.
  bool wide_nodes = false;
};

struct MeshRounding {
  double largest = 0;  ///< |written - given| of one coordinate, model units
  long at_label = -1;  ///< node where; -1 when every coordinate was written exactly
};

}  // namespace batten
