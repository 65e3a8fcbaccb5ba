// Catmull-Clark subdivision of polygon cages, and points of the limit surface.
#pragma once

#include <array>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

struct CatmullClarkOptions {
  int rounds = 4;  ///< each makes four quads of a quad, n of a polygon with n corners
  /// Edges of the cage that stay sharp, by their nodes. So do edges with other than two faces: rims, and
  /// where three faces meet.
  std::vector<std::array<int, 2>> creases = {};
};

/// The limit surface of a cage as quads whose nodes lie on it. With f the means of the faces around a node v
/// of n edges and e the ends of these edges, a round moves v, and its limit is,
///
///     v' = v (n - 2)/n + Σ e/n² + Σ f/n²,     v∞ = (n² v + 4 Σ e + Σ d)/(n (n + 5)),
///
/// d the corners across the quads. Along sharp edges with neighbours a and b the rule is that of cubic
/// splines, v' = (a + 6v + b)/8 and v∞ = (a + 4v + b)/6; where not two of them meet, and at a corner of one
/// face only, v stays. A regular part is a bicubic B-spline. Faces come in the order of the cage's: 4^k
/// for each quad after k rounds. Second-order faces count by their corners. Throws InputError: a round below 1,
/// more than 4,000,000 quads, a crease that is no edge. O(quads). Source: Catmull and Clark 1978; limits: Halstead,
/// Kass and DeRose 1993.
ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options = {});

}  // namespace batten
