// Local refinement of a conforming mesh.
#pragma once

#include <vector>

#include "batten/fem/parametric_mesh.h"

namespace batten {

/// A finer mesh. Old vertices keep their numbers; new ones follow, in the order of the edges that
/// they halve.
struct Bisection {
  ParametricMesh mesh;
  std::vector<int> midpoint;  ///< new vertex at the middle of each old edge, or -1
};

/// Halves the marked triangles across their longest edges, and so many others that the mesh stays
/// conforming (Rivara 1984). Angles do not fall below half of the smallest angle of the first mesh,
/// however often it is called; right isosceles triangles keep their shape. Triangles that are
/// halved stand, as two to four, where they stood. O(triangles) and a few sweeps.
Bisection bisected(const ParametricMesh& mesh, const std::vector<char>& marked);

/// The mesh of these triangles alone, vertices in their old order.
struct Submesh {
  ParametricMesh mesh;
  std::vector<int> vertex;  ///< number in the part of each old vertex, or -1
};
Submesh extract_submesh(const ParametricMesh& mesh, const std::vector<int>& triangles);

}  // namespace batten
