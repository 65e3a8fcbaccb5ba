// Skinned regions as STEP files that people keep: one trimmed bicubic B-spline face for each
// region.
//
// The face is a least-squares fit of x(u, v) over the rectangle around the region's boundary loops,
// C2 and with as few poles as the tolerance asks for; the parameters are the region's own u, v, the
// outward normal is along x_u × x_v. Wires are the boundary loops, the outline first. Each stretch
// of the boundary between corners is one edge: in space the character line's curve as a C1 cubic
// B-spline, on the face its image c(t), over the same parameters. A ring closes in u and has a
// seam.
//
// Nothing that the report says is taken from the fit: the file is read back from disk by
// OpenCASCADE and sampled, and knots are refined until the file keeps the tolerance.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/skinning/region.h"

namespace batten {

struct StepFaceOptions {
  double tolerance = 0;          ///< of the surface, in model units; > 0
  std::string name = "surface";  ///< of the product
  std::string author = "";
  int most_poles = 400;            ///< in one direction, 16 or more
  int most_poles_in_all = 60'000;  ///< of one face, 256 or more: about 6 MB
};

/// One region's face. Lengths in model units.
struct StepFacePatch {
  std::string region;
  /// Largest distance found between the face of the file and the surface, inside the trim: points
  /// of the face from the surface, points of the surface from the face, and both along the rim. It
  /// is taken at equal (u, v), so the nearest points are never farther apart.
  double deviation = 0;
  bool reached = false;  ///< deviation ≤ tolerance
  /// Largest distance between an edge of the file and its face: line_gap and the fit. Vertices too.
  double edge_gap = 0;
  double line_gap =
      0;  ///< the same between boundary curves and the surface: it comes with the region
  double edge_deviation = 0;  ///< of the file's edges from the boundary curves: rounding
  int poles_u = 0, poles_v = 0;
};

struct StepFaceReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  double tolerance = 0;                                                  ///< asked for
  bool reached = false;                                                  ///< by every face
  double deviation = 0, edge_gap = 0, line_gap = 0, edge_deviation = 0;  ///< largest of the faces
  int faces = 0;
  int edges = 0;
  int free_edges = 0;  ///< with one face only; a seam is none
  /// OpenCASCADE's checks passed (BRepCheck_Analyzer), before writing and of the file read back.
  bool valid = false;
  double area = 0;  ///< of the faces inside their trims
  double seconds = 0;
  std::vector<StepFacePatch> patches;
  std::vector<std::string> warnings;
};

/// Writes one face for each region, each a shell of its own, and measures the file (AP214,
/// coordinates and unit as in write_step). When the tolerance cannot be reached, because of the
/// most poles or because finer knots no longer help (fitting ends where the elements' own kinks of
/// curvature are too many), the best file found is written and the report says so. The file is
/// written whole or not at all. Seconds for 10,000 triangles; about 90 bytes a pole.
///
/// Throws InputError: no region; a region without boundary, or whose boundary curve and image have
/// different parameters; a ring whose rims do not run around it, or whose holes leave no room for
/// the seam; a unit other than those of write_step; a tolerance that is not > 0, limits below those
/// above; dofs that are not finite; a file that cannot be written.
StepFaceReport write_step_face(const std::filesystem::path& file,
                               const std::vector<const SkinnedRegion*>& regions,
                               double model_unit_in_metres, const StepFaceOptions& options);

}  // namespace batten
