// Faces of files as a surface to fit to.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/mesh/pn_triangle.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

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

}  // namespace batten
