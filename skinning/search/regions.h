// The loops of a network that bound surfaces, as data.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/network/network.h"
#include "batten/skinning/region/skin_options.h"

namespace batten {

/// One arc as a loop runs along it.
struct ArcUse {
  int arc = 0;
  bool reversed = false;
  bool operator==(const ArcUse&) const = default;
};
using ArcLoop = std::vector<ArcUse>;

/// How the surface of one region is to be made, where the user says so.
struct RegionSkin {
  SkinOptions::Domain domain = SkinOptions::Domain::Auto;
  double edge_length = 0;  ///< model units; 0: that of the model
  bool convex = false;     ///< SkinOptions::convex
};

/// One surface to be: where it ends, and what lies on it.
struct NetworkRegion {
  std::string name;  ///< the user's, or "region 1", "region 2", …
  /// The outline, then holes; of a ring its two rims. An arc may occur twice in a loop (a slit that
  /// the surface lies on both sides of).
  std::vector<ArcLoop> loops;
  bool ring = false;
  std::vector<int> inner;  ///< arcs that lie on the surface, inside
  bool asked = false;      ///< the user's word
  double cost = 0;         ///< cost of the loop; 0 for one that is asked for
  RegionSkin skin = {};
};

/// What the user says about one surface. Names are those of arcs, or of lines (all their arcs).
struct RegionWord {
  enum class Kind {
    Surface,  ///< a surface with these loops
    Nothing   ///< no surface in this loop (loops[0])
  };
  Kind kind = Kind::Surface;
  std::string name;                             ///< name of the region
  std::vector<std::vector<std::string>> loops;  ///< lines of each loop, in any order and direction
  bool ring = false;                            ///< loops are the two rims of a ring
  std::vector<std::string> inner;
  RegionSkin skin = {};
  std::string where;  ///< for messages: "scene.toml:8:1: "
};

/// How regions are found.
struct RegionOptions {
  std::vector<RegionWord> words;
  /// At most so many regions meet at an arc; more make branching surfaces, which are not oriented.
  int most_at_line = 2;
};

/// A choice that could nearly as well have been another one.
struct RegionChoice {
  Vec3 where = Vec3::Zero();
  std::vector<std::string> arcs;  ///< names of the arcs that it is about
  std::string text;               ///< sentences for the user, with what to say to have it otherwise
  std::vector<ArcLoop> chosen;    ///< loops with a surface
  std::vector<std::vector<ArcLoop>> alternatives;  ///< the same, best first
  /// Whether the loops of each way bound one surface (a ring, a hole), not one each.
  bool one_surface = false;
  std::vector<double> margins;  ///< of each: what it costs more, relative
};

/// All that was found.
struct FoundRegions {
  std::vector<NetworkRegion> regions;  ///< asked for, then found, these in canonical order
  std::vector<RegionChoice> choices;
  std::vector<int> rims;  ///< arcs with one region
  std::vector<int> bare;  ///< arcs with none
  bool optimal = true;    ///< the choice is proved best; false: the search was cut short
};

}  // namespace batten
