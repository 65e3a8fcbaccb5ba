// Measurements of a STEP file.
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

/// Measurements of the fitted face of one model face. Lengths are in model units. check_step() sets
/// only `region` and `deviation` (sampled at a few points of the face, with closest points of the
/// surface).
struct StepPatch {
  std::string region;
  /// Largest distance between the face in the file and the surface, inside the trim. It is sampled
  /// at points of the face, points of the surface, and along the boundary. Points are compared at
  /// equal (u, v), so this is an upper bound of the distance between closest points.
  double deviation = 0;
  bool reached = false;  ///< true if deviation ≤ tolerance
  /// Largest angle at joins that miss the limit and that a better face could reduce.
  double join_deg = 0;
  /// Largest distance between the face and an edge or vertex of the file. Edges whose curve belongs
  /// to no other model face lie on the face within 1e-7 mm, the distance at which readers treat
  /// points as coincident. All others are exactly the curves; they deviate by line_gap and by the
  /// error of the fit.
  double edge_gap = 0;
  /// Largest distance between the boundary curves and the model face's own surface.
  double line_gap = 0;
  /// Largest distance of the file's edges from curves shared by model faces (rounding), and from
  /// the model face's own boundary elsewhere (error of the fit).
  double edge_deviation = 0;
  int poles_u = 0, poles_v = 0;  ///< for a B-spline; 0 for an analytic face
  /// "plane", "cylinder", "sphere", "cone" or "torus" for an analytic face; else "B-spline".
  std::string surface = "B-spline";
};

/// A smooth join: a curve along which the surfaces of two model faces are tangent, measured between
/// their faces in the file.
struct StepJoin {
  std::string line;
  std::array<std::string, 2> regions;
  double surface_deg = 0;  ///< largest angle between the surfaces where they are tangent
  double angle_deg = 0;    ///< largest angle between the faces there
  /// True if the angle is at most StepFaceOptions::join_deg at all points where the angle between
  /// the surfaces is. Where the surfaces meet by more than that, faces close to both cannot do
  /// better.
  bool reached = false;
};

/// Measurements of a STEP file that OpenCASCADE reads back from disk. (While reading, it silently
/// repairs orientations of curves and loops.) Lengths are in model units.
struct StepReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  int shells = 0, solids = 0;
  int closed_shells = 0;  ///< shells without free edges
  int faces = 0;
  int edges = 0;       ///< edges of faces
  int curves = 0;      ///< edges without a face: curves written in addition to the faces
  int free_edges = 0;  ///< edges with one face only; seams do not count
  /// True if OpenCASCADE's checks pass (BRepCheck_Analyzer). They also pass if there is a gap,
  /// because the reader widens the tolerance of the edge to cover it. max_gap shows the gap.
  bool valid = false;
  double size = 0;  ///< diagonal of the bounding box of all edges
  double area = 0;
  /// Total volume of all solids, model units³; accurate to 1e-12 for exact faces.
  double volume = 0;
  /// Largest distance between an edge and its adjacent faces (9 points per edge, more on fitted
  /// faces), and between a vertex and the ends of its edges. Divide it by `size` for a relative
  /// gap.
  double max_gap = 0;
  /// Largest angle between the outward normals of two faces of one model face along their common
  /// edge,
  /// 9 points per edge. If the model faces of the file are unknown, all faces count as one model
  /// face.
  double max_normal_jump_deg = 0;
  /// Largest distance of sample points of the faces from the model faces' surfaces (15 points per
  /// face; for fitted faces see StepPatch::deviation). Set only if model faces were given. In a
  /// report of write_step() it refers to the exact faces; `patches` has the fitted ones.
  std::optional<double> max_deviation;
  double max_tolerance = 0;  ///< largest tolerance of edges and vertices after reading
  /// Number of points at which one of these could not be measured: an edge without a pcurve on its
  /// face, or a singular point of a surface.
  int unmeasured = 0;
  /// Continuity across every edge of the file, in model units; set by the writers, and by
  /// check_step() if it is given model faces.
  std::optional<ContinuityReport> continuity;
  std::vector<std::string> warnings;

  // For fitted faces only:
  double tolerance = 0;  ///< requested tolerance
  bool reached = true;   ///< true if every face meets the tolerance and every join its angle
  double line_gap = 0, edge_deviation = 0;  ///< maxima over the faces
  std::vector<StepPatch> patches;           ///< fitted faces, in file order
  std::vector<StepJoin> joins;  ///< smooth joins with a fitted face on at least one side
  double max_join_deg = 0;      ///< largest `angle_deg` of the joins
};

// Errors of the writers of STEP files.

/// Thrown if the faces of these model faces are not read back from the file as they were written.
class UnwritableRegions : public Error {
 public:
  UnwritableRegions(const std::string& what, std::vector<const SkinnedRegion*> regions)
      : Error(what), regions_(std::move(regions)) {}
  const std::vector<const SkinnedRegion*>& regions() const { return regions_; }

 private:
  std::vector<const SkinnedRegion*> regions_;
};

}  // namespace batten
