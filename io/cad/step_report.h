// What is in a STEP file, measured.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace batten {

/// One region's fitted face. Lengths in model units. check_step knows region and deviation (a few
/// points against the nearest of the surface) only.
struct StepPatch {
  std::string region;
  /// Largest distance found between the face of the file and the surface, inside the trim: points
  /// of the face from the surface, points of the surface from the face, and both along the rim. It
  /// is taken at equal (u, v), so the nearest points are never farther apart.
  double deviation = 0;
  bool reached = false;  ///< deviation ≤ tolerance
  /// Largest distance between an edge of the file and its face: line_gap and the fit. Vertices too.
  double edge_gap = 0;
  /// The same between boundary curves and the surface: it comes with the region.
  double line_gap = 0;
  double edge_deviation = 0;  ///< of the file's edges from the boundary curves: rounding
  int poles_u = 0, poles_v = 0;
};

/// What is in a STEP file, measured on the file read back from disk by OpenCASCADE (which silently
/// repairs directions of curves and loops while it reads). Lengths in model units.
struct StepReport {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  int shells = 0, solids = 0;
  int closed_shells = 0;  ///< without a free edge
  int faces = 0;
  int edges = 0;
  int free_edges = 0;  ///< with one face only: the rims; a seam is none
  /// OpenCASCADE's checks passed (BRepCheck_Analyzer). They pass on a gap too, where reading widens
  /// the edge's tolerance over it: max_gap tells.
  bool valid = false;
  double size = 0;  ///< diagonal of the box around all edges
  double area = 0;
  double volume = 0;  ///< of all solids, model units³; of exact faces to 1e-12
  /// Largest distance between an edge and the faces beside it (9 points an edge, more on fitted
  /// faces), and between a vertex and the ends of its edges. Over `size` it is a relative gap.
  double max_gap = 0;
  /// Largest angle between the outward normals of two faces of one region along their edge, 9
  /// points an edge. Where the file's regions are not known all its faces are one.
  double max_normal_jump_deg = 0;
  /// Largest distance of points of the faces (15 each; StepPatch::deviation) to the regions'
  /// surfaces; only when these were given. Of write_step the exact faces only: `patches` has the
  /// fitted ones.
  std::optional<double> max_deviation;
  double max_tolerance = 0;  ///< of edges and vertices, as a reader has them
  /// Places where one of these could not be measured: an edge without a parameter line on its face,
  /// a point where the surface is singular.
  int unmeasured = 0;
  std::vector<std::string> warnings;

  // Of fitted faces.
  double tolerance = 0;                     ///< asked for
  bool reached = true;                      ///< by every one
  double line_gap = 0, edge_deviation = 0;  ///< largest of the faces
  std::vector<StepPatch> patches;           ///< in the order of the faces
};

}  // namespace batten
