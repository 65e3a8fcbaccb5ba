// The area that a loop of lines encloses, and the angles that it has seen from that side.
#pragma once

#include <vector>

#include "batten/skinning/domains/outline.h"

namespace batten {

/// Unit area vector of the loop: the side from which it runs counter-clockwise. Throws InputError
/// when it encloses no area seen from any side.
Vec3 loop_normal(const Outline& outline);
bool encloses_area(const Outline& outline);
/// Seen from that side, model units².
double enclosed_area(const Outline& outline);

/// Interior angle at each corner, radians in (0, 2π): whether it turns to the left or to the right
/// is seen from the loop's side, or from that of its developable filling where the loop is not
/// nearly plane (out of it by more than a fifth of the size). Throws InputError when the loop
/// encloses no area seen from any side. Microseconds, or those of the filling (10 ms at most).
std::vector<double> corner_angles(const Outline& outline);

}  // namespace batten
