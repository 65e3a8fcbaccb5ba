// Rings: regions between two smooth closed rims, as tubes, skirts and annuli.
#pragma once

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Returns whether two rims run in one direction around the ring between them. `a`, `b`: the same
/// number of points, evenly around each rim. Through a tube they do when their area vectors point
/// to the same side along the way from rim to rim. Where these do not decide (an annulus), they do
/// when points at equal shares of the rims lie nearer together than they would with one rim turned
/// over, from the best start in both cases. O(n²).
bool circles_have_same_direction(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// Makes a strip that is periodic in u: rim A along v = 0, in the direction of its first line, rim
/// B along v = V. It has no singular point, and the rims are straight runs of element edges:
///
///   U = mean length of the rims / size          u runs evenly with the arc length of each rim
///   V = mean distance of matched points / size
///
/// Points of equal u are matched: of the two directions of rim B and all its starts, those that
/// make the sum of squared distances between points at equal fractions of arc length least, so that
/// the strip is not twisted. Both rims become closed C1 cubic curves within the tolerance, whose
/// nodes lie on columns of the mesh. A rim of one line may begin anywhere: one of them is cut where
/// it matches the start of the other, and both begin at u = 0. Where lines join on both rims, the
/// columns tilt by up to half an edge so that each ends on a joint.
///
/// The mesh: right triangles, rows × columns with cells as near to squares of the wished edge as
/// the lines' nodes allow, diagonals alternating.
///
/// `a`, `b`: loops without corners, as make_loops() finds them. The parts have a mesh, one run for
/// each line (those of rim A first, along each rim; the vertices of a rim that is one closed line
/// name the first one again at the end) and two boundary loops: rim A with u, rim B against it.
/// Throws InputError in words for the user: a rim with a corner, rims that coincide, an edge length
/// that means more than 2 million triangles. Cost: O(columns · rows).
RegionGeometry make_annulus_geometry(const Outline& a, const Outline& b, const DomainInput& task);

/// Embeds holes and inner lines in a ring that has a shape. c(t) are the nearest points of the
/// surface; of an inner line that crosses no other one they are spread over it as evenly as the
/// line is long (nearest points crowd where a line bulges away from the surface). Images run on
/// over the seam, beyond [0, U]; a line begins in [0, U). A closed line that runs around the ring
/// ends one period from where it begins: its curve and its image are open curves then, whose ends
/// meet on the ring. Throws InputError as embed_on_surface() does, for a hole around the ring, and for an
/// inner line that is to be fitted. O(triangles · lines).
void embed_on_annulus(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry);

}  // namespace batten
