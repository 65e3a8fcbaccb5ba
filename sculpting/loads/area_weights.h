// Evaluates areas of loads and stiffness fields as one weight or one direction per triangle.
#pragma once

#include <string>
#include <vector>

#include "batten/sculpting/loads/loads.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Computes the mean weight w in [0, 1] of an area on each triangle, with seven points per
/// triangle.
///
/// Triangles that the boundary cuts count as a whole. Distances to a line or stroke are measured
/// from the points of `reference`, a shape on the layout's mesh. Distances to a line are measured
/// to its fitted curve, accurate to 1e-3 of the radius. w is 0 in regions that the area does not
/// name.
///
/// Throws InputError for an unknown line or region (the message suggests the closest name), a
/// radius not > 0, missing strokes, numbers that are not finite, and a reference on another mesh.
/// O(triangles + strokes · triangles).
VecX triangle_weights(const Area& area, const ModelLayout& layout, const Surface& reference);

/// Computes a unit vector in (u, v) for each triangle: the tangent of the line's pcurve at the
/// point closest to the triangle's centroid (by chords of 1/16 of a segment).
///
/// The vector is zero in regions that do not contain the line. On annular domains u is not taken
/// modulo the period, because the boundary circles run straight along u. Throws InputError for an
/// unknown line. O(triangles · segments).
std::vector<Vec2> triangle_directions(const std::string& line, const ModelLayout& layout);

}  // namespace batten
