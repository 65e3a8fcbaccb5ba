// SPDX-License-Identifier: MPL-2.0
// Dimensions of a mesh: distances, radii, angles, areas, volumes, masses.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/triangle_mesh.h"
#include "batten/scenes/meshes/edit_session.h"
#include "batten/scenes/meshes/vertex_selector.h"

namespace batten {

/// A [[dimension]] of a deform scene: the vertices and faces are selected once on the undeformed
/// mesh, and measured at any positions.
///
/// The centre of a part is that of the circle fitted to a circular hole, otherwise the mean of its
/// vertices (of a hole: of its loop). The axis of a part is that of a hole, otherwise the mean
/// normal of its faces, weighted with their areas. The faces of a part are those with all vertices
/// in it.
class MeshDimension {
 public:
  /// Keeps a reference to `mesh`. Throws InputError, with the location, for an unknown name, the
  /// radius of a hole that is not circular, a part without faces that needs some, and the volume of
  /// a surface that is not closed.
  MeshDimension(const DeformScene& scene, const DimensionSpec& rule,
                const std::vector<FormFeature>& features, VertexSelector& select,
                const TriangleMesh& mesh);

  const std::string& name() const { return rule_.name; }
  DimensionSpec::Kind kind() const { return rule_.kind; }
  /// The value at vertex positions (n×3): model units, their powers, or degrees; a mass in the unit
  /// of density × length³. O(vertices and faces of the part).
  double value(const Points& points) const;

 private:
  /// What one name refers to.
  struct Part {
    std::vector<int> vertices;  // of a hole: its loop, in order
    bool hole = false, circular = false;
    std::vector<std::array<int, 3>> triangles;
  };
  Part part_of(const DeformScene& scene, const LocatedString& name,
               const std::vector<FormFeature>& features, VertexSelector& select,
               const TriangleMesh& mesh) const;
  void check(const DeformScene& scene, const TriangleMesh& mesh) const;
  static Vec3 centre(const Part& part, const Points& points);
  static Vec3 area_vector(const Part& part, const Points& points);
  static Vec3 axis(const Part& part, const Points& points);
  static double area(const Part& part, const Points& points);

  DimensionSpec rule_;
  std::vector<Part> parts_;
};

/// All dimensions of a scene; see MeshDimension::MeshDimension().
std::vector<MeshDimension> mesh_dimensions(const DeformScene& scene,
                                           const std::vector<FormFeature>& features,
                                           VertexSelector& select, const TriangleMesh& mesh);

}  // namespace batten
