// Triangle mesh generators for polygonal domains, with a size field, and limits on mesh size.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

// Spatially varying edge length.

/// Longest allowed element edge as a function over the domain, in domain units. It is linear
/// between the vertices of a background mesh. Outside of that mesh it has the value of the nearest
/// point.
class SizeField {
 public:
  /// `lengths`: one length, > 0, for each vertex of the background mesh.
  SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths);

  /// Longest allowed edge at a point of the domain.
  double at(const Vec2& uv) const;
  double at_vertex(int vertex) const { return lengths_[vertex]; }

 private:
  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleLocator locator_;
  std::vector<double> lengths_;
};

/// Input of a mesh generator: points that must become vertices, and segments between them that must
/// become chains of edges. The segments of the outline form one closed counter-clockwise polygon.
/// Those of each hole form another polygon, in either direction. Segments may share end points and
/// touch nowhere else.
struct PlanarMeshInput {
  std::vector<Vec2> points;
  std::vector<std::array<int, 2>> outline, inner;
  double edge_length = 0;  ///< target length of edges
  std::vector<std::vector<std::array<int, 2>>> holes{};
  /// Segments are not split: each becomes one edge of the mesh. Next to short segments, triangles
  /// grow gradually to the target length. The minimum angle may be violated next to segments.
  bool keep_segments = false;
  /// Lengths below the target, used only with `keep_segments`; null: none.
  std::shared_ptr<const SizeField> size_field{};
  Progress progress{};  ///< cancellation is polled every thousand vertices
};

/// Computes a constrained Delaunay triangulation, refined to the target length, and smooths it.
/// Angles are above 20.7 degrees where the input allows (CGAL Mesh_2).
///
/// The first vertices of the result are the input points in their order. Further vertices, and the
/// triangles, are in the order of a space-filling curve. Segments may be split further unless
/// `keep_segments` is set. Throws InputError if the build has no CGAL or segments cross, and
/// CancelledError.
ParametricMesh delaunay_mesh(const PlanarMeshInput& task);
/// True if this build has CGAL.
bool have_delaunay_mesher();

/// Builds a fan of triangles from the centroid of the outline polygon to its sides and splits every
/// triangle into four, `refinements` times. Segments of the outline are thus split evenly. Throws
/// InputError if the polygon is not star-shaped about its centroid, or if there are inner segments
/// or holes.
ParametricMesh fan_mesh(const PlanarMeshInput& task, int refinements);

// Limits on mesh size and tolerance.

/// Estimated peak memory in bytes for skinning a mesh of this many triangles. Most of it is the
/// matrix factorization, which grows as n log n.
double bytes_for_triangles(double triangles);

/// Throws InputError for a mesh that is too large: more than two million triangles, or more than
/// fit into the available memory (available_memory()). The message gives the memory required, and
/// an edge_length that would need half of the available memory. `what`: "a face", "an annular face",
/// for the message. `edge_length`, `size`: model units.
void require_mesh_size(double triangles, double edge_length, double size, const std::string& what);

/// The same check for all regions of a model together, with at least 2 kB per triangle. The memory
/// of the joint factorization is checked later, when it is planned (SparseCholesky).
void require_model_size(double triangles, double edge_length, double size);

/// Largest number of triangles of a region.
inline constexpr double kMaxTriangles = 2e6;

/// Largest number of triangles of a region after refinement under its embedded lines: 50,000, or
/// ten times the number that follows from its size and edge length, (size/edge_length)²; at most
/// kMaxTriangles.
double max_refined_triangles(double edge_length, double size);

/// Throws InputError for a line tolerance below 1e-9 of the size: shapes are not computed more
/// accurately than that.
void require_tolerance(double tolerance, double size);

}  // namespace batten
