// Separates a form feature from a panel by a minimum cut through a band of triangles or between two
// strokes.
#pragma once

#include <vector>

#include "batten/mesh/features/minimum_cut.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// The border of a set of triangles as chains of vertices.

/// A chain of border edges, as vertices.
struct BorderChain {
  /// Closed chains do not repeat the first vertex; each vertex occurs once unless the chain touches
  /// itself.
  std::vector<int> vertices;
  bool closed = true;  ///< open chains start and end on the boundary of the mesh
};

/// Links the edges between triangles inside and outside a set to chains. The outside is on the left
/// of each chain, as the surface is on the left of MeshTopology::boundary_loops(). Boundary edges
/// of the mesh are not included. `inside`: one flag per triangle. At a vertex where two parts of
/// the set touch, a chain continues along its own part, so every chain belongs to one part. Closed
/// chains start at their lowest vertex; the chains are sorted. O(triangles).
std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside);

/// Result of a minimum cut: the feature side and the edges of the cut.
struct FeatureCut {
  std::vector<int> triangles;       ///< triangles of the feature, ascending
  std::vector<int> vertices;        ///< corners of these triangles, ascending
  std::vector<BorderChain> chains;  ///< edges of the cut; the panel is on their left
  double cost;                      ///< cost of the cut: the sum of the costs of its edges
};

/// Separates a form feature by the minimum cut through a band of triangles, which the user marked
/// around it. An edge of length l whose two triangle normals include the angle a costs
///
///     l / (1 + d / mean d),   d = η (1 - cos a)
///
/// The mean is taken over all edges with two triangles of which at least one lies in the band. If d
/// is constant, the shortest cut wins. A mean below that of angles of 0.1° (rounding in files) is
/// raised to that value. The factor l makes the cost of a cut independent of the mesh. Among
/// several minimum cuts, the one nearest to the feature is taken, whatever flow algorithm is used.
///
/// `band`: triangle indices, in any order. Without them, their part of the mesh must fall into
/// exactly two edge-connected parts: the feature side and the panel side. Throws InputError and
/// states what was found instead ("the band leaves 3 parts of 10, 400 and 22 triangles, expected
/// 2"). It also throws for an empty band, a band in several parts of the mesh, indices out of
/// range, a feature vertex that is not on exactly one side, and an η that is negative or not
/// finite.
///
/// Capacities are rounded to integer multiples of 2⁻⁵² of their sum, so the cut is exact and
/// reproducible. Cost: O(mesh) plus the maximum flow in the band. The flow takes 2 ms for 10,000
/// triangles with a crease among them, but 0.3 s for as many without any bend, growing
/// quadratically. Sources: [KatzTal2003] (capacities); [Masuda2007], section 4.3 (band);
/// [BoykovKolmogorov2004], from Boost.Graph (flow).
FeatureCut cut_feature(const TriangleMesh& mesh, const std::vector<int>& band,
                       const CutOptions& options = {});

// Separating a form feature by two strokes, one on it and one beside it.

/// Separates a form feature by the minimum cut between two strokes. The cost of edges is that of
/// cut_feature(), with the mean of d over all edges of this part of the mesh. Triangles that touch
/// `inside` belong to the feature, those that touch `outside` do not. Among several minimum cuts,
/// the one nearest to `inside` is taken. Works on closed solids as well as on panels.
///
/// `inside`, `outside`: vertex indices, in any order. `options.feature_vertex` is ignored. Throws
/// InputError: a stroke that is empty or out of range, strokes that touch each other (the message
/// names the vertex or triangle) or lie in different parts of the mesh, an η that is negative or
/// not finite.
///
/// Cost: O(mesh) plus the maximum flow between the strokes, which may grow quadratically with the
/// number of triangles where the surface is flat.
FeatureCut stroke_cut(const TriangleMesh& mesh, const std::vector<int>& inside,
                      const std::vector<int>& outside, const CutOptions& options = {});

}  // namespace batten
