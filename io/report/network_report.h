// The part of report.json about a curve network and the model made from it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// A curve network, its regions and its model. Edges and regions are identified by the names that
/// scenes use. Lengths are in model units, angles in degrees.
struct NetworkReport {
  /// Names of the edges of one loop, in order.
  using LoopNames = std::vector<std::string>;

  /// A region of the network and its surface.
  struct Region {
    std::string name;
    std::vector<LoopNames> loops;
    LoopNames inner;
    bool annulus = false, requested = false;
    double cost = 0;
    bool skinned = false;
    int triangles = 0, dofs = 0;  ///< these, size, domain and quality are set if skinned is true
    double size = 0;
    std::string domain;  ///< "polygon", "projected", "developable", "annulus"
    /// Recognised primitive (FittedPrimitive): "plane", "cylinder", …; empty: none.
    std::string shape;
    double radius = 0, major_radius = 0;  ///< its radii; 0: it has none
    double half_angle_deg = 0;            ///< half apex angle of a cone, degrees
    /// Largest distance of the surface from that primitive; model units.
    double shape_deviation = 0;
    SkinQuality quality;
    double filling_area = 0;       ///< area of the hole-filling triangulation of its loops; 0: none
    std::string rejection_reason;  ///< why it has no surface; empty: it has one
    std::vector<std::string> defects, warnings;
  };
  /// A shared or free edge of the model.
  struct Join {
    std::string line;
    std::vector<std::string> regions;
    std::string kind;  ///< "free edge", "G0", "smooth", "non-manifold"
    bool requested = false, one_domain = false;
    std::array<bool, 2> open{};  ///< this and the following members: see ModelJoin
    double initial_deg = 0, max_deg = 0, max_inside_deg = 0;
    double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
    bool curvature = false;
    std::string why;
  };
  /// An ambiguous decision of the region search; see AmbiguousRegion.
  struct Choice {
    std::string text;
    Vec3 where = Vec3::Zero();
    std::vector<std::string> lines;
    std::vector<LoopNames> chosen;
    std::vector<std::vector<LoopNames>> alternatives;
    std::vector<double> margins;
  };
  /// A connected set of regions.
  struct Shell {
    std::vector<std::string> regions;
    bool closed = false, orientable = true;
    double area = 0, volume = 0;
    std::string normals;  ///< NormalSide::text(); empty: not orientable
  };
  int lines = 0, edges = 0, nodes = 0;
  /// Fraction of curve ends that would meet within the default tolerance (see CurveNetwork).
  double joined_fraction = 1;
  double size = 0, tolerance = 0, fit_tolerance = 0, join_tolerance_deg = 0;
  bool optimal = true;
  std::vector<NetworkDiagnostic> diagnostics;
  std::vector<Region> regions;
  std::vector<Join> joins;
  std::vector<Choice> ambiguous_regions;
  std::vector<Shell> shells;
  std::vector<std::string> free_edges, unused_edges;  ///< edges with one region, edges with none
};

/// Reports a model, its network and the regions found. `fit_tolerance`: tolerance of the fitted
/// curves, model units. `join_tolerance_deg`: largest permitted angle of smooth joins, degrees.
NetworkReport network_report(const CurveNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg);

/// A SurfaceDefect with the names of its regions.
struct DefectReport {
  std::string kind;  ///< "jacobian", "fold", "self-intersection", "area"
  std::vector<std::string> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;
  std::string text;
};
/// All surface defects of a model.
std::vector<DefectReport> defect_reports(const SurfaceModel& model);

/// The kind of a diagnostic as text: "ends joined", "near miss".
const char* word(NetworkDiagnostic::Kind kind);

}  // namespace batten
