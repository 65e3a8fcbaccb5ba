// SPDX-License-Identifier: MPL-2.0
// Triangulations of a face that follow its curves: quadratic elements and display facets.
//
// A face whose curves are all mesh-aligned is triangulated by its element mesh. A face with
// embedded curves gets a separate mesh in (u, v), which follows its boundary exactly:
//
//     c(t0) o-------o c(t1)     Edges on a curve follow c(t), at their ends and in between. The
//            \     /            triangle at such an edge is a straight triangle, blended by
//    straight \   / straight
//              \ /              p(L) = Σ L_i p_i +   Σ    L_j L_k / (s (1 - s)) (c(s) - chord(s)),
//               o                                 edges jk      s = (1 + L_k - L_j) / 2
//
// The parameters t depend only on the shape of the curve in space, the facet size and the points at
// which other curves meet the curve, not on the surface. Adjacent faces that share a curve
// therefore share the points on the curve (up to the distance between each surface and the curve).
// Along an edge, the direction of the curve changes by at most 36 degrees. An edge is bisected if
// an adjacent triangle would fold or nearly fold.
#pragma once

#include <array>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Tolerance of curve parameters, as a fraction of the parameter range: parameters that differ by
/// less belong to the same point.
constexpr double kParameterTolerance = 1e-9;

/// Prescribed subdivision of the curves of a face, to match the mesh edges of adjacent faces.
struct SubdivisionRequest {
  /// For each curve (mesh-aligned curves first, then embedded ones): prescribed parameters of the
  /// ends of mesh edges, ascending, including those of start and end of the curve. Empty list: the
  /// mesher selects the subdivision. The mesher adds points where the face needs them: at the mesh
  /// vertices of mesh-aligned curves, where curves meet, and where triangles would fold.
  std::vector<std::vector<double>> at;
  /// True: an edge on a curve may be bisected if the adjacent triangle would fold. False: such an
  /// edge becomes straight in (u, v).
  bool may_split = true;
};

/// Six-node (quadratic) triangles of a face. The nodes at corners come first, then those at edge
/// midpoints. For a face without embedded curves the nodes are the vertices and edge midpoints of
/// the element mesh, in its order, unless the SubdivisionRequest adds points.
struct QuadraticElements {
  /// True: the triangles are those of the element mesh, in its order. False: separate mesh.
  bool is_element_mesh = true;
  std::vector<Location> nodes;  ///< locations of the nodes in the element mesh
  std::vector<Vec2> uv;         ///< domain coordinates of the nodes
  /// Nodes of each triangle: three corners, counter-clockwise, then the midpoints of the edges 12,
  /// 23, 31.
  std::vector<std::array<int, 6>> triangles;
  std::vector<int> element;  ///< for each triangle, the element that contains its centroid
  /// For each curve (mesh-aligned curves first, then embedded ones): the nodes of the triangle
  /// edges on the curve, in order along it, as (first end, second end, midpoint). Parts of an inner
  /// curve outside of the face have no edges.
  std::vector<std::vector<std::array<int, 3>>> lines;
  /// For each triangle edge in `lines`: the parameters of the curve at the two ends of the edge.
  std::vector<std::vector<std::array<double, 2>>> parameters;
};

/// Builds six-node triangles of a face that follow its curves. `requested`: prescribed subdivision
/// of the curves. `edge_length`: target length of edges on embedded curves and, scaled to (u, v),
/// inside the face, model units; 0: facet_length(region). An edge from c(t0) to c(t1) on a curve
/// c(t) in (u, v) has its midpoint at c((t0 + t1) / 2). Cost: O(n log n) for n triangles.
///
/// Throws InputError if a face with embedded curves has no boundary; if no straight seam of an
/// annulus avoids the holes; if curves cross or touch without a common point; or if a mesher is
/// required and the build has no Delaunay mesher.
QuadraticElements quadratic_elements(const SkinnedRegion& region, double edge_length = 0,
                                     const SubdivisionRequest& requested = {});

/// Facets for display, and the facet vertices on each curve.
struct DisplayFacets {
  Tessellation tessellation;
  /// For each curve (mesh-aligned curves first, then embedded ones): polylines of facet vertices.
  /// There is more than one polyline if an inner curve leaves the face. The last vertex of a closed
  /// polyline equals the first one.
  std::vector<std::vector<std::vector<int>>> lines;
};

/// Builds facets for display by splitting each triangle of quadratic_elements() for this
/// `edge_length` and this request into n² facets. The corners of these triangles have the same
/// numbers as facet vertices and as nodes. If the face has no embedded curves and `requested` no
/// additional points, these triangles are the finite elements themselves, so the facets are those of
/// tessellate(mesh, n). Facet vertices on curves have equidistant parameters within each edge.
/// Throws as quadratic_elements() does.
DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length = 0,
                     const SubdivisionRequest& requested = {});

/// Message that explains why facets() would fail for a face, or "" if it would succeed. O(1)
/// without embedded curves; otherwise the cost of facets().
std::string facet_error(const SkinnedRegion& region);

/// Mean length of the element edges of a face: distance of the end points in space, model units.
/// Edges outside of the trimmed domain are excluded.
double facet_length(const SkinnedRegion& region);

/// Mean of facet_length() over several faces, model units. Pass it as `edge_length` to facets() for
/// every face, so that adjacent faces have the same points on shared curves.
double mean_facet_length(const std::vector<const SkinnedRegion*>& regions);

/// Number of facets per element edge for display, the argument `n` of facets(): at most 4, and
/// small enough for at most 400,000 facets in total.
int display_facets_per_edge(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
