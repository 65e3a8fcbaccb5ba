// The surfaces of [[target]].
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/scene/scene.h"
#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

// Faces of files as a surface to fit to.

/// Faces of all targets.
struct TargetFaces {
  ShellMesh shells;
  std::vector<std::optional<PnTriangle::Corners>> normals;  ///< of triangles that bulge
  std::vector<int> part;  ///< number of each one's CAD face; -1: of a mesh
  int next_part = 0;

  TargetFaces() { shells.points.resize(0, 3); }
  /// `corners`: normals of triangles that bulge, or none; `faces`: the CAD face of each one, or none.
  void append(const ShellMesh& more, double scale,
              const std::vector<PnTriangle::Corners>& corners = {},
              const std::vector<int>& faces = {});
};

/// A target, and its parts where it has several: faces of CAD files, and what creases of meshes enclose
/// (feature_lines()).
struct TargetParts {
  std::shared_ptr<const TargetSurface> whole;
  std::vector<std::shared_ptr<const TargetSurface>> parts;
};

/// Samples are not farther apart than 1/100 of the size. Throws InputError as prepare().
TargetParts target_parts(const TargetFaces& faces);


/// The smallest of the tolerances that a scene states, 1e-4 of the model's size for those that state none.
double target_tolerance(const Scene& scene, double size);

/// All targets of a scene as one surface, in the scene's unit: meshes as they are, faces of CAD files as
/// curved triangles within a quarter of the tolerance. Throws InputError that begins with the place in the scene.
TargetParts target_of(const Scene& scene, double size, const Progress& progress = {});

}  // namespace batten
