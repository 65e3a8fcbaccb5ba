// Shapes of a whole model: rest shapes, lofts, and fair (minimum-variation) shapes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/fairing/minimum_variation/minimum_variation_surface.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Computes the dofs of the rest shapes of all regions, in absolute coordinates. A rest shape is
/// the surface that a region's boundary curves suggest; a region with SkinOptions::rest = false has
/// none. Regions without one have zeros. The result has no rows if no region has one, or if
/// ModelMetadata::rest is false.
///
///     two, three or four sides   sweeps with transported sections (docs/theory/sweeps.md)
///     annulus                    the loft through its boundary circles and its closed inner curves
///     others                     none: five or more sides, a closed outline, a planar boundary
///
/// As the rest shape of ModelLayout::minimize_energy() it has zero energy. The solution is the rest
/// shape plus the displacement of minimum energy that inner curves, smooth joins and loads require.
/// O(vertices + edges) of these regions.
Points rest_dofs(const ModelLayout& layout);

/// Assembles the model's dofs from known rest shapes, one per region (no rows: none).
Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions);

/// Computes the rest shape of one region, with its own dof numbers; no rows if it has none.
Points rest_dofs(const RegionLayout& region);

/// True if the region has five or more sides that are not coplanar. No side is opposite to another
/// one, so there is nothing to sweep. The minimum-variation surface (fair_shape()) is then the best
/// choice among surfaces through the boundary curves: see the table in docs/fairness.md.
bool has_many_sides(const RegionLayout& region);

/// Bending energy ½ qᵀKq of a shape, that of a flat rest state being 0, on the model scaled to size
/// 1; at least 0. `dofs`: absolute. `material`: its alpha is not used. One assembly.
double bending_energy(const ModelLayout& layout, const Points& dofs, SurfaceStiffness material);

// Deviation of a surface from the rest shape of its boundary curves.

/// Largest distance of a region from its rest shape (rest_dofs()), with lengths for comparison.
struct RestShapeDeviation {
  double distance = 0;  ///< maximum over the vertices of the mesh, model units
  Vec3 at = Vec3::Zero();
  /// Distance between the sides: the shorter side of the rectangle with the rest shape's area and
  /// perimeter.
  double across = 0;
  /// Depth of the sections, model units. For each boundary curve it is the largest distance from
  /// its chord or, if it is closed, the smallest distance from its centre. The depth is the minimum
  /// over the curves whose value exceeds 1e-2 of the size; 0 if there is none.
  double depth = 0;

  /// True if the surface differs from what its boundary curves suggest: by more than a tenth of the
  /// distance between the sides, or half of the depth. Examples are soap films, and sections that
  /// shrink in between.
  bool is_large() const { return distance > 0.1 * across || (depth > 0 && distance > 0.5 * depth); }
};

/// Measures the deviation; nullopt if the region has no rest shape. Cost: one rest_dofs().
std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made);

// Lofts: shapes that are splines, or straight, across sections.

/// Computes the loft through sections: the shape closest (ModelLayout::nearest()) to one that is a
/// spline across them. On each line across the sections it is the not-a-knot cubic through their
/// points, straight between two sections (section_surface.h).
///
/// Sections of an annulus are its boundary circles. Those of a region with four corners are the
/// side that one of `sections` is part of, and the opposite side. Inner lines that run along them
/// are sections too. Other regions get the shape of minimum bending. All lines are constrained as
/// usual. Dofs are in absolute coordinates.
///
/// Throws InputError if there are neither annuli nor sections, or if a section is not a line of the
/// model or not a side of a region with four corners; ConflictError, NoSolutionError. Cost: one
/// factorization for one coordinate.
Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections);

/// Result of loft_model(): the refined layout, and the absolute dofs of the loft on it.
struct LoftedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// Computes loft_shape() and refines the mesh for it. Triangles in which the surface deviates from
/// the exact loft by more than `most` (model units) are bisected, in at most four iterations. This
/// is necessary between the noses of two wing sections, for example: the curves alone would give a
/// mesh that is too coarse there. After each bisection, the constraints of smooth edges are planned
/// again.
LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most);

// Curvature-continuous (G2) joins.

/// Determines whether fairing makes the curvature continuous across a smooth join.
/// JoinLine::curvature decides if it is set. Otherwise the lines that cross the join line at its
/// ends decide. Two lines that continue each other there, one on each side, have normal curvatures
/// κ_A and κ_B, which the surfaces must share. The curvature is continuous unless, summed over the
/// ends with such lines,
///
///     Σ |κ_A - κ_B| > ½ Σ max(|κ_A|, |κ_B|),
///
/// as where a cap meets a cylinder. Without such lines it is continuous. False for a rejected plan.
bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan);

/// Samples all curvature-continuous joins, and all joins on embedded lines, at two Gauss points per
/// edge or hat. On embedded lines the jump of the tangent plane is penalised too, because the
/// constraints of such a join leave it open between its hats. On other lines the constraints
/// enforce it.
std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout);

// Fair shapes of models: minimum-variation surfaces [MoretonSequin1992] under the constraints of
// the lines.

/// Computes the minimum-variation surface of a model under the given constraints, by descent from
/// `start`. It calls minimize_curvature_variation() with the sides of all regions, and a suitable
/// weight of Gaussian curvature. The weight is 100 if no region has corners or inner lines: annuli
/// then become cylinders and cones if possible.
///
/// A model with annuli also starts from loft_shape(), which avoids pinched long tubes, unless
/// `options` has other starts. Smooth joins stay smooth, and the curvature is continuous across
/// those for which is_curvature_continuous() is true. Dofs are in absolute coordinates.
///
/// `options`: gauss, sides and joins are overwritten here. `constraints`: those of
/// ModelLayout::line_constraints(), and any others. Throws as minimize_curvature_variation().
MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options = {},
                                   const Progress& progress = {});

// Transfer of a shape to another mesh.

/// Interpolates a shape onto a finer layout of the same regions, for example after
/// ModelLayout::refine(). `dofs`: absolute dofs on `layout`; returns those on `finer`. Exact where
/// the meshes agree; see interpolate_onto(Surface, ParametricMesh) in fem/refinement.h.
Points interpolate_onto(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer);

}  // namespace batten
