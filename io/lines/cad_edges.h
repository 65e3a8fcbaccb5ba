// Curves and names of the edges of CAD files, and shape healing.
#pragma once

#include <Geom_Curve.hxx>
#include <TopoDS_Edge.hxx>
#include <string>
#include <vector>

#include "batten/io/cad/cad_file.h"

namespace batten {

/// The edge's 3D curve with its parameter range, in the global frame; null for an edge of length
/// zero.
Handle(Geom_Curve) curve_of(const TopoDS_Edge& edge, double& start, double& end);

/// The names of the edges of a file, in file order, as documented at read_cad_lines(); "" for edges
/// of length zero.
std::vector<std::string> edge_names(const CadFile& cad);

// Prepares CAD files for fitting a model to them.

/// Merges coincident edges and splits faces at creases. Faces that have edges of their own, as in
/// IGES files, share edges that lie within 1e-5 of the model size of each other. Faces are then
/// split along the curves where their surface is only C0 (knots as multiple as the degree). There
/// the surface may have an angle like at an edge, so a curve is needed. Parts of a split edge keep
/// its label. Other faces and edges do not change.
void heal_shape(CadFile& cad);

}  // namespace batten
