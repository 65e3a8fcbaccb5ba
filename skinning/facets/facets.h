// Makes triangles of a region for all that needs them: quadratic elements and display facets.
//
// A region whose lines are all fitted has its element mesh. A region with embedded lines gets a
// mesh of its own in (u, v), which follows its boundary exactly:
//
//     c(t0) o-------o c(t1)     Edges on a line keep c(t) at their ends and inside of them. The
//            \     /            triangle at such an edge is the image of a straight one,
//    straight \   / straight
//              \ /              p(L) = Σ L_i p_i +   Σ    L_j L_k / (s (1 - s)) (c(s) - chord(s)),
//               o                                 edges jk      s = (1 + L_k - L_j) / 2
//
// The parameters t depend only on the line's shape in space, the facet size and the points where
// other lines meet it, not on the surface: neighbours that share a line share its points (up to the
// distance between each surface and the line). Between the ends of an edge a line turns by at most
// 36 degrees. Edges are halved where a triangle at them would fold or come near to it.
#pragma once

#include <array>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Two parameters on a line are one place when they differ by less than this share of its range.
constexpr double kParameterTolerance = 1e-9;

/// Where edges have to end on the lines of a region, so that they are those of its neighbours.
struct SubdivisionRequest {
  /// For each line (runs, then embedded lines) parameters of its curve, ascending, its start and
  /// end among them; empty, or no list: as the region has it by itself. More stops are made where
  /// the region needs them: at the vertices of a run, where lines meet, and where triangles fold.
  std::vector<std::vector<double>> at;
  /// Whether edges at which a triangle would fold may be halved; if not, they become straight in
  /// (u, v).
  bool may_split = true;
};

/// Six-node triangles. Node numbers: corners first, then the middles of edges. Of a region without
/// embedded lines these are the mesh's vertices and edges in their order, unless more stops than
/// these vertices are asked for.
struct QuadraticElements {
  bool is_element_mesh = true;  ///< the element mesh itself, triangle by triangle
  std::vector<Location> nodes;  ///< their places in the element mesh
  std::vector<Vec2> uv;         ///< of the nodes
  /// Counter-clockwise corners, then the middles of the edges 12, 23, 31.
  std::vector<std::array<int, 6>> triangles;
  std::vector<int> element;  ///< the element that holds the middle of each triangle
  /// For each line (runs, then embedded lines) its edges in order: first end, second end, middle.
  /// There are gaps where an inner line leaves the region.
  std::vector<std::vector<std::array<int, 3>>> lines;
  /// For each of these edges the parameters of the line at its two ends.
  std::vector<std::vector<std::array<double, 2>>> parameters;
};

/// Makes six-node triangles of a region. `edge_length` is the target on embedded lines and, scaled
/// to (u, v), inside; model units; 0: facet_length(region). Middles of edges on lines lie at
/// c((t0 + t1) / 2). O(n log n).
///
/// Throws InputError: a region with embedded lines whose boundary is not stated, or a ring with
/// holes that leave no room for a straight seam; lines that cross or touch where they share no
/// point; no Delaunay mesher in this build.
QuadraticElements quadratic_elements(const SkinnedRegion& region, double edge_length = 0,
                                     const SubdivisionRequest& requested = {});

/// The facets that are displayed, and their points on lines.
struct DisplayFacets {
  Tessellation tessellation;
  /// For each line (runs, then embedded lines) its polylines: one, or more where an inner line
  /// leaves the region. A closed one ends at its first point.
  std::vector<std::vector<std::vector<int>>> lines;
};

/// Makes n² facets of each triangle: of the element mesh (tessellate(mesh, n)) without embedded
/// lines, otherwise of the mesh that follows the lines, with points on lines at even parameters
/// between c(t0) and c(t1). Throws as above.
DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length = 0);

/// Why a region has no facets, in words, or "". O(1) without embedded lines, else as facets().
std::string facet_error(const SkinnedRegion& region);

/// Returns the mean distance in space between the ends of element edges that are not outside, model
/// units.
double facet_length(const SkinnedRegion& region);

/// The mean of facet_length(): one size for all regions, so that they share points where they share lines.
double mean_facet_length(const std::vector<const SkinnedRegion*>& regions);

/// Facets along an edge of an element: 4, or fewer so that there are at most 400,000 in all.
int display_facets_per_edge(const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
