// Reference functions of the rational triangle Z12.
#pragma once

#include "batten/elements/triangle_shape.h"

namespace batten {

/// reference_functions() of Z12 at barycentric L; at a vertex second derivatives are the limits
/// along the bisecting direction.
ReferenceTabulation z12_functions(const Vec3& L);

}  // namespace batten
