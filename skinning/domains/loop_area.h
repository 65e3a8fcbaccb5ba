// Computes the area that a loop of lines encloses, and its angles seen from that side.
#pragma once

#include <vector>

#include "batten/skinning/domains/outline.h"

namespace batten {

/// Returns the unit area vector of the loop: it points to the side from which the loop runs
/// counter-clockwise. Throws InputError when it encloses no area seen from any side.
Vec3 loop_normal(const Outline& outline);
/// Returns whether it encloses an area seen from some side.
bool encloses_area(const Outline& outline);
/// Returns the area that it encloses seen from the side of loop_normal(), model units².
double enclosed_area(const Outline& outline);

/// Returns the interior angle at each corner, radians in (0, 2π); `convex`: in (0, π). Otherwise, whether the loop turns to the
/// left or to the right there is seen from the loop's side, or from the side of its developable
/// filling where the loop leaves its plane by more than a fifth of the size, or the corner stands
/// upright on it within 30 degrees. Throws InputError when
/// the loop encloses no area seen from any side. It takes microseconds, with a filling up to 10 ms.
std::vector<double> corner_angles(const Outline& outline, bool convex);

}  // namespace batten
