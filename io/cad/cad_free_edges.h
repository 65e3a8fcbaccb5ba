// Edges of CAD shapes that have one face only. Internal.
#pragma once

#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Shape.hxx>

#include "batten/io/cad/cad_parts.h"

namespace batten {

/// The edges of a shape beside which one face lies, once; no seams, none without length. A closed
/// shape has none. O(edges).
TopTools_IndexedMapOfShape free_edges_of(const TopoDS_Shape& shape);

/// The shape with edges within `tolerance` of each other made one; faces in `faces` become those of
/// the result and keep their names; those that sewing drops are left out. Solids become shells, and
/// closed shells look outwards.
TopoDS_Shape sewn(const TopoDS_Shape& shape, double tolerance,
                  std::vector<CadFace>* faces = nullptr);

}  // namespace batten
