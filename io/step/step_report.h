// SPDX-License-Identifier: MPL-2.0
// Measurements of a STEP file, and of the continuity between its faces.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Measurements of a face of a STEP file that was fitted to one face of the model. Lengths are in
/// model units. check_step() sets only the members `region` and `deviation`; it measures the
/// distances from a few points of the face to the closest points of the surface.
struct StepPatch {
  std::string region;
  /// Largest distance between the face in the file and the surface, inside the boundary. It is
  /// measured at sample points of the face, of the surface, and of the boundary, between points
  /// with equal (u, v). It is therefore an upper bound of the distance between closest points.
  double deviation = 0;
  bool reached = false;  ///< true if `deviation` is at most the tolerance of the fit
  /// Largest angle, degrees, between this face and its neighbours at smooth edges. Only angles
  /// above the permitted one that a better fit could reduce are counted.
  double join_deg = 0;
  /// Largest distance between the face and an edge or vertex of the file. Edges that belong to a
  /// single model face lie on the face within 1e-7 mm; readers treat points closer than that as
  /// coincident. Edges shared by model faces are exactly the model curves; the distance of such
  /// edges is due to `line_gap` and to the error of the fit.
  double edge_gap = 0;
  /// Largest distance between the boundary curves of the model face and its surface.
  double line_gap = 0;
  /// Largest distance of the edges in the file from the boundary of the model face. At edges shared
  /// by model faces this distance is due to rounding, at other edges to the error of the fit.
  double edge_deviation = 0;
  /// Number of poles of a B-spline face in u and v; 0 for an analytic face.
  int poles_u = 0, poles_v = 0;
  /// Type of an analytic face ("plane", "cylinder", "sphere", "cone", "torus"), or "B-spline".
  std::string surface = "B-spline";
};

/// A smooth edge: a curve along which the surfaces of two model faces are tangent. `angle_deg` is
/// measured between the corresponding faces of the STEP file.
struct StepJoin {
  std::string line;
  std::array<std::string, 2> regions;
  /// Largest angle, degrees, between the surfaces of the two model faces, on the part of the curve
  /// on which the surfaces are tangent.
  double surface_deg = 0;
  double angle_deg = 0;  ///< largest angle between the faces of the file on the tangent part
  /// True if the angle between the faces of the file is at most StepFaceOptions::join_deg at all
  /// points at which the angle between the surfaces of the model faces is at most join_deg. (At
  /// other points, faces that are close to the two surfaces cannot be tangent.)
  bool reached = false;
};

/// Measurements of a STEP file, after OpenCASCADE has read it back from disk. (When reading,
/// OpenCASCADE silently repairs orientations of curves and loops.) Lengths are in model units.
struct StepReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  int shells = 0, solids = 0;
  int closed_shells = 0;  ///< number of shells without free edges
  int faces = 0;
  int edges = 0;       ///< number of edges of faces
  int curves = 0;      ///< number of edges without a face (additional curves)
  int free_edges = 0;  ///< number of edges with one face; seams do not count
  /// True if the file passes the checks of OpenCASCADE (BRepCheck_Analyzer). They miss gaps,
  /// because the reader increases the tolerance of an edge until it covers the gap; see max_gap.
  bool valid = false;
  double size = 0;  ///< diagonal of the bounding box of all edges of the file
  double area = 0;
  /// Total volume of all solids, in cubed model units; relative error 1e-12 for exact faces.
  double volume = 0;
  /// Largest distance between an edge and its adjacent faces (9 points per edge, more on fitted
  /// faces), and between a vertex and the ends of its edges.
  double max_gap = 0;
  /// Largest angle between the outward normals of two adjacent faces of the same model face,
  /// degrees, at 9 points per edge. If the model faces are unknown, all faces of the file count as
  /// one model face.
  double max_normal_jump_deg = 0;
  /// Largest distance of the faces of the file from the surfaces of the model faces, at 15 sample
  /// points per face (for fitted faces see StepPatch::deviation). Set only if model faces were
  /// given. In a report of write_step() this distance covers the exact faces only; `patches`
  /// contains the fitted faces.
  std::optional<double> max_deviation;
  double max_tolerance = 0;  ///< largest tolerance that edges and vertices have after reading
  /// Number of points at which a measurement failed, because an edge has no pcurve on its face or
  /// the surface is singular.
  int unmeasured = 0;
  /// Continuity across all edges of the file, in model units. Set by write_step() and
  /// write_step_faces(), and by check_step() if model faces are given.
  std::optional<ContinuityReport> continuity;
  std::vector<std::string> warnings;

  // Set for fitted faces only:
  double tolerance = 0;  ///< requested tolerance of the fitted faces, model units
  /// True if every fitted face meets `tolerance` and every smooth edge the permitted angle.
  bool reached = true;
  double line_gap = 0, edge_deviation = 0;  ///< maxima over `patches`, model units
  std::vector<StepPatch> patches;           ///< measurements of the fitted faces, in file order
  std::vector<StepJoin> joins;              ///< smooth edges that bound at least one fitted face
  double max_join_deg = 0;                  ///< largest StepJoin::angle_deg, degrees
};

// Exception of the functions that write STEP files.

/// Thrown if the faces that are read back from a STEP file differ from the written faces.
/// regions(): the model faces whose faces differ.
class UnwritableRegions : public Error {
 public:
  UnwritableRegions(const std::string& what, std::vector<const SkinnedRegion*> regions)
      : Error(what), regions_(std::move(regions)) {}
  const std::vector<const SkinnedRegion*>& regions() const { return regions_; }

 private:
  std::vector<const SkinnedRegion*> regions_;
};

}  // namespace batten
