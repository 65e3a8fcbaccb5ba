// SPDX-License-Identifier: MPL-2.0
// One triangle mesh of a whole model: faces that share a curve share the vertices on it.
//
// The facets of faces that share a curve end at the same points of the curve (model_elements.h).
// These points become one vertex, so that no crack opens when the mesh is deformed. A vertex on a
// curve is identified by the name and a parameter of the curve, not by its position. Two sheets
// without a common curve therefore stay separate, however close they are. There is one exception:
// ends of curves that are closer than 1e-6 of the model size become one vertex.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/facets/facets.h"

namespace batten {

/// The vertices of a welded mesh on one curve of the model.
struct WeldedCurve {
  struct Polyline {
    /// Vertex numbers along the curve. Consecutive vertices are joined by an edge of the mesh. A
    /// closed polyline does not repeat its first vertex at the end.
    std::vector<int> vertices;
    bool closed = false;  ///< true: an edge of the mesh joins the last and the first vertex
  };
  std::string name;
  /// There is more than one polyline if an inner curve leaves its faces. The direction is that of
  /// the curve in the first face that contains it.
  std::vector<Polyline> polylines;
};

/// One triangle mesh of all faces of a model.
struct WeldedMesh {
  Points points;  ///< positions of the vertices, n×3, model units
  /// Vertex numbers of each triangle, counter-clockwise seen from the tip of the surface normal,
  /// face after face.
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> region;  ///< index of the face of each triangle
  /// Unit normals of the faces at the corners of their triangles: row 3 t + c belongs to corner c
  /// of triangle t. At a vertex on a crease, the faces have different normals. If a surface is
  /// singular at a corner (|x_u × x_v| below 1e-6 of its largest value at the three corners), the
  /// row contains the direction of the mean of x_u × x_v at the three corners.
  Points normals;
  std::vector<WeldedCurve> curves;  ///< one entry per curve name, in the order of first occurrence
};

/// Triangulates all faces of a model as one mesh.
///
/// Each edge in a closed shell has two triangles, which traverse it in opposite directions if the
/// normals of the faces agree. An edge on a curve that three or more faces share (non-manifold
/// edge) has one triangle per face. An annulus, and a face that meets itself along a curve, are
/// closed at the seam. Each vertex is on the surface of its face. If several faces share a vertex,
/// it is on the surface of the first face in which the shared curve is mesh-aligned or, if there is
/// none, on the curve.
///
/// `regions`: one or more faces, not null. `facets_per_edge`: facets along each edge of the
/// triangles of quadratic_elements(), 1 or more; 0: display_facets_per_edge(). `edge_length`:
/// target length of these edges in faces with embedded curves, model units; 0:
/// mean_facet_length().
///
/// Cost: that of model_elements(), and of facets() for each face. Throws InputError as
/// model_elements() does, and if `facets_per_edge` is negative.
WeldedMesh welded_mesh(const std::vector<const SkinnedRegion*>& regions, int facets_per_edge = 0,
                       double edge_length = 0);

}  // namespace batten
