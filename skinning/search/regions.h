// Data types of the region search: edge loops, regions, user specifications and results.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// An edge of the network together with its direction of travel in a loop.
struct OrientedEdge {
  int edge = 0;
  bool reversed = false;
  bool operator==(const OrientedEdge&) const = default;
};
/// A closed loop: each edge starts at the node at which the previous one ends.
using EdgeLoop = std::vector<OrientedEdge>;

/// User options for the surface of one region.
struct RegionOptions {
  SkinOptions::Domain domain = SkinOptions::Domain::Auto;
  double edge_length = 0;  ///< target edge length of the mesh, model units; 0: that of the model
  bool convex = false;     ///< SkinOptions::convex
};

/// A region of the network that gets one surface: its boundary loops and the edges inside it.
struct NetworkRegion {
  std::string name;  ///< name given by the user, or "face 1", "face 2", …
  /// Boundary loops: the outer boundary, then holes; for an annulus its two boundary circles. An
  /// edge may occur twice in a loop (a slit with the surface on both sides).
  std::vector<EdgeLoop> loops;
  /// The region is annular (a tube or ring); `loops` holds its two boundary circles.
  bool annulus = false;
  std::vector<int> inner;  ///< edges in the interior of the surface, ascending
  bool requested = false;  ///< specified by the user, not found by the search
  double cost = 0;         ///< LoopCandidate::cost of the loop; 0 for a requested region
  RegionOptions skin = {};
};

/// User specification of one surface. Names are those of edges, or of input curves (all their
/// edges).
struct RegionSpec {
  enum class Kind {
    Surface,   ///< make a surface with these loops
    NoSurface  ///< make no surface in these loops
  };
  Kind kind = Kind::Surface;
  std::string name;  ///< name of the region
  /// Curve names of each loop, in any order and direction.
  std::vector<std::vector<std::string>> loops;
  bool annulus = false;  ///< the two loops are the boundary circles of an annulus
  std::vector<std::string> inner;
  RegionOptions skin = {};
  std::string where;  ///< prefix for messages, such as "scene.toml:8:1: "
};

/// Options of the region search.
struct RegionSearchOptions {
  /// Surfaces that the user requests or excludes; they take precedence over the search.
  std::vector<RegionSpec> specs;
  /// Largest number of regions that share an edge, at least 1. More than 2 allows non-manifold
  /// surfaces, which cannot be oriented.
  int max_faces_per_edge = 2;
};

/// A decision of the search to which there are alternatives of almost equal cost.
struct AmbiguousRegion {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> edges;  ///< names of the edges concerned
  std::string text;  ///< sentences for the user, including how to select the alternative
  std::vector<EdgeLoop> chosen;                     ///< loops that got a surface
  std::vector<std::vector<EdgeLoop>> alternatives;  ///< sets of loops to take instead, best first
  /// True if the loops of each set bound one surface (an annulus, or a face with a hole); false:
  /// each loop bounds a surface of its own.
  bool one_surface = false;
  std::vector<double> margins;  ///< relative extra cost of each alternative, 0.15 = 15 %
};

/// Result of find_regions().
struct FoundRegions {
  /// Requested regions first, then found ones in canonical order.
  std::vector<NetworkRegion> regions;
  std::vector<AmbiguousRegion> ambiguous_regions;
  std::vector<int> free_edges;    ///< edges with one region (free boundary)
  std::vector<int> unused_edges;  ///< edges without a region
  bool optimal = true;  ///< true: proved to be the best choice; false: the search was cut short
};

}  // namespace batten
