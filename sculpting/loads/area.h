// Areas of loads and weights as numbers of each triangle.
#pragma once

#include <string>
#include <vector>

#include "batten/sculpting/loads/loads.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// The mean over each triangle (of its part inside, for a cut one: of the whole) of the weight
/// w in [0, 1] that Area describes, by seven points. `reference`: the shape on the layout's mesh
/// whose points are near to a line, or to a stroke. NearLine: near the line's fitted curve; the
/// distance is right to 1e-3 of the radius, and is taken only where it may be less than the radius.
/// 0 in regions that the area does not name. Throws InputError: an unknown line or region (the
/// nearest name is offered), a radius not > 0, no strokes, numbers that are not finite, a reference
/// on another mesh. O(triangles + strokes · triangles).
VecX triangle_weights(const Area& area, const ModelLayout& layout, const Surface& reference);

/// At each triangle's centre, the unit tangent in (u, v) of the nearest point of a line's image
/// (to 1/16 of its segments), in regions that have the line; zero in others. The lines of a ring
/// run straight along u, so its seam plays no part. Throws InputError for an unknown line.
/// O(triangles · segments).
std::vector<Vec2> triangle_directions(const std::string& line, const ModelLayout& layout);

}  // namespace batten
