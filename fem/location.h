// A point on the triangles of a mesh.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// A point of a surface mesh: triangle and barycentric coordinates in it.
struct Location {
  int triangle = 0;
  Vec3 L = Vec3::Constant(1.0 / 3);
};

}  // namespace batten
