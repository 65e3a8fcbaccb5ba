// Triangle meshes of a polygonal domain, behind one interface.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/skinning/domains/size_field.h"

namespace batten {

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

}  // namespace batten
