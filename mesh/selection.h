// Choosing vertices of a mesh: by place, by distance along the surface, by neighbourhood.
#pragma once

#include <limits>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Vertex numbers, ascending, each once. Every function below returns one and takes vertex numbers
/// in any order. Vertices without triangles are never selected by place. Numbers out of range are
/// refused by InputError, which names the first. Distances and rings pass joints of sheets; what they
/// and the functions by place select are whole nodes.
using Selection = std::vector<int>;

/// Vertices with low ≤ p ≤ high in every coordinate.
Selection vertices_in_box(const TriangleMesh& mesh, const Vec3& low, const Vec3& high);

/// Vertices with |p - centre| ≤ radius.
Selection vertices_in_sphere(const TriangleMesh& mesh, const Vec3& centre, double radius);

/// Vertices with 0 ≤ n·(p - through) ≤ within, n the unit vector along `normal`. Throws InputError
/// when `normal` has no direction.
Selection vertices_beyond_plane(const TriangleMesh& mesh, const Vec3& origin, const Vec3& normal,
                                double max_height = std::numeric_limits<double>::infinity());

/// Distance of every vertex from the nearest source along the surface; infinite where none can be
/// reached, and beyond `farthest`. Two sources that share an edge count as the whole edge, so that
/// a row of sources is a curve and not a row of points.
///
/// Fronts start at the sources and pass through triangles: two corners a, b with distances d_a, d_b
/// give the third corner c the value |c - s|, where s is the point in the triangle's plane, behind
/// ab, at distance d_a from a and d_b from b, as long as the segment sc crosses ab; otherwise c has
/// min(d_a + |ac|, d_b + |bc|). Fronts from edges are straight at the start and stay locally
/// straight, c = d_a + g·(c - a) with |g| = 1 and g·(b - a) = d_b - d_a. Vertices are taken in the
/// order of their distances and taken again when a later front reaches them sooner: this is why
/// obtuse triangles need no splitting.
///
/// Accuracy: exact to rounding on flat meshes that are seen whole from one source, and of first
/// order in the edge length h elsewhere. Measured: 0.08 h on spheres at a quarter turn, 0.8 h at
/// the opposite pole; 0.14 h around a curved row of sources; 0.4 h where two fronts meet; 0.9 h
/// behind a hole; up to 0.3 h on flat meshes whose triangles are nearly all very obtuse, where
/// taking vertices again is stopped after 20 times.
///
/// Throws InputError when there are no sources. O(n log n).
/// Source: after Kimmel and Sethian 1998; the two-point update of Novotni and Klein 2002.
VecX geodesic_distances(const TriangleMesh& mesh, const std::vector<int>& sources,
                        double farthest = std::numeric_limits<double>::infinity());

/// Vertices up to `distance` from the nearest source along the surface (geodesic_distances).
Selection vertices_within(const TriangleMesh& mesh, const std::vector<int>& sources,
                          double distance);

/// The vertices with `rings` rings of neighbours around them.
Selection grown(const MeshTopology& topology, const std::vector<int>& vertices, int rings);

/// The given vertices that have a neighbour that is not given.
Selection border(const MeshTopology& topology, const std::vector<int>& vertices);

/// All corners of the triangles.
Selection vertices_of_triangles(const MeshTopology& topology, const std::vector<int>& triangles);

/// Triangles, ascending, with at least one corner among the vertices.
std::vector<int> triangles_touching(const MeshTopology& topology, const std::vector<int>& vertices);

/// Vertices in one or the other; in both; in the first but not in the second.
Selection union_of(const Selection& a, const Selection& b);
Selection intersection_of(const Selection& a, const Selection& b);
Selection difference_of(const Selection& a, const Selection& b);

/// Number of the part of each node, what hangs together by faces; -1 for nodes without. Parts are
/// numbered by their lowest nodes.
std::vector<int> node_components(const MeshTopology& topology);

/// The vertex nearest to a point in space; of equally near ones the lowest. Throws InputError when
/// no vertex has triangles. O(n).
int nearest_vertex(const TriangleMesh& mesh, const Vec3& point);


// Where a mesh draws the eye, and regions grown from there.

/// Mesh saliency of every vertex, 0 … 1:
///
///     C         mean curvature, δ_i · n_i (mesh/differential_operators.h; n_i the vertex normal)
///     G(C, σ)   mean of C over the vertices within 2σ, weights A_j exp(-|p_j - p_i|² / 2σ²)
///     S_σ       |G(C, σ) - G(C, 2σ)|,   σ = 2ε, 3ε, 4ε, 5ε, 6ε,   ε = 0.003 of the box diagonal
///     S         Σ_σ N(S_σ), divided by its largest value
///
/// N: the map is divided by its maximum and multiplied by (1 - m̄)², m̄ the mean of its other local
/// maxima, so that maps with a few high peaks count for more than evenly busy ones. The areas A_j
/// (the paper has none) keep finer parts of a mesh from counting more. 0 everywhere on what bends
/// nowhere (|C| below 1e-9 over the size).
///
/// O(n · vertices within 0.072 of the diagonal), in parallel: 10 s of one core for 100,000 vertices. Throws InputError for a mesh without
/// triangles. Source: Lee, Varshney, Jacobs 2005; Itti, Koch, Niebur 1998 (N).
VecX mesh_saliency(const TriangleMesh& mesh);

/// The vertices that paths along edges reach from `picked` without meeting a saliency under
/// `threshold`, ascending. Throws InputError: not one number a vertex, a vertex out of range, or one
/// that is itself under the threshold (the message has its saliency).
std::vector<int> grown_region(const TriangleMesh& mesh, const VecX& saliency, int picked,
                              double threshold);

}  // namespace batten
