// SPDX-License-Identifier: MPL-2.0
// Shapes of a whole model: rest shapes, lofts, and fair (minimum-variation) shapes.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/fairing/minimum_variation/minimum_variation_surface.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Computes the dofs of the rest shapes of all faces of a model, in absolute coordinates. A rest
/// shape is the surface that a face's boundary curves suggest; a face with SkinOptions::rest =
/// false has no rest shape. The dofs of faces without a rest shape are zero. The result has no rows
/// if no face has a rest shape, or if ModelMetadata::rest is false.
///
///     two, three or four sides   sweeps with transported sections (docs/theory/sweeps.md)
///     annulus                    the loft through its boundary circles and its closed inner curves
///     closed smooth outline      if a smooth join connects it to a face with a rest shape: the
///                                shape of least bending energy that continues these faces, which
///                                keep their shapes (a patch that fills a hole)
///     others                     none: five or more sides, a planar boundary
///
/// Pass the result to ModelLayout::minimize_energy(): the solution is then the rest shape plus the
/// displacement of minimum energy that inner curves, smooth joins and loads require. Cost:
/// O(vertices + edges) of the faces with a rest shape.
Points rest_dofs(const ModelLayout& layout);

/// Assembles the dofs of a model from known rest shapes, one per face. No rows in an entry of
/// `of_regions`: the face has no rest shape of its own, only one that continues its neighbours.
Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions);

/// Computes the dofs of the rest shape of one face, in absolute coordinates; no rows if the face
/// has no rest shape.
Points rest_dofs(const RegionLayout& region);

/// Area of the rest shape of one face if its sides determine it well: two opposite sides have
/// similar shapes (Sweep::mismatch() below 0.25); otherwise 0. `rest`: rest_dofs() of the face.
/// O(triangles).
double reliable_rest_area(const RegionLayout& region, const Points& rest);

/// True if the face has five or more sides that are not coplanar. Such a face has no pairs of
/// opposite sides, and therefore no rest shape. The minimum-variation surface (fair_shape()) is the
/// best choice among the surfaces through the boundary curves: see the table in docs/fairness.md.
bool has_many_sides(const RegionLayout& region);

/// Bending energy ½ qᵀKq ≥ 0 of the shape with dofs q = `dofs` (absolute coordinates) relative to a
/// flat rest state, with the bending stiffness matrix K of the model scaled to size one.
/// `material`: only the bending stiffness beta is used. Cost: one assembly of K.
double bending_energy(const ModelLayout& layout, const Points& dofs, SurfaceStiffness material);

// Rest shapes of sessions as functions: sculpting/session calls them, skinning/shapes makes them.

/// Input of a RestShapeFunction. All dofs are in absolute coordinates.
struct RestShapeInput {
  const ModelLayout& layout;
  const ConstraintSet& rows;  ///< current constraints, including curves and curve offsets
  const Points& bent;         ///< shape of minimum bending energy that satisfies `rows`
  /// The shape that satisfies `rows` and has the least bending energy relative to the rest shape
  /// that the first call on this mesh returned. It is a good initial shape, and independent of the
  /// order of previous changes. No rows: this call is the first one on this mesh.
  const Points& near;
  const Progress& progress;
};

/// Function that computes the rest shape of an interactive session: the reference configuration of
/// zero elastic energy, from which loads, offsets and constraints bend the surface.
///
/// The rest shape need not satisfy the constraints. If the result has no rows, the rest state is
/// flat: the elastic energy is that of the shape itself, as in thin-plate interpolation of the
/// curves.
using RestShapeFunction = std::function<Points(const RestShapeInput&)>;

// Deviation of a surface from the rest shape of its boundary curves.

/// Largest distance of a face from its rest shape (rest_dofs()), and two lengths of comparison.
struct RestShapeDeviation {
  double distance = 0;  ///< largest distance, at a mesh vertex, model units
  Vec3 at = Vec3::Zero();
  /// Width of the face, model units: the shorter side of a rectangle that has the area and the
  /// perimeter of the rest shape.
  double across = 0;
  /// Depth of the boundary curves, model units. The depth of an open curve is its largest distance
  /// from its chord; that of a closed curve is the smallest distance from its centre. The value is
  /// the smallest depth above 1e-2 of the size of the face; 0 if no curve has such a depth.
  double depth = 0;

