// Catmull-Clark subdivision of polygon cages with semi-sharp creases, evaluated on the limit
// surface.
#pragma once

#include <limits>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Edges and nodes of at least this sharpness are infinitely sharp.
constexpr double kInfinitelySharp = 10;

/// A semi-sharp crease edge. `sharpness` is the number of subdivision levels during which the
/// crease rule applies: 0 is smooth, kInfinitelySharp and above never decays.
struct CageCrease {
  int a = 0, b = 0;  ///< its end nodes, 0-based
  double sharpness = kInfinitelySharp;
};
/// A semi-sharp corner: the node keeps its position for `sharpness` subdivision levels.
struct CageCorner {
  int node = 0;
  double sharpness = kInfinitelySharp;
};
/// Creases and corners of a cage, in addition to its boundary. If several entries name the same
/// edge or node, the last one counts.
struct CageTags {
  std::vector<CageCrease> creases;
  std::vector<CageCorner> corners;
};

/// Options of catmull_clark().
struct CatmullClarkOptions {
  int levels = 4;  ///< at least 1; each level splits a polygon of n corners into n quads
  CageTags tags = {};
};

/// Subdivides a cage and projects the nodes to the limit surface. The result is a quad mesh.
///
/// For a node v with n edges, e denotes the far ends of these edges, f the centroids of the faces
/// around v, and d the corners diagonally opposite to v in the quads. One level moves v to v', and
/// its limit position is v∞:
///
///     v' = v (n - 2)/n + Σ e/n² + Σ f/n²,     v∞ = (n² v + 4 Σ e + Σ d)/(n (n + 5))
///
/// Regular regions are bicubic B-splines. Edges with one face (the boundary) or with three or more
/// faces are infinitely sharp. A node of a single face is an infinitely sharp corner. With sharp
/// edges at v these rules apply:
///
///     two sharp edges         v' = (a + 6v + b)/8, v∞ = (a + 4v + b)/6 with a, b their far ends
///     three or more, or v is a corner        v' = v
///     one sharp edge          v' as in the smooth case; v∞ is taken after 60 further levels
///
/// A sharpness s becomes s - 1 at the next level. For 0 < s < 1, the new node of an edge is s times
/// its midpoint plus (1 - s) times the smooth edge point. If the sharpness of edges at v, or of v
/// itself, ends at a level such that another rule applies afterwards, v' blends both rules. The
/// blending factor is the mean of the sharpnesses that end. The limit is therefore exact for any
/// number of levels: if some sharpness is left, the one-ring of v is subdivided further until none
/// is.
///
/// Faces are ordered like those of the cage: each cage quad gives 4^k consecutive quads after k
/// levels. Second-order faces are treated as polygons of their corners. Throws InputError: fewer
/// than one level, more than 4,000,000 quads, a crease that is not an edge, a corner that is not a
/// node, a negative sharpness. O(quads). Sources: [CatmullClark1978]; limit positions:
/// [HalsteadKassDeRose1993]; semi-sharp creases: [DeRoseKassTruong1998].
ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options = {});

/// Subdivides a cage until the deviation of its quads from the limit surface is about `chord`, but
/// at most 8 times, and not to more than 200,000 quads. `chord`: units of the cage. Throws as
/// catmull_clark(). Cost: about that of the last subdivision.
ShellMesh catmull_clark_limit(const ShellMesh& cage, const CageTags& tags, double chord);

}  // namespace batten
