// Triangulations of a region that follow its lines: quadratic elements and display facets.
//
// A region whose lines are all edge-aligned is triangulated by its element mesh. A region with
// embedded lines gets a separate mesh in (u, v), which follows its boundary exactly:
//
//     c(t0) o-------o c(t1)     Edges on a line follow c(t), at their ends and in between. The
//            \     /            triangle at such an edge is a straight triangle, blended by
//    straight \   / straight
//              \ /              p(L) = Σ L_i p_i +   Σ    L_j L_k / (s (1 - s)) (c(s) - chord(s)),
//               o                                 edges jk      s = (1 + L_k - L_j) / 2
//
// The parameters t depend only on the line's shape in space, the facet size and the points where
// other lines meet it, not on the surface. So neighbours that share a line share the points on it
// (up to the distance between each surface and the line). Between the ends of an edge the direction
// of a line changes by at most 36 degrees. Edges are bisected if a triangle at them would fold or
// nearly fold.
#pragma once

#include <array>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Tolerance for parameters on a line, as a fraction of its parameter range: closer ones are the
/// same point.
constexpr double kParameterTolerance = 1e-9;

/// Prescribed subdivision of the lines of a region, so that its edges match those of its
/// neighbours.
struct SubdivisionRequest {
  /// For each line (edge-aligned lines first, then embedded ones): prescribed parameters of its
  /// curve, ascending, with its start and end. An empty list, or no list, means the region's own
  /// subdivision. More points are added where the region needs them: at the mesh vertices of
  /// edge-aligned lines, where lines meet, and where triangles would fold.
  std::vector<std::vector<double>> at;
  /// If true, edges at which a triangle would fold may be bisected. If false, they become straight
  /// in (u, v).
  bool may_split = true;
};

/// Six-node (quadratic) triangles. Nodes are numbered corners first, then edge midpoints. For a
/// region without embedded lines these are the mesh's vertices and edges in their order, unless the
/// SubdivisionRequest has more points than these vertices.
struct QuadraticElements {
  bool is_element_mesh = true;  ///< true if the triangles are those of the element mesh, in order
  std::vector<Location> nodes;  ///< locations in the element mesh
  std::vector<Vec2> uv;         ///< domain coordinates of the nodes
  /// Counter-clockwise corners, then the midpoints of the edges 12, 23, 31.
  std::vector<std::array<int, 6>> triangles;
  std::vector<int> element;  ///< for each triangle, the element that contains its centre
  /// For each line (edge-aligned lines first, then embedded ones) its edges in order: first end,
  /// second end, midpoint. Edges are missing where an inner line leaves the region.
  std::vector<std::vector<std::array<int, 3>>> lines;
  /// For each of these edges the parameters of the line at its two ends.
  std::vector<std::vector<std::array<double, 2>>> parameters;
};

/// Builds six-node triangles of a region. `edge_length`: target on embedded lines and, scaled to
/// (u, v), inside; model units; 0: facet_length(region). Midpoints of edges on lines are at c((t0 +
/// t1) / 2). Cost: O(n log n).
///
/// Throws InputError for a region with embedded lines but without a boundary; an annulus whose
/// holes leave no straight seam; lines that cross or touch without a common point; a build without
/// the Delaunay mesher.
QuadraticElements quadratic_elements(const SkinnedRegion& region, double edge_length = 0,
                                     const SubdivisionRequest& requested = {});

/// Facets for display, and their points on lines.
struct DisplayFacets {
  Tessellation tessellation;
  /// For each line (edge-aligned lines first, then embedded ones) its polylines: one, or more if an
  /// inner line leaves the region. A closed polyline ends at its first point.
  std::vector<std::vector<std::vector<int>>> lines;
};

/// Splits each triangle into n² facets. Without embedded lines the triangles are those of the
/// element mesh (tessellate(mesh, n)). Otherwise they are those of the mesh that follows the lines,
/// with points on lines at equidistant parameters between t0 and t1. Throws as
/// quadratic_elements().
DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length = 0);

/// The reason why a region cannot be triangulated, as a message, or "". O(1) without embedded
/// lines, otherwise as facets().
std::string facet_error(const SkinnedRegion& region);

/// Mean distance in space between the ends of element edges, model units. Edges outside of the trim
/// do not count.
double facet_length(const SkinnedRegion& region);

/// Mean of facet_length() over the regions. With one size for all, regions share points on shared
/// lines.
double mean_facet_length(const std::vector<const SkinnedRegion*>& regions);

/// Number of facets along an edge of an element: 4, or fewer, for at most 400,000 facets in total.
int display_facets_per_edge(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
