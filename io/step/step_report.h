// The numbers measured on a STEP file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>
#include <utility>

#include "batten/io/cad/continuity_report.h"
#include "batten/core/errors.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// The fitted face of one region. Lengths are in model units. check_step() sets region and
/// deviation only (a few points of the face, against the nearest points of the surface).
struct StepPatch {
  std::string region;
  /// Largest distance found between the face of the file and the surface, inside the trim: at
  /// points of the face, at points of the surface, and along the boundary. It is taken at equal
  /// (u, v), so the nearest points are never farther apart.
  double deviation = 0;
  bool reached = false;  ///< whether deviation ≤ tolerance
  double join_deg = 0;   ///< the largest angle of its missed joins that a better face could mend
  /// Largest distance between the face and an edge or vertex of the file. Edges whose line no other
  /// region has lie on the face within what readers take for one point (1e-7 mm). Others are the
  /// lines themselves; they are off by line_gap and the fit.
  double edge_gap = 0;
  /// Largest distance between the boundary curves and the surface of the region itself.
  double line_gap = 0;
  /// Distance of the file's edges from lines that regions have in common (rounding), and from the
  /// region's own rim elsewhere (the fit).
  double edge_deviation = 0;
  int poles_u = 0, poles_v = 0;  ///< of a B-spline; 0 of an analytic face
  /// "plane", "cylinder", "sphere", "cone", "torus" of an analytic face; "B-spline".
  std::string surface = "B-spline";
};

/// A line along which the surfaces of two regions are tangent, and their faces in the file.
struct StepJoin {
  std::string line;
  std::array<std::string, 2> regions;
  double surface_deg = 0;  ///< largest angle between the surfaces, where they are tangent
  double angle_deg = 0;    ///< largest angle between the faces there
  /// Whether the angle is at most StepFaceOptions::join_deg wherever that between the surfaces is: where
  /// these meet by more than that, faces near to both can do no better.
  bool reached = false;
};

/// What is in a STEP file, measured on the file that OpenCASCADE reads back from disk (it silently
/// repairs directions of curves and loops while it reads). Lengths are in model units.
struct StepReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  int shells = 0, solids = 0;
  int closed_shells = 0;  ///< shells without a free edge
  int faces = 0;
  int edges = 0;       ///< of faces
  int curves = 0;      ///< edges without a face: lines that the file holds beside the faces
  int free_edges = 0;  ///< edges with one face only: the rims, but not seams
  /// Whether OpenCASCADE's checks passed (BRepCheck_Analyzer). They also pass at a gap, because
  /// reading widens the edge's tolerance over it; max_gap shows it.
  bool valid = false;
  double size = 0;  ///< diagonal of the box around all edges
  double area = 0;
  double volume = 0;  ///< volume of all solids, model units³; of exact faces to 1e-12
  /// Largest distance between an edge and the faces beside it (9 points an edge, more on fitted
  /// faces), and between a vertex and the ends of its edges. Over `size` it is a relative gap.
  double max_gap = 0;
  /// Largest angle between the outward normals of two faces of one region along their edge, 9
  /// points an edge. When the file's regions are not known, all its faces count as one region.
  double max_normal_jump_deg = 0;
  /// Largest distance of points of the faces (15 each; StepPatch::deviation) from the regions'
  /// surfaces; set only when these were given. In a report of write_step() it is that of the exact
  /// faces; `patches` has the fitted ones.
  std::optional<double> max_deviation;
  double max_tolerance = 0;  ///< largest tolerance of edges and vertices after reading
  /// Count of places where one of these could not be measured: an edge without a parameter line on
  /// its face, a point where the surface is singular.
  int unmeasured = 0;
  /// How faces meet along every edge of the file, in model units; set by the writers only.
  std::optional<ContinuityReport> continuity;
  std::vector<std::string> warnings;

  // For fitted faces only:
  double tolerance = 0;  ///< the tolerance asked for
  bool reached = true;   ///< whether every face reaches it, and every join its angle
  double line_gap = 0, edge_deviation = 0;  ///< the largest of the faces
  std::vector<StepPatch> patches;           ///< each fitted face, in the order of the file
  std::vector<StepJoin> joins;  ///< smooth joins that have a fitted face on one side or on both
  double max_join_deg = 0;      ///< the largest angle_deg of these
};


// What the writers of STEP files say of regions that they cannot write.

/// Regions whose faces no reader would find in the file as they are.
class UnwritableRegions : public Error {
 public:
  UnwritableRegions(const std::string& what, std::vector<const SkinnedRegion*> regions)
      : Error(what), regions_(std::move(regions)) {}
  const std::vector<const SkinnedRegion*>& regions() const { return regions_; }

 private:
  std::vector<const SkinnedRegion*> regions_;
};

}  // namespace batten
