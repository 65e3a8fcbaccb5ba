// SPDX-License-Identifier: MPL-2.0
// Separation of a form feature from a panel by a minimum cut through a band of triangles or between
// two strokes.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

// The border of a set of triangles as chains of vertices.

/// A chain of edges at the border of a set of triangles. The chain is closed, or it starts and ends
/// on the boundary of the mesh.
struct BorderChain {
  /// Vertices in order along the chain. The first vertex of a closed chain is not repeated at the
  /// end. A vertex occurs more than once only if the chain touches itself.
  std::vector<int> vertices;
  bool closed = true;  ///< false: the chain starts and ends on the boundary of the mesh
};

/// Links the border edges of a set of triangles into chains. A border edge has a triangle of the
/// set on its right and another triangle on its left; boundary edges of the mesh are not included.
/// `inside`: one flag per triangle, nonzero for triangles of the set. If two parts of the set touch
/// at a vertex, a chain continues along the same part, so every chain belongs to one part. Closed
/// chains start at their lowest-numbered vertex; the chains are sorted by their vertices.
/// O(triangles).
std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside);

/// Options of cut_feature() and stroke_cut().
struct CutOptions {
  /// Weights of concave edges (the surface bends towards its normals) and of convex edges, at least
  /// 0. The larger the weight, the more these edges attract the cut. If the normals point to the
  /// hollow side of the feature, swap the two weights, since concave edges then appear convex.
  double concave = 1, convex = 0.2;
  /// A vertex on the feature's side of the band of triangles in which cut_feature() searches the
  /// cut; -1: the feature is on the side with the smaller area.
  int feature_vertex = -1;
};

/// Result of a minimum cut: the triangles on the side of the feature, and the edges of the cut.
struct FeatureCut {
  std::vector<int> triangles;       ///< triangles of the feature, ascending
  std::vector<int> vertices;        ///< vertices of the feature: corners of `triangles`, ascending
  std::vector<BorderChain> chains;  ///< edges of the cut, with the panel on their left
  double cost;                      ///< sum of the costs of the cut edges; see cut_feature()
};

/// Separates a form feature from a panel by the minimum cut through a band of triangles that the
/// user marked around the feature. The cost of an edge of length l, with the angle a between the
/// normals of its two triangles and the weight η of CutOptions, is
///
///     l / (1 + d / mean d),   d = η (1 - cos a)
///
/// The mean of d is taken over all interior edges with at least one triangle in the band, and is at
/// least the value of d for angles of 0.1°, which occur by rounding in files. If d is constant, the
/// shortest cut is found. The factor l makes the cost of a cut independent of the mesh size. Among
/// several minimum cuts, the one nearest to the feature is taken, so the result does not depend on
/// the flow algorithm.
///
/// `band`: triangle indices, in any order. Removing the band must split its connected component of
/// the mesh into exactly two edge-connected parts: the feature side and the panel side. Otherwise
/// InputError is thrown ("the band leaves 3 parts of 10, 400 and 22 triangles, expected 2").
/// InputError is also thrown if the band is empty or lies in several components of the mesh, an
/// index is out of range, the feature vertex is not on exactly one side, or a weight is negative or
/// not finite.
///
/// Capacities are rounded to integer multiples of 2⁻⁵² of their sum, so the cut is exact and
/// reproducible. Cost: O(triangles) plus the maximum flow in the band. The flow takes 2 ms for a
/// band of 10,000 triangles that contains a crease, but 0.3 s for a flat band of the same size,
/// where the time grows quadratically. References: [KatzTal2003] (capacities); [Masuda2007],
/// section 4.3 (band); [BoykovKolmogorov2004] (flow; implementation of Boost.Graph).
FeatureCut cut_feature(const TriangleMesh& mesh, const std::vector<int>& band,
                       const CutOptions& options = {});

// Separating a form feature by two strokes, one on it and one beside it.

/// Separates a form feature by the minimum cut between a stroke on the feature and a stroke beside
/// it. The costs of the edges are those of cut_feature(), but with the mean taken over all edges of
/// the connected component of the mesh that contains the strokes. Triangles that touch `inside`
/// belong to the feature, triangles that touch `outside` do not. Among several minimum cuts, the
/// one nearest to `inside` is taken. The function works on closed solids as well as on panels.
///
/// `inside`, `outside`: vertex indices of the strokes, in any order. `options.feature_vertex` is
/// ignored. Throws InputError if a stroke is empty or contains an index out of range, the strokes
/// touch each other or lie in different components of the mesh, or a weight is negative or not
/// finite.
///
/// Cost: O(triangles) plus the maximum flow between the strokes, whose time may grow quadratically
/// with the number of triangles if the surface is flat.
FeatureCut stroke_cut(const TriangleMesh& mesh, const std::vector<int>& inside,
                      const std::vector<int>& outside, const CutOptions& options = {});

}  // namespace batten
