// SPDX-License-Identifier: MPL-2.0
// Declares the functions that build the parametric domains of a region, and their common input.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Input that is the same for all types of domain. Lengths are in model units.
struct DomainInput {
  SkinOptions options;   ///< with tolerance and edge_length above 0: defaults are resolved
  double size;           ///< diagonal of the bounding box of all lines
  double gap_tolerance;  ///< ends of lines within this distance are joined
};

/// Rounds a domain coordinate to a multiple of 2⁻³⁰. The same lines given in mm and in m differ in
/// their last bits; after rounding they produce the same mesh.
inline double round_to_grid(double x) {
  constexpr double grid = 1 << 30;
  return std::round(x * grid) / grid;
}
inline Vec2 round_to_grid(const Vec2& p) { return {round_to_grid(p.x()), round_to_grid(p.y())}; }
inline Vec3 round_to_grid(const Vec3& p) {
  return {round_to_grid(p.x()), round_to_grid(p.y()), round_to_grid(p.z())};
}

/// Rounds a slope dc/dt, multiplied by `span`, to the same grid. `span`: length of the parameter
/// interval; it makes the result independent of the unit of the parameter.
inline Vec3 round_slope_to_grid(const Vec3& slope, double span) {
  return round_to_grid(Vec3(span * slope)) / span;
}

/// Size of a triangle: the side of a square of twice its area.
inline double local_size(const ParametricMesh& mesh, int triangle) {
  return std::sqrt(2 * mesh.shape(triangle).area);
}

/// Distance of two points in the domain. In an annular (u-periodic) domain it is measured to the
/// nearest periodic copy of `q`.
inline double domain_distance(const ParametricMesh& mesh, const Vec2& p, const Vec2& q) {
  return (mesh.image_near(p, q) - q).norm();
}

/// Computes one flag per embedded line: 1 if the line is part of the region's boundary.
std::vector<char> boundary_line_flags(const RegionGeometry& geometry);

/// Largest number of corners of a polygonal domain.
inline constexpr size_t kMaxPolygonCorners = 100;

/// Builds a polygonal domain, whose sides are the sides of the loop between its corners. Every
/// outline line becomes edge-aligned: a straight chain of element edges.
///
/// Inner lines become straight edge-aligned chains across the polygon if that is possible. Lines
/// for which it is impossible, and lines with MeshAlignment::Embedded, are returned in `others`.
/// `polygon`: corners in (u, v), or null to compute them from the lengths of the sides and the
/// angles between them (fit_polygon()).
///
/// Throws InputError, also for an inner line with MeshAlignment::EdgeAligned that cannot be
/// edge-aligned. Throws NoPolygonError if the polygon has no area or, with Domain::Auto, less than
/// a quarter of the area that the loop encloses in projection along its normal.
RegionGeometry make_polygon_geometry(const Outline& loop, const std::vector<SmoothSegment>& inner,
                                     const DomainInput& task, const std::vector<Vec2>* polygon,
                                     std::vector<SmoothSegment>& others);

/// Builds a projected domain: all lines are projected onto the plane of the outline, scaled to size
/// 1, and embedded. u runs along the projection of the x axis, or of the y axis if the plane's
/// normal is within 26 degrees of x. The mesh covers the outline and is not trimmed yet. Throws
/// InputError if the outline has no simple projection.
RegionGeometry make_projected_geometry(const Outline& loop, const std::vector<Outline>& holes,
                                       const std::vector<SmoothSegment>& inner,
                                       const DomainInput& task);

/// Tests whether make_projected_geometry() can be used for the outline, by samples. The outline
/// must be nowhere steeper than 84 degrees against its plane. Its projection must not cross itself,
/// and must neither flatten nor invert a corner.
bool has_simple_projection(const Outline& loop, const DomainInput& task);

