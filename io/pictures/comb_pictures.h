// SPDX-License-Identifier: MPL-2.0
// Draws pictures of curvature combs, along curves and across the shared edges of faces.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"

namespace batten {

/// Curves in one panel, each with its curvature comb. The teeth point away from the centre of
/// curvature; their length is the curvature times a scale factor. A line connects the tips.
struct CombPanel {
  std::string title;
  std::vector<HermiteCurve> curves;
  std::vector<Vec3> points;  ///< points to draw as dots
  /// Centres and radii of spheres that are drawn as circles, such as the areas of influence of a
  /// brush.
  std::vector<std::pair<Vec3, double>> spheres;
};

/// Content of a picture of curvature combs: panels side by side, with the same view, length scale
/// and comb scale (length of a tooth per unit of curvature).
struct CombPicture {
  std::vector<CombPanel> panels;
  std::string unit;  ///< length unit shown in the legend
  /// Index of the panel that determines the comb scale. A tooth at the 95th percentile of curvature
  /// (by curve length) is as long as an eighth of the size of the drawing, or a quarter of the
  /// median curve size if that is smaller. Teeth longer than 1.5 times this length are truncated;
  /// the caption of the panel gives the number of truncated teeth.
  int scale_panel = 0;
  /// Azimuth and elevation of the camera, degrees, as defined in PictureScene. Empty: the camera
  /// looks perpendicularly at the best-fit plane of all curves.
  std::optional<std::pair<double, double>> view;
  int columns = 0;  ///< number of panels per row; 0: automatic, up to three
};

/// Draws the panels of `picture` into one PNG file, written atomically. Titles are captions below
/// the panels; the first panel contains the legend of the comb scale.
///
/// Without `size`, the picture is 1600 pixels wide, and its height is adapted to the curves. Call
/// draw_combs() on the main thread; it needs a display (see require_display()) and takes about 1 s.
/// Throws InputError if there is no display, no panel, or a panel without a curve, if
/// `scale_panel`, the view or the size is out of range, or if the file cannot be written.
void draw_combs(const std::filesystem::path& path, const CombPicture& picture,
                const std::optional<PictureSize>& size = {});

// Curvature combs across the shared edges of faces.

/// An edge shared by two faces, with curvature vectors at the points of `line`. A curvature vector
/// is the normal curvature of one face across the edge times the unit normal. The kind is crease
/// (G0), tangent (G1) or curvature-continuous (G2).
struct EdgeComb {
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  std::vector<Vec3> line;
  std::array<std::vector<Vec3>, 2> curvature_vectors;
};

/// Content and view of a picture of the curvature combs across the edges of faces.
struct EdgePicture {
  std::string title, unit;
  std::vector<EdgeComb> edges;
  std::vector<std::vector<Vec3>> free_edges;  ///< polylines along free edges (edges with one face)
  /// Azimuth and elevation of the camera, degrees, as defined in PictureScene.
  std::pair<double, double> view{30, 25};
};

/// Draws the curvature combs across all edges of `picture` into one PNG file, written atomically.
///
/// Each edge has two combs, one per face, whose teeth point away from the centres of curvature. The
/// two combs coincide if the curvature is continuous across the edge; if it jumps, their tips
/// differ. Colours distinguish creases (G0), tangent edges (G1) and curvature-continuous edges
/// (G2); the legend gives the number of each. A tooth at the 95th percentile of curvature is a
/// tenth of the size of the model; longer teeth are truncated at 1.5 times that length.
///
/// Call it on the main thread; it needs a display (see require_display()). Throws InputError if
/// there is no display or nothing to draw, or if the file cannot be written.
void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size = {1600, 1200});

}  // namespace batten
