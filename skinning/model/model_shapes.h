// The shape that the boundary curves of each region mean, from which all else bends the surface.
#pragma once

#include <vector>
#include <optional>
#include <memory>
#include <string>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/fairing/minimum_variation/minimum_variation_surface.h"
#include "batten/core/progress.h"

namespace batten {

/// Dofs of the rest shapes of all regions, 0 in regions that have none; no rows where none has, or
/// where ModelMetadata::rest or SkinOptions::rest is off. Absolute coordinates.
///
///     two, three or four sides   sweeps with transported sections (docs/theory/sweeps.md)
///     ring                       the loft through its rims and its closed inner curves
///     others                     none: five sides and more, a closed outline, a boundary in a plane
///
/// As the rest shape of ModelLayout::minimize_energy() it costs no energy: the surface is the rest shape
/// plus the displacement of least energy that inner curves, smooth joins and loads ask for.
/// O(vertices + edges) of these regions.
Points rest_dofs(const ModelLayout& layout);

/// The same where the rest shapes of the regions, one for each, are known.
Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions);

/// The same of one region, in its own numbers; no rows: it has none.
Points rest_dofs(const RegionLayout& region);

/// Whether the region has five sides or more, not all in a plane. None of them is opposite to another,
/// so that there is nothing to sweep; among surfaces that all boundary curves allow, the one whose
/// curvature changes least (fair_model.h) is nearest to what is meant: docs/fairness.md has the table.
bool has_many_sides(const RegionLayout& region);


// How far a surface is from the blend of its boundary curves.

/// Largest distance of a region from its rest shape (rest_shape.h), and what it is compared with.
struct RestShapeDeviation {
  double distance = 0;  ///< between the two at vertices of the mesh, model units
  Vec3 at = Vec3::Zero();
  /// Distance between the sides: the shorter side of the rectangle with the rest shape's area and perimeter.
  double across = 0;
  /// Depth of the sections: of the boundary curves that bend, the least distance by which one leaves its
  /// chord (a closed one: its centre). 0 where none bends by more than 1e-2 of the size.
  double depth = 0;

  /// Above a tenth of the distance between the sides, or half of the depth, a surface is another one
  /// than its boundary curves mean: a film, or sections that get thinner in between.
  bool is_large() const { return distance > 0.1 * across || (depth > 0 && distance > 0.5 * depth); }
};

/// Nothing where the region has no rest shape. Costs one rest_dofs().
std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made);


// Shapes that run straight, or as splines, across sections: lofts.

/// The shape nearest (ModelLayout::nearest()) to one that runs through sections as a spline: on each
/// line across them the cubic through their points, with ends that are not flat; straight between
/// two (section_surface.h). Sections are, of a ring, its rims; of a region with four corners the
/// side that one of `sections` is part of and the opposite side; and inner lines that run along
/// them. Other regions bend least. Every line is held as always. Dofs are in absolute coordinates.
///
/// Throws InputError: no ring and no sections, a section that is no line of the model, or no side of
/// a region with four corners. ConflictError, NoSolutionError. Cost: one factor of one coordinate.
Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections);

struct LoftedModel {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
};

/// loft_shape() on a mesh that is fine enough for it: triangles in which the surface through the
/// sections is missed by more than `most`, model units, are halved, in at most four rounds (between
/// the noses of two sections the mesh of their lines would be too coarse). Smooth joins are planned
/// again then.
LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most);


// Smooth joins across which the curvature goes on.

/// Whether fairing lets the curvature go on across a smooth join: what JoinLine::curvature says or,
/// where it says nothing, what the lines do that cross it at its ends. Two lines that go on into
/// each other there, one on each side, have normal curvatures κ_A and κ_B, and the surfaces must
/// have the same ones. It goes on unless, over the ends at which there are such lines,
///
///     Σ |κ_A - κ_B| > ½ Σ max(|κ_A|, |κ_B|),
///
/// as where a cap meets a cylinder. Without such lines it goes on. False for a plan that is given
/// up.
bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan);

/// The points, two for each edge or hat, of all joins across which the curvature goes on, and of
/// those on embedded lines. On these the jump of the tangent plane counts too, since the rows of
/// such a join leave it open between its hats; elsewhere the rows hold it.
std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout);


// Fair shapes of models: curvature that changes as little as their lines allow.

/// Fairs a shape of a model under these rows (those of its lines, and any others), downhill from
/// `start`: minimize_curvature_variation() with the sides of all regions and the weight of Gauss curvature that
/// suits them (large on rings between two rims alone: they become cylinders and cones where they
/// can). A model with rings starts from loft_shape() too (if `options` has no other starts), which does not pinch long ones. Smooth
/// joins stay smooth, and curvature goes on across those that is_curvature_continuous() names. Dofs are
/// in absolute coordinates.
///
/// Of `options`, gauss, sides and joins are chosen here. `constraints` as of
/// ModelLayout::line_constraints(). Throws as minimize_curvature_variation().
MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options = {},
                                   const Progress& progress = {});

}  // namespace batten
