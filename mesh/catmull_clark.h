// Catmull-Clark subdivision of polygon cages, and points of the limit surface.
#pragma once

#include <limits>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// From this sharpness on an edge or a node is sharp for good.
constexpr double kInfinitelySharp = 10;

/// An edge of a cage that is sharp for so many rounds; none is smooth, kInfinitelySharp stays
/// sharp.
struct CageCrease {
  int a = 0, b = 0;  ///< its nodes
  double sharpness = kInfinitelySharp;
};
/// A node that stays where it is for so many rounds.
struct CageCorner {
  int node = 0;
  double sharpness = kInfinitelySharp;
};
/// What of a cage is sharp beside its rims. Where several say something of one edge or node, the
/// last one counts.
struct CageTags {
  std::vector<CageCrease> creases;
  std::vector<CageCorner> corners;
};

struct CatmullClarkOptions {
  int levels = 4;  ///< each makes four quads of a quad, n of a polygon with n corners
  CageTags tags = {};
};

/// The limit surface of a cage as quads whose nodes lie on it. With f the means of the faces around a node v
/// of n edges and e the ends of these edges, a round moves v, and its limit is,
///
///     v' = v (n - 2)/n + Σ e/n² + Σ f/n²,     v∞ = (n² v + 4 Σ e + Σ d)/(n (n + 5)),
///
/// d the corners across the quads. A regular part is a bicubic B-spline. Edges with other than two
/// faces (rims, and where three faces meet) are sharp for good, and a node of one face only is a
/// corner. Where edges are sharp
///
///     two meet in v         v' = (a + 6v + b)/8, v∞ = (a + 4v + b)/6 with a, b their far ends
///     three and more, or v is a corner        v' = v
///     one                   v' as if there were none; v∞ is taken after 60 further rounds around v
///
/// A sharpness s is s - 1 in the next round. Of 0 < s < 1 the new node of an edge is s times its
/// middle plus 1 - s times the smooth one; and where a round ends the sharpness of edges at v, or
/// of v, so that another rule follows, v' is the mean of both rules by the mean sharpness that
/// ends. So the limit is exact for any number of rounds: where some sharpness is left, v goes on
/// with its own faces until there is none.
///
/// Faces come in the order of the cage's: 4^k for each quad after k rounds. Second-order faces
/// count by their corners. Throws InputError: a round below 1, more than 4,000,000 quads, a crease
/// that is no edge, a corner that is no node, a sharpness below 0. O(quads). Source: Catmull and
/// Clark 1978; limits: Halstead, Kass and DeRose 1993; sharpness: DeRose, Kass and Truong 1998.
ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options = {});

}  // namespace batten
