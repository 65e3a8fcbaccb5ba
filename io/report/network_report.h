// SPDX-License-Identifier: MPL-2.0
// Contents of report.json about a curve network and the model that is made from it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Results for a curve network and the model made from it. Edges and faces have the names that are
/// used in scenes. Lengths are in model units, angles in degrees.
struct NetworkReport {
  /// Names of the edges of one boundary loop of a face, in order along the loop.
  using LoopNames = std::vector<std::string>;

  /// A face of the model and its surface.
  struct Region {
    std::string name;
    std::vector<LoopNames> loops;
    LoopNames inner;
    bool annulus = false, requested = false;
    double cost = 0;
    bool skinned = false;
    /// Numbers of triangles and dofs of the surface mesh. These numbers, size, domain and quality
    /// are set only if `skinned` is true.
    int triangles = 0, dofs = 0;
    double size = 0;
    /// Type of parameter domain: "polygon", "projected", "developable", "annulus".
    std::string domain;
    /// Primitive that fits the face (FittedPrimitive): "plane", "cylinder", …; empty: none fits.
    std::string shape;
    /// Radii of the recognised primitive, model units; 0: the primitive has no such radius.
    double radius = 0, major_radius = 0;
    double half_angle_deg = 0;  ///< half of the apex angle of a recognised cone, degrees
    /// Largest distance of the surface from the recognised primitive; model units.
    double shape_deviation = 0;
    SkinQuality quality;
    /// Area of the hole-filling triangulation of the boundary loops of the face; 0: there is none.
    double filling_area = 0;
    std::string rejection_reason;  ///< reason why the face has no surface; empty: it has one
    std::vector<std::string> defects, warnings;
  };
  /// A shared or free edge of the model.
  struct Join {
    std::string line;
    std::vector<std::string> regions;
    std::string kind;  ///< "free edge", "G0" (crease), "smooth" (G1), "non-manifold"
    bool requested = false, one_domain = false;
    std::array<bool, 2> open{};  ///< start, end: true if a smooth edge is a crease there
    double initial_deg = 0, max_deg = 0, max_inside_deg = 0;
    double max_gap = 0, median_curvature_jump = 0, max_curvature_jump = 0;
    bool curvature = false;
    std::string why;
    std::vector<std::string> neighbours = {};  ///< given surfaces at the edge
    double mean_deg = 0;
  };
  /// An ambiguous decision of the search for faces, with its alternatives; see AmbiguousRegion.
  struct Choice {
    std::string text;
    Vec3 where = Vec3::Zero();
    std::vector<std::string> lines;
    std::vector<LoopNames> chosen;
    std::vector<std::vector<LoopNames>> alternatives;
    std::vector<double> margins;
  };
  /// A shell of the model: a connected set of faces.
  struct Shell {
    std::vector<std::string> regions;
    bool closed = false, orientable = true;
    double area = 0, volume = 0;
    std::string normals;  ///< side of the normals (NormalSide::text()); empty: not orientable
  };
  int lines = 0, edges = 0, nodes = 0;
  std::vector<std::string> added_curves;  ///< names of the curves among `lines` that a loft adds
  /// Fraction of the curve ends that meet other curves within the default gap tolerance.
  double joined_fraction = 1;
  double size = 0, tolerance = 0, fit_tolerance = 0, join_tolerance_deg = 0;
  bool optimal = true;
  std::vector<NetworkDiagnostic> diagnostics;
  std::vector<Region> regions;
  std::vector<Join> joins;
  std::vector<Choice> ambiguous_regions;
  std::vector<Shell> shells;
  /// Names of edges that bound one face, and of edges that bound no face.
  std::vector<std::string> free_edges, unused_edges;
};

/// Creates the report of a model, of the curve network and of the faces found in the network.
/// `fit_tolerance`: tolerance of the fitted curves, model units. `join_tolerance_deg`: largest
/// permitted angle between faces at smooth edges, degrees.
NetworkReport network_report(const CurveNetwork& network, const FoundRegions& found,
                             const SurfaceModel& model, double fit_tolerance,
                             double join_tolerance_deg);

/// A defect of a finished surface (SurfaceDefect), with the names of the faces concerned.
struct DefectReport {
  std::string kind;  ///< type of defect: "jacobian", "fold", "self-intersection", "area"
  std::vector<std::string> regions;
  Vec3 where = Vec3::Zero();
  double value = 0;
  std::string text;
};
/// Lists all surface defects of a model.
std::vector<DefectReport> defect_reports(const SurfaceModel& model);

/// The kind of a diagnostic as text, such as "ends joined" or "near miss".
const char* to_text(NetworkDiagnostic::Kind kind);

}  // namespace batten
