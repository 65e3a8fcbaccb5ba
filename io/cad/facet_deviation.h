// How far triangles and chords are from the CAD faces and edges that they stand for. Internal.
#pragma once

#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/pn_triangle.h"

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

}  // namespace batten