  /// True if the surface differs from the rest shape by more than a tenth of `across`, or by more
  /// than half of `depth`. Examples are soap films, and tubes that narrow between their sections.
  bool is_large() const { return distance > 0.1 * across || (depth > 0 && distance > 0.5 * depth); }
};

/// Measures the deviation of the skinned face `made` from its rest shape; nullopt if the face has
/// no rest shape. Cost: one rest_dofs().
std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made);

// Lofts: shapes that are splines, or straight, across sections.

/// Computes the loft through sections: the shape closest (ModelLayout::nearest()) to a surface that
/// interpolates corresponding points of all sections by cubic splines with not-a-knot end
/// conditions. Between only two sections, the surface is ruled (section_surface.h).
///
/// The sections of an annulus are its boundary circles. The sections of a face with four corners
/// are the side that contains one of the curves named in `sections`, and the opposite side. Inner
/// curves that run along these sides are sections, too. Faces without sections get the shape of
/// minimum bending energy. The result satisfies ModelLayout::line_constraints(). Dofs are in
/// absolute coordinates.
///
/// Throws InputError if the model has no annulus and `sections` is empty, or if a section is not a
/// curve of the model or not a side of a face with four corners; ConflictError; NoSolutionError.
/// Cost: one factorization for one coordinate.
Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections);

/// Result of loft_model(): the refined layout, and the dofs of the loft on this layout, in absolute
/// coordinates.
struct LoftedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// Computes loft_shape() on an adaptively refined mesh. Triangles in which the surface deviates
/// from the exact loft by more than `most` (model units) are bisected, in at most four iterations.
/// For example, refinement is needed between the leading edges of two wing sections. After each
/// bisection, the smooth joins are planned again.
LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most);

// Curvature-continuous (G2) joins.

/// Determines whether fairing makes the curvature continuous (G2) across a smooth join. If
/// JoinLine::curvature is set, it is the answer. Otherwise the curves that cross the join at its
/// ends decide. Let κ_A and κ_B be the normal curvatures, at an end, of two curves that continue
/// each other across the join; the surfaces must have the same curvatures there. The curvature is
/// made continuous unless, summed over the ends with such curves,
///
///     Σ |κ_A - κ_B| > ½ Σ max(|κ_A|, |κ_B|),
///
/// for example between a cylinder and its cap. It is made continuous if no curves continue each
/// other across the join. False for a rejected join, and for one with a given surface.
bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan);

/// Computes sample points on all curvature-continuous joins, and on all smooth joins on embedded
/// curves, as input of minimize_curvature_variation(): two Gauss points per mesh edge or hat
/// function. On embedded curves, the angle between the tangent planes is penalised, too, because
/// the constraints of a join on an embedded curve control only averages.
std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout);

// Fair shapes of models: minimum-variation surfaces [MoretonSequin1992] under the constraints of
// the curves.

/// Computes the minimum-variation surface of a model under the given constraints, by descent from
/// `start`. It calls minimize_curvature_variation() with the sides of all faces, and with a
/// suitable weight of the Gaussian curvature (MinimumVariationOptions::gauss). This weight is 100
/// if no face has corners, inner curves or given neighbours: annuli then become cylinders and cones
/// if possible.
///
/// For a model with annuli, loft_shape() is a second initial shape, which prevents long tubes from
/// being pinched, unless `options` specifies other initial shapes. Smooth joins stay smooth, and
/// the curvature is continuous across those for which is_curvature_continuous() is true. Dofs are
/// in absolute coordinates.
///
/// `constraints`: ModelLayout::line_constraints() and any additional constraints. `options`: the
/// members gauss, sides and joins are overwritten. Throws as minimize_curvature_variation() does.
MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options = {},
                                   const Progress& progress = {});

// Transfer of a shape to another mesh.

/// Interpolates a shape onto a finer layout of the same faces, for example after
/// ModelLayout::refine(). `dofs`: absolute dofs on `layout`. The result contains absolute dofs on
/// `finer`. It is exact in triangles that both meshes contain; see interpolate_onto(Surface,
/// ParametricMesh) in fem/refinement.h.
Points interpolate_onto(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer);

}  // namespace batten
