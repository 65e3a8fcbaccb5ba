// What attracts the cuts of feature_cut.h and stroke_cut.h.
#pragma once

namespace batten {

struct CutOptions {
  /// η of edges where the surface bends towards its normals, and away from them. The one with the
  /// larger η attracts the cut. Which is which turns round with the mesh's orientation; for a
  /// feature seen from its hollow side swap them.
  double concave = 1, convex = 0.2;
  /// A vertex of the feature; -1: the feature is the side with the smaller area.
  int feature_vertex = -1;
};

}  // namespace batten
