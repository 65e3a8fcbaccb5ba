// Separating a form feature from a panel by a minimum cut through a band that the user marked.
#pragma once

#include <vector>

#include "batten/mesh/features/minimum_cut.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// The border of a set of triangles as chains of vertices.

struct BorderChain {
  std::vector<int> vertices;  ///< each once in a closed chain that does not touch itself
  bool closed = true;         ///< open chains start and end on the mesh's own boundary
};

/// Edges between a triangle inside and one outside, linked to chains that have the outside on their
/// left, as boundary loops of MeshTopology have the surface. Edges of the mesh's own boundary are
/// not part of it. `inside` holds a flag for each triangle. At a vertex where two parts of the set
/// touch, chains go on along the part they came along, so that every chain belongs to one part.
/// Closed chains start at their lowest vertex; chains are sorted. O(triangles).
std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside);


struct FeatureCut {
  std::vector<int> triangles;       ///< triangles of the feature, ascending
  std::vector<int> vertices;        ///< corners of these triangles, ascending
  std::vector<BorderChain> chains;  ///< edges of the cut; the panel on their left
  double cost;                      ///< Σ capacities of these edges
};

/// The cheapest set of edges that separates the two sides of a band of triangles, where an edge of
/// length l whose triangles' normals differ by the angle a costs
///
///     l / (1 + d / mean d),   d = η (1 - cos a)
///
/// and the mean is over all edges of the band that have two triangles, those to the sides included.
/// Where d does not vary, the shortest cut wins: a mean below that of angles of a tenth of a degree
/// (bends that small are rounding of files) counts as that. The length makes the cost of a cut
/// independent of the mesh. Of several cheapest cuts the one nearest to the feature is taken,
/// whatever finds it.
///
/// `band`: triangles, in any order. With them taken out, their part of the mesh must fall into
/// exactly two (joined by edges): the feature's side and the panel's. Throws InputError that says
/// what was found instead ("the band leaves 3 parts of 10, 400 and 22 triangles, expected 2"), for
/// an empty band, one that lies in several parts of the mesh, numbers out of range, a feature
/// vertex that is not on one side only, η that are negative or not finite.
///
/// Capacities are whole numbers of 2⁻⁵² of their sum, so that the cut is exact and repeats.
/// O(mesh) and the maximum flow in the band: 2 ms for 10,000 triangles with a crease among them,
/// but 0.3 s for as many without any bend, and growing with their square. Source: Katz and Tal 2003
/// (capacities); Masuda, Yoshioka and Furukawa 2007, section 4.3 (the band); Boykov and Kolmogorov
/// 2004 by Boost.Graph (the flow).
FeatureCut cut_feature(const TriangleMesh& mesh, const std::vector<int>& band,
                       const CutOptions& options = {});


// Separating a form feature by two strokes of the mouse: one on it, one beside it.

/// The cheapest set of edges between two strokes, at the price of edges of cut_feature(): the mean
/// bend is over all edges of that part of the mesh. Triangles that touch `inside` are the feature's,
/// those that touch `outside` are not; of several cheapest cuts the one nearest to the inside is
/// taken. It works on closed solids as on panels.
///
/// Strokes: vertices, in any order. `feature_vertex` of the options is not looked at. Throws
/// InputError: a stroke that is empty or out of range, strokes that touch each other (it says at
/// which vertex or triangle), that lie in different parts of the mesh, η that are negative or not
/// finite.
///
/// O(mesh) and the maximum flow between the strokes, which may grow with the square of the number
/// of triangles where nothing bends.
FeatureCut stroke_cut(const TriangleMesh& mesh, const std::vector<int>& inside,
                      const std::vector<int>& outside, const CutOptions& options = {});

}  // namespace batten
