// SPDX-License-Identifier: MPL-2.0
// Catmull-Clark subdivision of polygon cages with semi-sharp creases, evaluated on the limit
// surface.
#pragma once

#include <limits>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Smallest sharpness (in subdivision levels) at which a crease or corner is infinitely sharp.
constexpr double kInfinitelySharp = 10;

/// A semi-sharp crease edge of a subdivision cage. `sharpness` is the number of subdivision levels
/// during which the edge is treated as a crease: 0 means a smooth edge; a sharpness of
/// kInfinitelySharp or more never decays.
struct CageCrease {
  int a = 0, b = 0;  ///< end nodes of the edge, 0-based
  double sharpness = kInfinitelySharp;
};
/// A semi-sharp corner of a subdivision cage: a node that keeps its position for `sharpness`
/// subdivision levels.
struct CageCorner {
  int node = 0;
  double sharpness = kInfinitelySharp;
};
/// Semi-sharp creases and corners of a subdivision cage. Boundary edges are always sharp. If
/// several entries refer to the same edge or node, the last one applies.
struct CageTags {
  std::vector<CageCrease> creases;
  std::vector<CageCorner> corners;
};

/// Options of catmull_clark().
struct CatmullClarkOptions {
  int levels = 4;  ///< number of subdivision levels, at least 1; each splits an n-gon into n quads
  CageTags tags = {};
};

/// Subdivides a cage of polygons by the Catmull-Clark scheme, and projects the nodes of the
/// resulting quad mesh to the limit surface.
///
/// For a node v with n edges, let e be the far ends of the edges, f the centroids of the faces
/// around v, and d the corners diagonally opposite to v in quads. One level moves v to v'. The
/// limit position of v is v∞:
///
///     v' = v (n - 2)/n + Σ e/n² + Σ f/n²,     v∞ = (n² v + 4 Σ e + Σ d)/(n (n + 5))
///
/// Regular regions are bicubic B-splines. Edges with one face (the boundary) or with three or more
/// faces are infinitely sharp. A node of a single face is an infinitely sharp corner. With sharp
/// edges at v these rules apply:
///
///     two sharp edges va, vb  v' = (a + 6v + b)/8, v∞ = (a + 4v + b)/6
///     three or more, or v is a corner        v' = v
///     one sharp edge          v' as in the smooth case; v∞ is taken after 60 further levels
///
/// A sharpness s becomes s - 1 at the next level. For 0 < s < 1, the new node of an edge is s times
/// the edge midpoint plus (1 - s) times the smooth edge point. If the sharpness of v or of edges at
/// v drops to 0 at a level, so that another rule applies afterwards, v' is a blend of both rules.
/// The blending factor is the mean of the sharpnesses that drop to 0. The limit positions are exact
/// for any number of levels: if edges at v are still semi-sharp after the last level, the one-ring
/// of v is subdivided further until their sharpness is 0.
///
/// The quads are in the order of the cage faces: each cage quad gives 4^k consecutive quads after k
/// levels. Second-order faces are treated as polygons of their corners. Throws InputError if there
/// is fewer than one level, the result has more than 4,000,000 quads, a crease is not an edge, a
/// corner is not a node, or a sharpness is negative. O(quads). References: [CatmullClark1978];
/// [HalsteadKassDeRose1993] (limit positions); [DeRoseKassTruong1998] (semi-sharp creases).
ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options = {});

/// Subdivides a cage of polygons by the Catmull-Clark scheme until the quads deviate from the limit
/// surface by about `chord`, but at most 8 times and to at most 200,000 quads. `chord`: largest
/// distance between a quad and the limit surface, in the length unit of the cage. Throws the
/// exceptions of catmull_clark(). Costs about as much as the last subdivision.
ShellMesh catmull_clark_limit(const ShellMesh& cage, const CageTags& tags, double chord);

}  // namespace batten
