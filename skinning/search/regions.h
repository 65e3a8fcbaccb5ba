// Data types of the face search: edge loops, faces, user specifications and results.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// An edge of the network, and the direction in which a loop runs along this edge.
struct OrientedEdge {
  int edge = 0;
  bool reversed = false;
  bool operator==(const OrientedEdge&) const = default;
};
/// A closed loop: each edge starts at the node at which the previous one ends.
using EdgeLoop = std::vector<OrientedEdge>;

/// User options for the surface of one face.
struct RegionOptions {
  SkinOptions::Domain domain = SkinOptions::Domain::Auto;
  /// Target length of mesh edges in this face, model units; 0: that of the model.
  double edge_length = 0;
  bool convex = false;  ///< value of SkinOptions::convex for this face
};

/// A face found in the network or requested: its boundary loops and the edges inside.
struct NetworkRegion {
  std::string name;  ///< name given by the user, or "face 1", "face 2", …
  /// Boundary loops: first the outer boundary, then the holes; for an annulus, the two boundary
  /// circles. An edge may occur twice in a loop (a slit with the surface on both sides).
  std::vector<EdgeLoop> loops;
  /// True: the face is annular (a tube or ring), and `loops` contains the two boundary circles.
  bool annulus = false;
  std::vector<int> inner;  ///< indices of the edges inside the face, ascending
  bool requested = false;  ///< true: specified by the user; false: found by the search
  double cost = 0;         ///< LoopCandidate::cost of the boundary; 0 for a requested face
  RegionOptions skin = {};
};

/// User specification of a face to create or to exclude. Edges are given by their names; the name
/// of an input curve stands for all edges of that curve.
struct RegionSpec {
  enum class Kind {
    Surface,   ///< create a face bounded by `loops`
    NoSurface  ///< create no face bounded by any of `loops`
  };
  Kind kind = Kind::Surface;
  std::string name;  ///< name of the face
  /// Names of the curves or edges of each loop, in any order and direction.
  std::vector<std::vector<std::string>> loops;
  bool annulus = false;  ///< true: the two loops are the boundary circles of an annulus
  std::vector<std::string> inner;
  RegionOptions skin = {};
  std::string where;  ///< prefix of error messages, such as "scene.toml:8:1: "
};

/// Options of the face search.
struct RegionSearchOptions {
  /// Faces that the user requests or excludes; these specifications take precedence over the
  /// search.
  std::vector<RegionSpec> specs;
  /// Largest number of faces that may share an edge, at least 1. Values above 2 allow non-manifold
  /// surfaces, which cannot be oriented.
  int max_faces_per_edge = 2;
};

/// A decision of the search to which there are alternatives of almost equal cost.
struct AmbiguousRegion {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> edges;  ///< names of the edges concerned
  std::string text;  ///< sentences for the user, including how to select the alternative
  std::vector<EdgeLoop> chosen;                     ///< loops that became faces
  std::vector<std::vector<EdgeLoop>> alternatives;  ///< sets of loops to use instead, best first
  /// True if all loops of an alternative bound one face (an annulus, or a face with a hole); false
  /// if each loop bounds a separate face.
  bool one_surface = false;
  std::vector<double> margins;  ///< relative extra cost of each alternative (0.15: 15 %)
};

/// Result of find_regions().
struct FoundRegions {
  /// Faces of the model: first the requested faces, then those found by the search, in canonical
  /// order.
  std::vector<NetworkRegion> regions;
  std::vector<AmbiguousRegion> ambiguous_regions;
  std::vector<int> free_edges;    ///< edges of exactly one face (free boundary)
  std::vector<int> unused_edges;  ///< edges that belong to no face
  bool optimal = true;  ///< true: the selection is proved optimal; false: the search was cut short
};

}  // namespace batten
