// Regions as faces that are exactly their surfaces. Internal.
#pragma once

#include <TopoDS_Face.hxx>

#include <vector>

#include "batten/io/cad/face_maker.h"

namespace batten {

using RegionFaces = std::vector<std::vector<TopoDS_Face>>;  ///< of each of StepPlan::regions

/// Three bicubic faces for each triangle, triangle by triangle (step.h), of all regions but those
/// that embedded lines cut, which get none. Vertices and edges exist once: lines of one name have
/// the same ones, and ends of lines that lie in the same place are one vertex. Edges along lines
/// end at the plan's cuts, so that a side of a triangle may be several. `shared`, unless null, gets
/// what lies along lines, for other faces to use. `size`: of the model; tolerances are 1e-9 of it.
///
/// Call cut_at_vertices first. Throws InputError for an edge without length.
RegionFaces exact_faces(const StepPlan& plan, double size, SharedEdges* shared);

}  // namespace batten
