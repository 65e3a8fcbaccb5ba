// What a report says about a network and the model made from it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Everything by name, as the user said it or may say it. Lengths in model units, angles in
/// degrees.
struct NetworkReport {
  /// Lines of one loop, in its order.
  using LoopNames = std::vector<std::string>;

  struct Region {
    std::string name;
    std::vector<LoopNames> loops;
    LoopNames inner;
    bool ring = false, asked = false;
    double cost = 0;
    bool skinned = false;
    int triangles = 0, dofs = 0;  ///< as all that follows but plain_area, of one that is skinned
    double size = 0;
    SkinQuality quality;
    double plain_area = 0;
    std::string why_not;
    std::vector<std::string> flaws, warnings;
  };
  struct Join {
    std::string line;
    std::vector<std::string> regions;
    std::string kind;  ///< "rim", "crease", "smooth", "branching"
    bool asked = false, one_domain = false;
    std::array<bool, 2> open{};
    double first_deg = 0, max_deg = 0, max_inside_deg = 0;
    std::string why;
  };
  struct Choice {
    std::string text;
    Vec3 where = Vec3::Zero();
    std::vector<std::string> lines;
    std::vector<LoopNames> chosen;
    std::vector<std::vector<LoopNames>> alternatives;
    std::vector<double> margins;
  };
  struct Shell {
    std::vector<std::string> regions;
    bool closed = false, orientable = true;
    double area = 0, volume = 0;
  };
  struct Flaw {
    std::string kind;  ///< "jacobian", "fold", "crossing", "area"
    std::vector<std::string> regions;
    Vec3 where = Vec3::Zero();
    double value = 0;
    std::string text;
  };

  int lines = 0, arcs = 0, nodes = 0;
  double size = 0, tolerance = 0, fit_tolerance = 0, join_tolerance_deg = 0;
  bool optimal = true;
  std::vector<NetworkFinding> findings;
  std::vector<Region> regions;
  std::vector<Join> joins;
  std::vector<Choice> choices;
  std::vector<Shell> shells;
  std::vector<Flaw> flaws;
  std::vector<std::string> rims, bare;  ///< lines with one region, with none
};

/// fit_tolerance is that of lines, join_tolerance_deg what smooth joins should keep.
NetworkReport network_report(const CharacterLineNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg);

/// "ends joined", "near miss": a kind of finding in words.
const char* word(NetworkFinding::Kind kind);

}  // namespace batten
