// SPDX-License-Identifier: MPL-2.0
// Finds defects of surfaces: inverted, folded, intersecting or far too large faces.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Finds the defects of solved faces: inverted, folded, intersecting or far too large surfaces. The
/// result is ordered by SurfaceDefect::Kind.
///
/// Face indices in the result refer to `regions`, of which null entries are skipped. `qualities`:
/// measure() of each face. `expected_areas`: for each face
/// LayoutCandidate::expected_area, or 0 if that is unknown. The surfaces are checked on facets, four per element:
///
///  Jacobian  SkinQuality::min_jacobian_ratio is not positive;
///  Fold      inside a face: normals of adjacent facets differ by more than 120°.
///            Between two faces along a curve: a crease of any angle may be intended (from a box
///            to a knife edge), but one face must not fold back onto the other. The wedge angle
///            between the faces (180° if they continue in one plane) is therefore compared with
///            the angle that the curves require. At each end of the common curve, the next curve
///            of each face determines the tangent plane of the face; in between, the required
///            angle is interpolated linearly. A defect is a wedge below 30° and below half of the
///            required angle (or below 0.05°), along more than a tenth of the common curve. If no
///            curve determines a tangent plane (closed curves without nodes), the limit is 30°.
///            The value is 180° minus the sharpest wedge angle;
///  Crossing  facets without a common point that intersect, or overlap in one plane
///            (facet_intersections()). Near curves that the faces share only within a gap,
///            intersections within a tenth of an edge length are ignored. Near edges with a wedge
///            below 30°, intersections no deeper than the distance of facets from surface are
///            ignored;
///  Area      the area of the face is more than twice its entry in `expected_areas`.
///
/// At most one defect is reported per kind and face, or pair of faces. Cost: O(facets log facets).
/// Throws InputError if the lengths of the arguments differ, and as facets() does.
std::vector<SurfaceDefect> find_defects(const std::vector<const SkinnedRegion*>& regions,
                                        const std::vector<SkinQuality>& qualities,
                                        const std::vector<double>& expected_areas);

// Intersections of facets.

/// Two facets (triangles) that intersect, indices a < b, and a point of their intersection.
struct FacetIntersection {
  int a, b;
  Vec3 where;
};

/// Finds the pairs of triangular facets that intersect: an edge of one facet pierces the other one,
/// or they overlap in one plane.
///
/// `facets`: three indices into `points` per facet. `joined`: `facets` with one common index for
/// all points that count as one point. Pairs of facets with a common index in `joined` are ignored.
/// Pairs that intersect only within the distance `near` (model units) of boundary sides of both
/// facets are ignored, because two surfaces may approximate a shared curve by different points.
/// `surface_of`: index of the surface that contains each facet. Facets of zero area and facets with
/// non-finite corners intersect nothing. Pairs are ordered by a, then b. Cost: O(n log n) for a
/// surface of n facets (BoxTree); parallel.
std::vector<FacetIntersection> facet_intersections(const std::vector<Vec3>& points,
                                                   const std::vector<std::array<int, 3>>& facets,
                                                   const std::vector<std::array<int, 3>>& joined,
                                                   const std::vector<int>& surface_of, double near);

/// Finds the boundary sides of triangulated surfaces: the sides of facets that no second facet of
/// the surface shares. The result contains pairs (facet, side) in ascending order. Side i runs from
/// corner i to corner i + 1. Empty `surface_of` (surface index per facet): all facets belong to one
/// surface. Cost: O(n log n).
std::vector<std::pair<int, int>> boundary_sides(const std::vector<std::array<int, 3>>& facets,
                                                const std::vector<int>& surface_of = {});

}  // namespace batten
