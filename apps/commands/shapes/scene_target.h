// Target surfaces of [[target]].
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

// Facets of target files.

/// Facets of all targets.
struct TargetFaces {
  ShellMesh shells;
  std::vector<std::optional<PnTriangle::Corners>> normals;  ///< corner normals of curved (PN)
                                                            ///< triangles
  std::vector<int> part;  ///< index of the CAD face of each triangle; -1: from a mesh
  /// Next free CAD face index.
  int next_part = 0;

  TargetFaces() { shells.points.resize(0, 3); }
  /// Appends facets, multiplied by `scale`. `corners`: normals of curved triangles, or empty;
  /// `faces`: CAD face of each facet, or empty.
  void append(const ShellMesh& more, double scale,
              const std::vector<PnTriangle::Corners>& corners = {},
              const std::vector<int>& faces = {});
};

/// A target, and its parts if there are several: CAD faces, and mesh patches enclosed by creases
/// (feature_lines()).
struct TargetParts {
  std::shared_ptr<const TargetSurface> whole;
  std::vector<std::shared_ptr<const TargetSurface>> parts;
};

/// Creates the target with a sample spacing of at most 1/100 of the size. Throws InputError like
/// prepare().
TargetParts target_parts(const TargetFaces& faces);

/// The smallest tolerance of the scene's targets; a target without one has 1e-4 of the model's
/// size.
double target_tolerance(const Scene& scene, double size);

/// Combines all targets of a scene into one surface in the scene's unit. Meshes are used unchanged;
/// CAD faces become curved triangles within a quarter of the tolerance. Throws InputError that
/// begins with the location in the scene.
TargetParts target_of(const Scene& scene, double size, const Progress& progress = {});

}  // namespace batten
