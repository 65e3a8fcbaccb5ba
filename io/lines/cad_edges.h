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


// CAD files as a model is fitted to them. Internal.

/// Faces of which each has edges of its own, as those of IGES files, share them where they lie within 1e-5 of the
/// size of each other. Then faces are divided along the curves where their own surface is only continuous (knots
/// as multiple as the degree): there it may turn as sharply as at an edge, and a line is needed. Parts of an edge
/// keep its label. Other faces and edges stay as they are.
void heal_shape(CadFile& cad);

}  // namespace batten
