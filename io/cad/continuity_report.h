// SPDX-License-Identifier: MPL-2.0
// Measures the continuity (G0, G1, G2) between adjacent faces of a CAD file.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

class TopoDS_Shape;

namespace batten {

/// Thresholds and sampling options of measure_continuity().
struct ContinuityOptions {
  /// Largest angle between two faces at a G1 edge, degrees. At a larger angle it is a crease.
  double angle_deg = 0.1;
  /// Largest jump of the normal curvature across a G2 edge, relative to the larger of the two
  /// curvatures. A G1 edge with a larger jump is not G2.
  double curvature = 0.05;
  /// Free edges within this distance of each other count as one edge; needed for IGES files, in
  /// which faces share no edges. Relative to the model size, 0 to 0.1; 0: no sewing.
  double sewing = 1e-5;
  /// Approximate number of teeth of a curvature comb per edge, for pictures. 0:
  /// EdgeContinuity::comb_samples and free_edge_lines stay empty.
  int comb_samples = 0;
};

/// Curvatures of the two faces adjacent to an edge, at one point of the edge.
struct EdgeCombSample {
  Vec3 at = Vec3::Zero();
  /// Curvature vector of each of the two faces: normal curvature across the edge times unit normal,
  /// in 1 / model unit. It points towards the centre of curvature.
  std::array<Vec3, 2> curvature_vectors{};
};

/// Continuity across an edge between two faces (for a seam, twice the same face). It is measured at
/// 17 points, or at four points per spline knot if that is more (at most 401 points). The outer 1 %
/// of the edge at each end is not measured. Lengths are in model units.
struct EdgeContinuity {
  int edge = 0;                ///< 1-based index of the edge in the file
  std::array<int, 2> faces{};  ///< 1-based indices of the two faces
  double length = 0;
  double gap = 0;        ///< largest distance between the two faces along the edge
  double angle_deg = 0;  ///< largest angle between the tangent planes of the two faces, degrees
  /// Largest jump |κ_a − κ_b| of the normal curvature across the edge, where κ_a and κ_b are the
  /// curvatures of the two faces, in 1 / model unit. The relative jump is |κ_a − κ_b| divided by
  /// the largest of |κ_a|, |κ_b| and 1 / model size.
  double curvature_jump = 0, relative_jump = 0;
  /// On a crease, the point with the largest angle between the faces; on other edges, the point
  /// with the largest relative curvature jump.
  Vec3 at = Vec3::Zero();
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  /// Curvatures at points along the edge; empty if ContinuityOptions::comb_samples is 0.
  std::vector<EdgeCombSample> comb_samples;
};

/// Continuity across all edges of a CAD file, and the numbers of its solids, shells, faces and
/// edges. Lengths are in model units.
struct ContinuityReport {
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int free_edges = 0;                 ///< number of edges with one face
  int non_manifold_edges = 0;         ///< number of edges with three or more faces
  int unmeasured = 0;                 ///< number of edges with an undefined tangent or curvature
  double size = 0;                    ///< diagonal of the bounding box of all edges of the file
  double area = 0;                    ///< total area of the faces
  std::vector<EdgeContinuity> inner;  ///< edges with two faces, in file order
  /// 1-based indices of slivers: faces whose width is below a thousandth of their length.
  std::vector<int> slivers;
  /// Polylines along the free edges; empty if ContinuityOptions::comb_samples is 0.
  std::vector<std::vector<Vec3>> free_edge_lines;
  /// The number of measured edges of a kind: creases, tangent or curvature-continuous edges.
  int count(EdgeContinuity::Kind kind) const;
  /// The worst edge of a kind, or nullptr if there is no edge of that kind. The worst crease has
  /// the largest gap, the worst tangent edge the largest angle, the worst curvature-continuous edge
  /// the largest relative curvature jump.
  const EdgeContinuity* worst(EdgeContinuity::Kind kind) const;
  /// The largest angle between faces at edges that are not creases, degrees; 0: only creases.
  double max_smooth_deg() const;
};

// Measures CAD files.

/// Reads a STEP, IGES or BREP file and measures the continuity across its edges. Newton's method
/// finds the points of both faces that are closest to each point of an edge. The normal curvature
/// across the edge is the quotient of the second and first fundamental forms. Throws InputError for
/// a file that cannot be read (as read_cad_lines()), for options out of range, and for a file
/// without faces. Takes about 0.1 ms per edge.
ContinuityReport measure_continuity(const std::filesystem::path& file, double model_unit_in_metres,
                                    const ContinuityOptions& options = {});

/// Formats a continuity report as a few lines of text, with the worst edges. `unit`: name of the
/// length unit of the report.
std::string continuity_text(const ContinuityReport& report, const ContinuityOptions& options,
                            const std::string& unit);

// Measures OpenCASCADE shapes.

/// The areas of the faces of a CAD shape, in the order of the faces. The areas are integrated by
/// OpenCASCADE between the knots of each face, on all threads.
std::vector<double> face_areas(const TopoDS_Shape& shape);

/// Measures the continuity across the edges of a CAD shape like measure_continuity(), but without
/// sewing and in the unit of the shape. `size`: diagonal of the bounding box of the edges of the
/// shape. Uses all threads.
ContinuityReport shape_continuity(const TopoDS_Shape& shape, double size,
                                  const ContinuityOptions& options = {});

}  // namespace batten
