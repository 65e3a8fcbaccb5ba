// SPDX-License-Identifier: MPL-2.0
// Data types of the face search: edge loops, faces, user specifications and results.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// An edge of a curve network, and the direction in which a loop runs along this edge.
struct OrientedEdge {
  int edge = 0;           ///< index into CurveNetwork::edges()
  bool reversed = false;  ///< true: the loop runs from the end of the edge to its start
  bool operator==(const OrientedEdge&) const = default;
};
/// A closed loop: each edge starts at the node at which the previous one ends.
using EdgeLoop = std::vector<OrientedEdge>;

/// User options for the surface of one face.
struct RegionOptions {
  SkinOptions::Domain domain = SkinOptions::Domain::Auto;
  /// Target length of mesh edges in this face, model units; 0: the target length of the model.
  double edge_length = 0;
  bool convex = false;  ///< true: every corner of the face is convex
};

/// A face found in the curve network or requested by the user: boundary loops and inner edges.
struct NetworkRegion {
  std::string name;  ///< name given by the user, or "face 1", "face 2", …
  /// Boundary loops: first the outer boundary, then the holes; for an annulus, the two boundary
  /// circles. An edge may occur twice in a loop (a slit with the surface on both sides).
  std::vector<EdgeLoop> loops;
  /// True: the face is annular (a tube or ring), and `loops` contains the two boundary circles.
  bool annulus = false;
  std::vector<int> inner;  ///< indices of the edges inside the face, ascending
  bool requested = false;  ///< true: specified by the user; false: found by the search
  double cost = 0;         ///< search cost of the boundary loop; 0 for a requested face
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
  std::string name;  ///< name that the face will have
  /// Names of the curves or edges of each loop, in any order and direction.
  std::vector<std::vector<std::string>> loops;
  bool annulus = false;  ///< true: `loops` are the two boundary circles of an annulus
  std::vector<std::string> inner;
  RegionOptions skin = {};
  std::string where;  ///< prefix of error messages, such as "scene.toml:8:1: "
};

/// Options of the face search.
struct RegionSearchOptions {
  /// Faces that the user requests or excludes; these specifications take precedence over the
  /// search.
  std::vector<RegionSpec> specs;
  /// True: `specs` are the only faces, and no others are searched for.
  bool only_specs = false;
  /// Largest number of faces that may share an edge, at least 1. Values above 2 allow non-manifold
  /// surfaces, which cannot be oriented.
  int max_faces_per_edge = 2;
};

/// A decision of the face search to which there are alternatives of almost equal cost.
struct AmbiguousRegion {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> edges;  ///< names of the edges of all loops concerned
  std::string text;  ///< sentences for the user, including how to select the alternative
  std::vector<EdgeLoop> chosen;                     ///< boundary loops that became faces
  std::vector<std::vector<EdgeLoop>> alternatives;  ///< loops to use instead, best first
  /// True if all loops of an alternative bound one face (an annulus, or a face with a hole); false
  /// if each loop bounds a separate face.
  bool one_surface = false;
  std::vector<double> margins;  ///< relative extra cost of each alternative; 0.15: 15 %
};

/// Result of find_regions().
struct FoundRegions {
  /// Faces of the model: first those that the user requested, then those found by the search, in an
  /// order that depends only on the geometry of the network.
  std::vector<NetworkRegion> regions;
  std::vector<AmbiguousRegion> ambiguous_regions;
  std::vector<int> free_edges;    ///< indices of the edges of exactly one face
  std::vector<int> unused_edges;  ///< indices of the edges that belong to no face
  bool optimal = true;            ///< false: the search was cut short; true: optimum proved
};

}  // namespace batten
