// Inside of skinning: what the makers of domains pass on.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/region/region_parts.h"
#include "batten/skinning/region/skin_options.h"

namespace batten {

/// The numbers that all domains go by. Lengths in model units.
struct DomainTask {
  SkinOptions options;
  double size;       ///< diagonal of the box of all lines
  double tolerance;  ///< of lines
  double edge;       ///< target length of element edges
  double join;       ///< ends that are nearer than this meet
};

/// Domain numbers are rounded to this, so that lines given in mm and in m, which differ in their
/// last bits, make the same mesh.
inline double rounded(double x) {
  constexpr double grid = 1 << 30;
  return std::round(x * grid) / grid;
}
inline Vec2 rounded(const Vec2& p) { return {rounded(p.x()), rounded(p.y())}; }
inline Vec3 rounded(const Vec3& p) { return {rounded(p.x()), rounded(p.y()), rounded(p.z())}; }

/// Slopes dc/dt carry 1/length; `span`: of the parameter.
inline Vec3 rounded_slope(const Vec3& slope, double span) {
  return rounded(Vec3(span * slope)) / span;
}

/// Side of a square as large as two of the triangle.
inline double local_size(const ParametricMesh& mesh, int triangle) {
  return std::sqrt(2 * mesh.shape(triangle).area);
}

/// Between two points of the domain, or their images one period away.
inline double domain_distance(const ParametricMesh& mesh, const Vec2& p, const Vec2& q) {
  return (mesh.image_near(p, q) - q).norm();
}

/// Of embedded lines: whether they bound the region.
std::vector<char> boundary_lines(const RegionParts& parts);

/// A polygon whose sides are the loop's sides between corners; every line of the loop is a run.
/// Inner lines become straight runs across where they can; those that cannot, and those that are to
/// be embedded, are returned in `others` (one that is to be fitted is refused). `polygon`: its
/// corners, or none: then from the lengths of the sides and the angles between them. Throws
/// InputError; NoPolygon where the polygon has no area or, with Domain::Auto, less than a quarter
/// of what the loop encloses seen from its side.
RegionParts polygon_parts(const Outline& loop, const std::vector<Stretch>& inner,
                          const DomainTask& task, const std::vector<Vec2>* polygon,
                          std::vector<Stretch>& others);

/// A plane: the domain is the lines' own projection, scaled to size 1; all lines are embedded. u
/// is the projection of the x axis (y, where the plane is at right angles to x). The mesh covers
/// the outline; nothing is cut yet. Throws InputError when the outline does not project simply.
RegionParts plane_parts(const Outline& loop, const std::vector<Outline>& holes,
                        const std::vector<Stretch>& inner, const DomainTask& task);

/// Whether plane_parts() would take the outline: nowhere steeper than 84 degrees against its plane,
/// corners neither flattened nor turned over, its projection simple (sampled).
bool projects_simply(const Outline& loop, const DomainTask& task);

/// A sheet: the outline flattened as a strip of paper would be that spans it. Its plain hole
/// filling (plain_fill.h), whose triangles have all their corners on the outline, unfolds into the
/// plane without any strain; the outline's image c(t) is the C1 curve of least squares through the
/// unfolded points, with corners where the outline has them and as wide as there, scaled to size 1.
/// Where it would overlap itself, it is relaxed (relax_polygon). Lines are embedded. The mesh
/// covers the outline; nothing is cut yet. u runs along the first line, from its start to its end.
/// Throws InputError: no simple image. 10 to 30 ms.
RegionParts sheet_parts(const Outline& loop, const DomainTask& task);

/// The lines of a loop as curves in the loop's direction, not yet placed in (u, v).
std::vector<EmbeddedLine> embedded_loop(const Outline& loop, const DomainTask& task);

/// An inner line as a curve, not yet placed in (u, v).
EmbeddedLine embedded_inner(const Stretch& line, const DomainTask& task);

/// Squares of the task's edge length with alternating diagonals over the box of the loops. Throws
/// InputError for more than two million triangles.
std::shared_ptr<const ParametricMesh> squares_over(const DomainLoops& loops,
                                                   const DomainTask& task);

/// Adds holes and inner lines to parts that have a shape: their images are the nearest points of
/// the surface. Throws InputError for lines that are not near it.
void embed_on(const Surface& surface, const std::vector<Outline>& holes,
              const std::vector<Stretch>& inner, const DomainTask& task, RegionParts& parts);

/// Halves the marked triangles and what it takes to stay conforming; runs follow. Trim and points
/// are then those of the old mesh, until cut_and_place().
void halve(RegionParts& parts, const std::vector<char>& marked);

/// Parameters at which each embedded line must have a point: where an inner line ends on another
/// line, or crosses it. Ends of inner lines within the join of another line are moved onto it.
/// Throws InputError: lines that cross in the domain, but not in space.
std::vector<std::vector<double>> junctions(RegionParts& parts, const DomainTask& task);

/// Cuts the mesh of parts by their embedded boundary, drops what lies outside, and places the
/// points of all embedded lines. Throws InputError: boundary loops that cross, touch or are nested
/// wrongly, inner lines that leave the region or cross at different heights.
void cut_and_place(RegionParts& parts, const DomainTask& task);

/// The rows that hold all lines, fitted and embedded.
ConstraintSet line_rows(const RegionParts& parts, TriangleElement element);

/// Halves triangles where lines or holes bend more tightly than elements of their size can follow
/// (radius below two sizes), before anything is cut.
void grade_by_curvature(RegionParts& parts, const DomainTask& task);

/// Halves triangles under the stretches between points whose gap is above `target` (model units).
/// False when there is none, or nothing may be halved any more.
bool refine_at_gaps(RegionParts& parts, const Surface& surface, double target,
                    const DomainTask& task);

}  // namespace batten
