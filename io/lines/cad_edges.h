// Curves and names of the edges of CAD files. Internal.
#pragma once

#include <Geom_Curve.hxx>
#include <TopoDS_Edge.hxx>
#include <string>
#include <vector>

#include "batten/io/cad/cad_file.h"

namespace batten {

/// The edge's curve where it lies in space, or null for an edge without length.
Handle(Geom_Curve) curve_of(const TopoDS_Edge& edge, double& start, double& end);

/// The names of a file's edges as lines, in its order: read_cad_lines() says which; "" for those without
/// length.
std::vector<std::string> edge_names(const CadFile& cad);

}  // namespace batten
