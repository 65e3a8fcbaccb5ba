// Inside of skinning: the functions that make domains, and what they share.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The numbers that are the same for all domains. Lengths are in model units.
struct DomainInput {
  SkinOptions options;
  double size;           ///< diagonal of the box of all lines
  double tolerance;      ///< of lines: largest distance from their curves
  double edge_length;    ///< target length of element edges
  double gap_tolerance;  ///< ends that are nearer than this meet
  Progress progress{};
};

/// Rounds a coordinate of the domain to a multiple of 2⁻³⁰, so that lines given in mm and in m,
/// which differ in their last bits, make the same mesh.
inline double round_to_grid(double x) {
  constexpr double grid = 1 << 30;
  return std::round(x * grid) / grid;
}
inline Vec2 round_to_grid(const Vec2& p) { return {round_to_grid(p.x()), round_to_grid(p.y())}; }
inline Vec3 round_to_grid(const Vec3& p) {
  return {round_to_grid(p.x()), round_to_grid(p.y()), round_to_grid(p.z())};
}

/// Rounds a slope dc/dt in the same way, times `span`, the length of the parameter's range: so the
/// unit of the parameter does not matter.
inline Vec3 round_slope_to_grid(const Vec3& slope, double span) {
  return round_to_grid(Vec3(span * slope)) / span;
}

/// Returns the size of a triangle: the side of a square that is as large as two of them.
inline double local_size(const ParametricMesh& mesh, int triangle) {
  return std::sqrt(2 * mesh.shape(triangle).area);
}

/// Returns the distance of two points of the domain, of a ring to the nearest image of the other.
inline double domain_distance(const ParametricMesh& mesh, const Vec2& p, const Vec2& q) {
  return (mesh.image_near(p, q) - q).norm();
}

/// Returns for each embedded line whether it bounds the region.
std::vector<char> boundary_line_flags(const RegionGeometry& geometry);

/// Makes a polygon whose sides are the loop's sides between corners; every line of the loop is a
/// run. Inner lines become straight runs across where they can; those that cannot, and those that
/// are to be embedded, are returned in `others` (one that is to be fitted is refused). `polygon`
/// gives the corners in (u, v); null: they follow from the lengths of the sides and the angles
/// between them. Throws InputError, and NoPolygonError where the polygon has no area or, with
/// Domain::Auto, less than a quarter of what the loop encloses seen from its side.
RegionGeometry make_polygon_geometry(const Outline& loop, const std::vector<SmoothSegment>& inner,
                                     const DomainInput& task, const std::vector<Vec2>* polygon,
                                     std::vector<SmoothSegment>& others);

/// Makes a plane: the domain is the projection of the lines, scaled to size 1, and all lines are
/// embedded. u runs along the projection of the x axis (of the y axis, where the plane's normal is
/// within 26 degrees of x). The mesh covers the outline; nothing is cut yet. Throws InputError when
/// the outline does not project simply.
RegionGeometry make_projected_geometry(const Outline& loop, const std::vector<Outline>& holes,
                                       const std::vector<SmoothSegment>& inner,
                                       const DomainInput& task);

/// Returns whether make_projected_geometry() would take the outline: it is nowhere steeper than 84 degrees
/// against its plane, the projection neither flattens corners nor turns them over, and does not
/// cross itself (by samples).
bool has_simple_projection(const Outline& loop, const DomainInput& task);

/// Makes a sheet: the outline is flattened like a strip of paper that spans it. Its developable
/// filling (triangulate_hole.h), whose triangles have all their corners on the outline, unfolds into the
/// plane without any strain. The outline's image c(t) is the C1 curve of least squares through the
/// unfolded points, with corners where the outline has them and as wide as there, scaled to size 1.
/// An image that would overlap itself is relaxed (relax_polygon). Lines are embedded. The mesh
/// covers the outline; nothing is cut yet. u runs along the first line, from its start to its end.
/// Throws InputError: no simple image. It takes 10 to 30 ms.
RegionGeometry make_developable_geometry(const Outline& loop, const DomainInput& task);

/// Returns the lines of a loop as curves in the loop's direction, without images.
std::vector<EmbeddedLine> fit_loop_lines(const Outline& loop, const DomainInput& task);

/// Returns an inner line as a curve, without an image.
EmbeddedLine fit_inner_line(const SmoothSegment& line, const DomainInput& task);

/// Makes a mesh of squares of the task's edge length, with alternating diagonals, over the box of
/// the loops. Throws InputError for more than two million triangles.
std::shared_ptr<const ParametricMesh> make_grid_mesh(const DomainLoops& loops,
                                                     const DomainInput& task);

/// Adds holes and inner lines to parts that have a shape: their images are the nearest points of
/// the surface. Throws InputError for lines that are not near it.
void embed_on_surface(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry);

/// Halves the marked triangles and those that must be halved too for the mesh to stay conforming;
/// runs get their new vertices. Trim and points are those of the old mesh until trim_and_collocate().
void bisect_marked(RegionGeometry& geometry, const std::vector<char>& marked);

/// Returns for each embedded line the parameters at which it must have a point: where another
/// embedded line ends on it or crosses it. Ends of inner lines that are within the join distance of
/// another line are moved onto it. Throws InputError: lines that cross in the domain, but are apart
/// by more than the tolerance in space.
std::vector<std::vector<double>> find_junctions(RegionGeometry& geometry, const DomainInput& task);

/// Cuts the mesh of parts by their embedded boundary, drops what lies outside, and places the
/// points of all embedded lines. Throws InputError: boundary loops that cross, touch or are nested
/// wrongly, inner lines that leave the region or cross at different heights.
void trim_and_collocate(RegionGeometry& geometry, const DomainInput& task);

/// Returns the rows that hold all lines, fitted and embedded.
ConstraintSet make_line_constraints(const RegionGeometry& geometry, TriangleElement element);

/// Halves triangles where lines or holes bend more tightly than elements of their size can follow
/// (radius below two sizes), before anything is cut; no more once there are max_refined_triangles().
void refine_by_curvature(RegionGeometry& geometry, const DomainInput& task);

/// Halves triangles where the gap between two points of an embedded line is above `target` (model
/// units). Returns false when there is no such gap, or no triangle may be halved any more: they are
/// too small, or the mesh would have more than max_refined_triangles(); then it warns.
bool refine_at_gaps(RegionGeometry& geometry, const Surface& surface, double target,
                    const DomainInput& task);


// Inner lines end where a hole takes the surface away.

/// Cuts inner lines at the rims of holes and drops what lies in a hole; a line of which several
/// pieces are left becomes "name.1", "name.2", … Rim and line must meet within the task's join
/// distance where they cross, seen along the mean normal of the hole. Given curves stay whole: a
/// network has cut them. Cost: O(samples of lines × samples of rims).
/// Throws InputError: a line that passes a rim farther away (with both names, place, distance and
/// remedy), a line that lies in a hole from end to end.
std::vector<SmoothSegment> split_at_holes(const std::vector<SmoothSegment>& inner,
                                          const std::vector<Outline>& holes,
                                          const DomainInput& task);

}  // namespace batten
