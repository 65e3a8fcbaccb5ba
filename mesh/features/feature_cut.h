// Separating a form feature from a panel by a minimum cut through a band that the user marked.
#pragma once

#include <vector>

#include "batten/mesh/features/border_chain.h"
#include "batten/mesh/features/cut_options.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

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

}  // namespace batten
