// The part of a report about a network and the model made from it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// A network, its regions and its model. Arcs and regions are given by their names, which scenes
/// use, too. Lengths are in model units, angles in degrees.
struct NetworkReport {
  /// Names of the arcs of one loop, in its order.
  using LoopNames = std::vector<std::string>;

  struct Region {
    std::string name;
    std::vector<LoopNames> loops;
    LoopNames inner;
    bool annulus = false, requested = false;
    double cost = 0;
    bool skinned = false;
    int triangles = 0, dofs = 0;  ///< these, size, domain and quality are set when it is skinned
    double size = 0;
    std::string domain;  ///< "polygon", "plane", "sheet", "ring"
    std::string
        shape;  ///< "plane", "cylinder", … as measured (FittedPrimitive), or "": none of them
    double radius = 0, major_radius = 0;  ///< of that; 0: it has none
    double half_angle_deg = 0;            ///< of a cone
    double shape_deviation = 0;  ///< largest distance of the surface from that; model units
    SkinQuality quality;
    double filling_area = 0;       ///< area of the plain filling of its loops; 0 without one
    std::string rejection_reason;  ///< why it is not skinned, or ""
    std::vector<std::string> defects, warnings;
  };
  struct Join {
    std::string line;
    std::vector<std::string> regions;
    std::string kind;  ///< "rim", "crease", "smooth", "branching"
    bool requested = false, one_domain = false;
    std::array<bool, 2> open{};  ///< these and what follows: as in ModelJoin
    double initial_deg = 0, max_deg = 0, max_inside_deg = 0;
    double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
    bool curvature = false;
    std::string why;
  };
  /// A choice that the search made, as in AmbiguousRegion.
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
    std::string normals;  ///< NormalSide::text(); "" of one that is not orientable
  };
  int lines = 0, edges = 0, nodes = 0;
  /// Share of ends that would meet within the usual tolerance (CurveNetwork).
  double joined_fraction = 1;
  double size = 0, tolerance = 0, fit_tolerance = 0, join_tolerance_deg = 0;
  bool optimal = true;
  std::vector<NetworkDiagnostic> diagnostics;
  std::vector<Region> regions;
  std::vector<Join> joins;
  std::vector<Choice> ambiguous_regions;
  std::vector<Shell> shells;
  std::vector<std::string> free_edges, unused_edges;  ///< arcs with one region, arcs with none
};

/// The report of a model, its network and its found regions. `fit_tolerance`: of the lines' curves,
/// model units; `join_tolerance_deg`: largest angle that smooth joins should have.
NetworkReport network_report(const CurveNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg);

/// SurfaceDefect with the names of its regions.
struct DefectReport {
  std::string kind;  ///< "jacobian", "fold", "crossing", "area"
  std::vector<std::string> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;
  std::string text;
};
std::vector<DefectReport> defect_reports(const SurfaceModel& model);

/// A kind of finding in words: "ends joined", "near miss".
const char* word(NetworkDiagnostic::Kind kind);

}  // namespace batten
