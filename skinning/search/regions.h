// The loops of a network that bound surfaces, as data.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// One arc as a loop runs along it.
struct OrientedEdge {
  int edge = 0;
  bool reversed = false;
  bool operator==(const OrientedEdge&) const = default;
};
using EdgeLoop = std::vector<OrientedEdge>;

/// How the surface of one region is to be made, where the user says so.
struct RegionOptions {
  SkinOptions::Domain domain = SkinOptions::Domain::Auto;
  double edge_length = 0;  ///< model units; 0: that of the model
  bool convex = false;     ///< SkinOptions::convex
};

/// One surface to be: where it ends, and what lies on it.
struct NetworkRegion {
  std::string name;  ///< the user's, or "region 1", "region 2", …
  /// The outline, then holes; of a ring its two rims. An arc may occur twice in a loop (a slit that
  /// the surface lies on both sides of).
  std::vector<EdgeLoop> loops;
  bool annulus = false;
  std::vector<int> inner;  ///< arcs that lie on the surface, inside
  bool requested = false;  ///< the user's word
  double cost = 0;         ///< cost of the loop; 0 for one that is asked for
  RegionOptions skin = {};
};

/// What the user says about one surface. Names are those of arcs, or of lines (all their arcs).
struct RegionSpec {
  enum class Kind {
    Surface,   ///< a surface with these loops
    NoSurface  ///< no surface in this loop (loops[0])
  };
  Kind kind = Kind::Surface;
  std::string name;                             ///< name of the region
  std::vector<std::vector<std::string>> loops;  ///< lines of each loop, in any order and direction
  bool annulus = false;                         ///< loops are the two rims of a ring
  std::vector<std::string> inner;
  RegionOptions skin = {};
  std::string where;  ///< for messages: "scene.toml:8:1: "
};

/// How regions are found.
struct RegionSearchOptions {
  std::vector<RegionSpec> specs;
  /// At most so many regions meet at an arc; more make branching surfaces, which are not oriented.
  int max_faces_per_edge = 2;
};

/// A choice that could nearly as well have been another one.
struct AmbiguousRegion {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> edges;  ///< names of the arcs that it is about
  std::string text;              ///< sentences for the user, with what to say to have it otherwise
  std::vector<EdgeLoop> chosen;  ///< loops with a surface
  std::vector<std::vector<EdgeLoop>> alternatives;  ///< the same, best first
  /// Whether the loops of each way bound one surface (a ring, a hole), not one each.
  bool one_surface = false;
  std::vector<double> margins;  ///< of each: what it costs more, relative
};

/// All that was found.
struct FoundRegions {
  std::vector<NetworkRegion> regions;  ///< asked for, then found, these in canonical order
  std::vector<AmbiguousRegion> ambiguous_regions;
  std::vector<int> free_edges;    ///< arcs with one region
  std::vector<int> unused_edges;  ///< arcs with none
  bool optimal = true;            ///< the choice is proved best; false: the search was cut short
};

}  // namespace batten
