// Lines that only trim a surface: where they are, it says.
#pragma once

#include "batten/fem/surface.h"

namespace batten {

/// The curve x(c(t)) of a surface over an image c(t) in (u, v). `pcurve` gets the nodes that the
/// curve needs to be within `tolerance` of it (4,096 at most). Cost: O(nodes).
HermiteCurve curve_on_surface(const Surface& surface, HermiteCurve& pcurve, double tolerance);

}  // namespace batten
