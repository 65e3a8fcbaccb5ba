// SPDX-License-Identifier: MPL-2.0
// Meshes the parts of a CAD document and measures the distance between mesh and model.
#pragma once

#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/mesh/pn_triangle_mesh.h"

namespace batten {

/// Parts whose coincident free edges have been sewn, so that adjacent faces share edges.
struct JoinedParts {
  std::vector<CadPart> parts;
  bool sewn = false;  ///< true if the shapes differ from those of the document
  double size = 0;    ///< diagonal of the bounding box, mm
};
/// Collects the parts of a file and sews free edges within 1e-5 of the model size of each other.
/// The parts of an IGES file are merged into one.
JoinedParts joined_parts(const CadFile& cad);

/// Meshes the parts, in millimetres. The triangulations stay attached to the shapes. `chord`:
/// tolerance in mm; 0: 1e-3 of `size`. `curved`: also compute normals. Does not set
/// CadFacets::contents.
CadFacets mesh_parts(const std::vector<CadPart>& parts, double size, double chord,
                     bool curved = false);

}  // namespace batten

// Distance of triangles and chords from the CAD faces and edges that they approximate.

class Poly_PolygonOnTriangulation;
class Poly_Triangulation;

namespace batten {

/// The unit surface normals at the corners of each triangle, oriented like the triangle. `at`:
/// positions of the nodes in the global frame. The normals are taken just inside the triangle, in
/// case the surface is singular or has a kink at the corner.
std::vector<PnTriangle::Corners> corner_normals(const TopoDS_Face& face,
                                                const Poly_Triangulation& mesh,
                                                const std::vector<Vec3>& at);

/// The largest distance between seven points of each triangle and the surface of the face. The
/// closest point is found by Gauss-Newton steps that start at the interpolated parameters.
/// `normals`: corner normals of curved triangles; empty for flat ones. 0 for a plane.
double surface_deviation(const TopoDS_Face& face, const Poly_Triangulation& mesh,
                         const std::vector<Vec3>& at,
                         const std::vector<PnTriangle::Corners>& normals);

/// The largest distance between the edge's curve and its chords, sampled at three points per chord.
double chord_deviation(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& chain,
                       const std::vector<Vec3>& at);

// Merges the triangulations of faces into one mesh that shares the nodes on common edges.

/// Builds one mesh in millimetres from the triangulations of the faces of `parts`, which are those
/// of `shape`. Zero-area triangles at poles are dropped. The nodes on common edges get identical
/// positions, also in the triangulations themselves. `curved`: also compute normals. Sets
/// everything but `size`, `chord` and `contents`.
CadFacets number_facets(const std::vector<CadPart>& parts, const TopoDS_Shape& shape, bool curved);

}  // namespace batten
