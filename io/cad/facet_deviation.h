// How far triangles and chords are from the CAD faces and edges that they stand for. Internal.
#pragma once

#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <vector>

#include "batten/core/eigen.h"

class Poly_PolygonOnTriangulation;
class Poly_Triangulation;

namespace batten {

/// Largest distance of seven points of each triangle from the face's surface: Gauss-Newton steps
/// from the parameters of the corners on. `at`: the nodes at their places. 0 for a plane.
double surface_deviation(const TopoDS_Face& face, const Poly_Triangulation& mesh,
                         const std::vector<Vec3>& at);

/// Largest distance of the edge's curve from the chords along it: three points a chord.
double chord_deviation(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& chain,
                       const std::vector<Vec3>& at);

}  // namespace batten
