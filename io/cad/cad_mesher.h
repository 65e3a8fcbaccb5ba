// Meshes the parts of a CAD document. Internal.
#pragma once

#include <vector>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/core/eigen.h"
#include "batten/mesh/pn_triangle_mesh.h"

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

// How far triangles and chords are from the CAD faces and edges that they stand for. Internal.

class Poly_PolygonOnTriangulation;
class Poly_Triangulation;

namespace batten {

/// The surface's unit normals at the corners of each triangle, on the side of its area vector. `at`: the
/// nodes at their places. Where the surface is singular or has a kink those just inside of the triangle.
std::vector<PnTriangle::Corners> corner_normals(const TopoDS_Face& face,
                                                const Poly_Triangulation& mesh,
                                                const std::vector<Vec3>& at);

/// Largest distance of seven points of each triangle from the face's surface: Gauss-Newton steps
/// from the parameters of the corners on. `normals`: of curved triangles, or none. 0 for a plane.
double surface_deviation(const TopoDS_Face& face, const Poly_Triangulation& mesh,
                         const std::vector<Vec3>& at,
                         const std::vector<PnTriangle::Corners>& normals);

/// Largest distance of the edge's curve from the chords along it: three points a chord.
double chord_deviation(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& chain,
                       const std::vector<Vec3>& at);


// Numbers the nodes of triangulated faces, one on each place of common edges, and measures them.
// Internal.

/// The triangles on the faces of `parts`, which are those of `shape`, as one mesh in millimetres:
/// triangles without area at poles are left out. Nodes on common edges come to one place in the
/// triangulations too. `curved`: with normals. Sets all numbers but size, chord and contents.
CadFacets number_facets(const std::vector<CadPart>& parts, const TopoDS_Shape& shape, bool curved);

}  // namespace batten
