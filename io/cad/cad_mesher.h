// Meshes the parts of a CAD document. Internal.
#pragma once

#include <vector>

#include "batten/io/cad/cad_facets.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"

namespace batten {

/// Parts whose faces hang together by edges as far as they lie on each other.
struct JoinedParts {
  std::vector<CadPart> parts;
  bool sewn = false;  ///< whether they are no longer the document's own
  double size = 0;    ///< mm
};
JoinedParts joined_parts(const CadFile& cad);

/// Meshes the parts, in millimetres, and leaves the triangulations on their shapes; `chord` 0: 1e-3
/// of the size; `curved`: with normals. The result lacks contents.
CadFacets mesh_parts(const std::vector<CadPart>& parts, double size, double chord,
                     bool curved = false);

}  // namespace batten
