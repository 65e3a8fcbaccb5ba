// Triangle meshes of a polygonal domain, behind one interface.
#pragma once

#include <memory>
#include <vector>
#include <string>

#include "batten/core/progress.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

// How long the edges of elements may be at each place of a domain.

/// Longest edges of elements over a domain, in its units: linear between the vertices of a background
/// mesh, and outside of it as at its nearest point.
class SizeField {
 public:
  /// One length, > 0, for each vertex of the background mesh.
  SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths);

  double at(const Vec2& uv) const;
  double at_vertex(int vertex) const { return lengths_[vertex]; }

 private:
  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleLocator locator_;
  std::vector<double> lengths_;
};


/// What is to be meshed: points that must become vertices, and segments between them that must
/// become rows of edges. The segments of the outline form one closed counter-clockwise polygon,
/// those of each hole another one, in either direction. Segments may share end points and touch
/// nowhere else.
struct PlanarMeshInput {
  std::vector<Vec2> points;
  std::vector<std::array<int, 2>> outline, inner;
  double edge_length = 0;  ///< target length of edges
  std::vector<std::vector<std::array<int, 2>>> holes{};
  /// Segments stay whole: each is one edge of the mesh. Where they are short, triangles grow from
  /// them to the target; angles are kept only where no segment is in the way.
  bool keep_segments = false;
  /// Shorter edges than the target, where segments are kept; null: none.
  std::shared_ptr<const SizeField> size_field{};
  Progress progress{};  ///< asked whether to go on, every thousand vertices
};

/// Makes a constrained Delaunay triangulation, refined to the target length with angles above 20.7
/// degrees where the input allows (CGAL's Mesh_2), then smoothed. The result's first vertices are
/// the task's points in their order; vertices and triangles that follow are in spatial order.
/// Segments may be split further, unless the task keeps them. Throws InputError: no CGAL, segments
/// that cross; CancelledError.
ParametricMesh delaunay_mesh(const PlanarMeshInput& task);
/// Returns whether this build has CGAL.
bool have_delaunay_mesher();

/// Makes a fan of triangles from the centre of the outline's polygon to its sides and cuts every
/// triangle in four, `refinements` times; segments of the outline are cut evenly. Throws InputError
/// when the polygon is not star-shaped about its centre, or there are inner segments or holes.
ParametricMesh fan_mesh(const PlanarMeshInput& task, int refinements);


// Whether a mesh can be afforded, and a tolerance reached.

/// Bytes that skinning takes at its highest for a mesh of so many triangles: mostly its factor,
/// which grows as n log n.
double bytes_for_triangles(double triangles);

/// Throws InputError for a mesh that is too large: of more than two million triangles, or for which
/// there is not enough memory (available_memory). The message says how much it would take, and which
/// edge_length needs half of what there is. `what`: "a region", "a ring"; `edge_length`, `size` in model
/// units.
void require_mesh_size(double triangles, double edge_length, double size, const std::string& what);

/// The same for all regions of a model together: at least 2 kB a triangle. What the factor of
/// regions in one shape takes is asked for when it is planned (SparseCholesky).
void require_model_size(double triangles, double edge_length, double size);

inline constexpr double kMaxTriangles = 2e6;

/// Returns how many triangles a region may have after those under its embedded lines were halved:
/// 50,000, or ten times those of its size and edge length, (size/edge)².
double max_refined_triangles(double edge_length, double size);

/// Throws InputError for a tolerance of lines below 1e-9 of the size: shapes are not computed more
/// exactly.
void require_tolerance(double tolerance, double size);

}  // namespace batten
