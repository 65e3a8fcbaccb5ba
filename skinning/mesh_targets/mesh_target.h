// Target surfaces for fit_model(), given by triangle meshes and by curved facets of CAD faces.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Facets of one or several targets.
struct TargetFaces {
  ShellMesh shells;
  /// Corner normals of curved (PN) triangles.
  std::vector<std::optional<PnTriangle::Corners>> normals;
  std::vector<int> part;  ///< index of the CAD face of each triangle; -1: from a mesh
  /// Next free CAD face index.
  int next_part = 0;

  TargetFaces() { shells.points.resize(0, 3); }
  /// Appends facets, multiplied by `scale`. `corners`: unit normals of curved triangles, or empty;
  /// `faces`: CAD face of each facet, or empty. Omits degenerate curved triangles, whose height is
  /// at most 1e-9 of the longest edge: no point is nearest to their interior.
  void append(const ShellMesh& more, double scale,
              const std::vector<PnTriangle::Corners>& corners = {},
              const std::vector<int>& faces = {});
};

/// A target, and its parts if there are several: CAD faces, and mesh patches enclosed by creases
/// (feature_lines()). See ModelFitOptions::parts.
struct TargetParts {
  std::shared_ptr<const TargetSurface> whole;
  std::vector<std::shared_ptr<const TargetSurface>> parts;
};

/// Creates a target from facets. Triangles with normals are curved PN triangles (PnTriangle), the
/// others are flat.
///
/// Its samples are spaced by at most 1/100 of the size, with at most 64 per edge of a triangle. A
/// part with one boundary has a harmonic parametrization (HarmonicMap). Throws InputError like
/// prepare(). O(facets · log facets).
TargetParts target_parts(const TargetFaces& faces);

}  // namespace batten
