// Makes the CAD faces that are exactly the surfaces of regions. Internal.
#pragma once

#include <TopoDS_Face.hxx>

#include <vector>

#include "batten/io/cad/face_maker.h"

namespace batten {

using RegionFaces = std::vector<std::vector<TopoDS_Face>>;  ///< faces of each StepPlan::regions

/// Makes three bicubic faces for each triangle, triangle by triangle (step.h). Regions that
/// embedded lines cut get none. Vertices and edges exist once: lines of one name have the same
/// ones, and ends of lines in the same place are one vertex. Edges along lines end at the plan's
/// cuts, so that a side of a triangle may be several edges. `shared`, unless null, gets the
/// vertices and edges along lines, for other faces and for their names. `size` is that of the
/// model; tolerances are 1e-9 of it.
///
/// Call cut_at_vertices() first. Throws InputError for an edge without length.
RegionFaces exact_faces(const StepPlan& plan, double size, SharedEdges* shared);

}  // namespace batten
