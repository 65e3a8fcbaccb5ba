// Turns the areas of loads and weights into numbers for each triangle.
#pragma once

#include <string>
#include <vector>

#include "batten/sculpting/loads/loads.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Returns for each triangle the mean of the weight w in [0, 1] that Area describes, by seven
/// points of the triangle; a triangle that the boundary cuts counts as a whole. Distances to a line
/// or a stroke are measured from the points of `reference`, a shape on the layout's mesh. To a line
/// they are measured to its fitted curve, right to 1e-3 of the radius. w is 0 in regions that the
/// area does not name. Throws InputError: an unknown line or region (the nearest name is offered),
/// a radius not > 0, no strokes, numbers that are not finite, a reference on another mesh.
/// O(triangles + strokes · triangles).
VecX triangle_weights(const Area& area, const ModelLayout& layout, const Surface& reference);

/// Returns for each triangle a unit vector in (u, v): the tangent of the line's image at the point
/// that is nearest to the triangle's centre (by chords of 1/16 of a segment); zero in regions that
/// do not have the line. On a ring u is not taken modulo the period: its rims run straight along u
/// and do not need it. Throws InputError for an unknown line. O(triangles · segments).
std::vector<Vec2> triangle_directions(const std::string& line, const ModelLayout& layout);

}  // namespace batten