/// Builds a developable domain, by unfolding a developable surface through the outline.
/// developable_triangulation() of the sampled outline has all its corners on the outline, so it
/// unfolds into the plane without strain.
///
/// The outline's pcurve c(t) is the C1 curve fitted to the unfolded points by least squares, scaled
/// to size 1. It has corners where the outline has them, with the same angles. If the unfolded
/// polygon overlaps itself, relax_polygon() replaces it. All lines are embedded; the mesh covers
/// the outline and is not trimmed yet. u runs along the first line, from its start to its end.
///
/// Throws InputError if no simple pcurve is found. It takes 10 to 30 ms.
RegionGeometry make_developable_geometry(const Outline& loop, const DomainInput& task);

/// Fits C1 cubic curves to the lines of a loop, in the loop's direction. The pcurves stay empty.
std::vector<EmbeddedLine> fit_loop_lines(const Outline& loop, const DomainInput& task);

/// Fits a C1 cubic curve to an inner line. The pcurve stays empty.
EmbeddedLine fit_inner_line(const SmoothSegment& line, const DomainInput& task);

/// Builds a grid of squares of side `task.options.edge_length` (scaled), split by alternating diagonals,
/// that covers the bounding box of the loops. Throws InputError for more than two million
/// triangles.
std::shared_ptr<const ParametricMesh> make_grid_mesh(const DomainLoops& loops,
                                                     const DomainInput& task);

/// Adds holes and inner lines to a region whose outline alone already defines a surface. Their
/// pcurves pass through the closest points on that surface. Throws InputError for a line that is
/// far from the surface (more than half of the region's size).
void embed_on_surface(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry);

/// Bisects the marked triangles, and others as needed to keep the mesh conforming. Edge-aligned
/// lines get the new vertices. The trim and the collocation points still refer to the old mesh
/// until trim_and_collocate() is called.
void bisect_marked(RegionGeometry& geometry, const std::vector<char>& marked);

/// Finds the parameters at which each embedded line must have a collocation point: where another
/// embedded line ends on it or crosses it. Ends of inner lines that are within the gap tolerance of
/// another line are moved onto that line. Throws InputError if two lines cross in the domain, but
/// are farther apart than the tolerance in space.
std::vector<std::vector<double>> find_junctions(RegionGeometry& geometry, const DomainInput& task);

/// Trims the mesh by the embedded boundary, drops triangles outside of it, and chooses the
/// collocation points of all embedded lines. Throws InputError for boundary loops that cross, touch
/// or are nested wrongly, and for inner lines that leave the region or cross at different positions
/// in space.
void trim_and_collocate(RegionGeometry& geometry, const DomainInput& task);

/// Builds the constraint equations that keep the surface on all lines, edge-aligned and embedded.
ConstraintSet make_line_constraints(const RegionGeometry& geometry, TriangleElement element);

/// Bisects triangles where the radius of curvature of an embedded line is below twice their size,
/// too small for the elements to follow. Call it before the mesh is trimmed. It stops at
/// max_refined_triangles().
void refine_by_curvature(RegionGeometry& geometry, const DomainInput& task);

/// Bisects triangles where the gap between surface and embedded line, between two collocation
/// points, exceeds `target` (model units). Returns false if there is no such gap, or if no triangle
/// may be bisected any more: they are too small, or the mesh would exceed max_refined_triangles().
/// In the latter case it adds a warning.
bool refine_at_gaps(RegionGeometry& geometry, const Surface& surface, double target,
                    const DomainInput& task);

// Splits inner lines at the boundaries of holes.

/// Splits inner lines at the boundaries of holes and drops the parts inside of holes. If several
/// parts of a line remain, their names are "name.1", "name.2", and so on. Line and hole boundary
/// are intersected in projection along the mean normal of the hole, and must then be within
/// `task.gap_tolerance` of each other. Prescribed curves stay whole, because the curve network has
/// split them already.
///
/// Cost: O(samples of lines × samples of hole boundaries). Throws InputError for a line that passes
/// a hole boundary at a larger distance, and for a line that lies completely inside of a hole. The
/// message has the names, the position, the distance and a remedy.
std::vector<SmoothSegment> split_at_holes(const std::vector<SmoothSegment>& inner,
                                          const std::vector<Outline>& holes,
                                          const DomainInput& task);

}  // namespace batten
