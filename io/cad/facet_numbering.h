// Numbers the nodes of triangulated faces, one on each place of common edges, and measures them.
// Internal.
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "batten/io/cad/cad_facets.h"
#include "batten/io/cad/cad_parts.h"

namespace batten {

/// The triangles on the faces of `parts`, which are those of `shape`, as one mesh in millimetres:
/// triangles without area at poles are left out. Nodes on common edges come to one place in the
/// triangulations too. `curved`: with normals. Sets all numbers but size, chord and contents.
CadFacets number_facets(const std::vector<CadPart>& parts, const TopoDS_Shape& shape, bool curved);

}  // namespace batten
