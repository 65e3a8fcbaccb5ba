// SPDX-License-Identifier: MPL-2.0
// Target surfaces for fit_model(), given by triangle meshes and by curved facets of CAD faces.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Facets (triangles, curved triangles, mesh elements) of one or several target surfaces.
struct TargetFaces {
  ShellMesh shells;  ///< facets of the target surfaces; points in model units
  /// For each facet, the unit normals at the corners if the facet is a curved (PN) triangle; empty
  /// if the facet is flat.
  std::vector<std::optional<PnTriangle::Corners>> normals;
  std::vector<int> part;  ///< for each facet, index of its CAD face; -1: from a mesh
  /// Smallest unused index of a CAD face.
  int next_part = 0;
  /// Primitives of the CAD faces that are analytic (TargetSurface::is_analytic()); Kind::Free for
  /// surfaces of revolution and extruded surfaces that are no primitives.
  std::map<int, FittedPrimitive> analytic;
  /// Largest distance of facets from the CAD faces that they approximate, model units.
  double deviation = 0;

  TargetFaces() { shells.points.resize(0, 3); }
  /// Appends the facets `more`, with coordinates multiplied by `scale`. `corners`: unit normals at
  /// the corners of each facet, or empty for flat facets. `faces`: CAD face of each facet, or empty
  /// for facets of meshes. Curved triangles whose height is at most 1e-9 of the longest edge are
  /// omitted: their interior is never the closest part of the target.
  void append(const ShellMesh& more, double scale,
              const std::vector<PnTriangle::Corners>& corners = {},
              const std::vector<int>& faces = {});
};

/// A target surface for fit_model(), and its parts if it has several: CAD faces, and mesh patches
/// enclosed by creases (feature_lines()). See ModelFitOptions::parts.
struct TargetParts {
  std::shared_ptr<const TargetSurface> whole;
  std::vector<std::shared_ptr<const TargetSurface>> parts;
};

/// Creates a target surface for fit_model() from facets. Facets with normals are curved PN
/// triangles (PnTriangle) [Vlachos2001]; the others are flat. Points on CAD faces that are primitives
/// (planes, cylinders, cones, spheres, tori) are exact: the closest points of their facets are
/// replaced by those of the primitive.
///
/// The distance between samples is at most 1/100 of the size of the target, with at most 64 samples
/// per triangle edge. A part with a single boundary loop has a harmonic parametrization
/// (HarmonicMap). Throws InputError as prepare() does. O(n log n) for n facets.
TargetParts target_parts(const TargetFaces& faces);

}  // namespace batten
