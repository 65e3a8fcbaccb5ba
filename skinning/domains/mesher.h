// SPDX-License-Identifier: MPL-2.0
// Triangle mesh generators for polygonal domains, with a size field, and limits on mesh size.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

// Spatially varying edge length.

/// Longest allowed element edge as a function of the position in the domain, in domain units. The
/// function is interpolated linearly on a background mesh. Outside of this mesh, it has the value
/// at the nearest point of the mesh.
class SizeField {
 public:
  /// Constructs a field of edge lengths from values on a background mesh. `lengths`: longest
  /// allowed element edge at each vertex of `mesh`, domain units, > 0.
  SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths);

  /// Longest allowed element edge at a point of the domain, in domain units.
  double at(const Vec2& uv) const;
  double at_vertex(int vertex) const { return lengths_[vertex]; }

 private:
  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleLocator locator_;
  std::vector<double> lengths_;
};

/// Input of a mesh generator: points that must become vertices, and segments between them that must
/// become chains of edges. The segments of the outline form one closed counter-clockwise polygon.
/// The segments of each hole form a closed polygon in either direction. Segments may share end
/// points, but must not touch anywhere else.
struct PlanarMeshInput {
  std::vector<Vec2> points;
  std::vector<std::array<int, 2>> outline, inner;
  double edge_length = 0;  ///< target length of mesh edges, in domain units
  std::vector<std::vector<std::array<int, 2>>> holes{};
  /// True: the input segments are not split, so that each one becomes one edge of the mesh. From
  /// short segments, triangles grow gradually to the size `edge_length`. Triangles at segments may
  /// have angles below the minimum of 20.7 degrees that delaunay_mesh() otherwise aims at.
  bool keep_segments = false;
  /// Target length of mesh edges that varies over the domain, below `edge_length`; used only with
  /// `keep_segments`. Null: `edge_length` everywhere.
  std::shared_ptr<const SizeField> size_field{};
};

/// Computes a constrained Delaunay triangulation (CGAL Mesh_2), refined to `task.edge_length`, and
/// smooths it. Angles are above 20.7 degrees if the input permits.
///
/// The first vertices of the result are the input points in their order. The other vertices, and
/// the triangles, are in the order of a space-filling curve. Segments may be split unless
/// `task.keep_segments` is true. Throws InputError if the build has no CGAL or if segments cross;
/// CancelledError.
ParametricMesh delaunay_mesh(const PlanarMeshInput& task);
/// True if delaunay_mesh() is available, that is, if this build has CGAL.
bool have_delaunay_mesher();

/// Builds a fan of triangles from the centroid of the outline polygon to its sides and splits every
/// triangle into four, `refinements` times. Segments of the outline are thereby split into equal
/// parts. Throws InputError if the polygon is not star-shaped about its centroid, or if there are
/// inner segments or holes.
ParametricMesh fan_mesh(const PlanarMeshInput& task, int refinements);

// Limits on mesh size and tolerance.

/// Estimated peak memory in bytes for skinning a mesh of this many triangles. Most of the memory is
/// used by the matrix factorization: O(n log n) for n triangles.
double bytes_for_triangles(double triangles);

/// Throws InputError for a mesh that is too large: more than two million triangles, or more than
/// fit into the available memory (available_memory()). The message contains the required memory,
/// and an edge length for which half of the available memory would suffice. `edge_length` (target
/// length) and `size` (of the face): model units. `what`: subject of the message, such as "a face".
void require_mesh_size(double triangles, double edge_length, double size, const std::string& what);

/// Throws InputError if all faces of a model together have too many triangles for the available
/// memory, assuming at least 2 kB per triangle. The memory of the factorization is checked in its
/// symbolic analysis (SparseCholesky). `edge_length` (target length) and `size` (of the model):
/// model units.
void require_model_size(double triangles, double edge_length, double size);

/// Largest allowed number of triangles of a face.
inline constexpr double kMaxTriangles = 2e6;

/// Largest allowed number of triangles of a face after refinement under embedded curves: the larger
/// one of 50,000 and 10 (size / edge_length)², but at most kMaxTriangles. `size`: size of the face.
double max_refined_triangles(double edge_length, double size);

/// Throws InputError if `tolerance`, the largest allowed distance between curves and their fits, is
/// below 1e-9 of `size`, the size of the face or model. This is the accuracy of computed shapes.
void require_tolerance(double tolerance, double size);

}  // namespace batten
