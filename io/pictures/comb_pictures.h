// Pictures of curvature combs: of curves, and of faces across their shared edges.
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

/// Curves in one panel. The teeth of each comb point to the outside of the bend. Their length is
/// the curvature times a scale, and a line joins their tips.
struct CombPanel {
  std::string title;
  std::vector<HermiteCurve> curves;
  std::vector<Vec3> points;  ///< points drawn as dots
  /// Centre and radius of spheres, drawn as circles: the areas of influence of a brush.
  std::vector<std::pair<Vec3, double>> spheres;
};

/// Panels side by side with a common comb scale, view and length scale.
struct CombPicture {
  std::vector<CombPanel> panels;
  std::string unit;  ///< length unit, for the legend
  /// The panel that determines the comb scale. The curvature at the 95th percentile (by curve
  /// length) is drawn with an eighth of the drawing's size, or a quarter of the median curve size
  /// if that is smaller. Teeth longer than 1.5 times that are cut off; the panel's caption gives
  /// their number.
  int scale_panel = 0;
  /// Azimuth and elevation of the camera, in degrees as in PictureScene. Empty: the camera looks
  /// perpendicularly at the best-fit plane of all curves.
  std::optional<std::pair<double, double>> view;
  int columns = 0;  ///< panels per row; 0: automatic, up to three
};

/// Draws the panels into one PNG, written atomically. Titles are captions below the panels; the
/// first panel has the legend of the comb scale.
///
/// Without `size`, the picture is 1600 pixels wide and as high as the drawing needs. Call it on the
/// main thread; it needs a display (require_display) and takes about 1 s. Throws InputError if
/// there is no display, no panel, or a panel without a curve. Also throws it for an invalid scale
/// panel, a view or size out of range, or a file that cannot be written.
void draw_combs(const std::filesystem::path& path, const CombPicture& picture,
                const std::optional<PictureSize>& size = {});

// Curvature combs across the shared edges of faces.

/// An edge shared by two faces. At each point of `line`, and for each face: the normal curvature
/// across the edge times the unit normal. Kind: crease (G0), tangent (G1) or curvature-continuous
/// (G2).
struct EdgeComb {
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  std::vector<Vec3> line;
  std::array<std::vector<Vec3>, 2> curvature_vectors;
};

/// Input of draw_edge_combs().
struct EdgePicture {
  std::string title, unit;
  std::vector<EdgeComb> edges;
  std::vector<std::vector<Vec3>> free_edges;  ///< free edges, which have one face
  /// Azimuth and elevation of the camera, in degrees as in PictureScene.
  std::pair<double, double> view{30, 25};
};

/// Draws the combs of all edges into one PNG, written atomically.
///
/// Each edge carries two combs, one per face, which point away from the centres of curvature. They
/// coincide if the curvature is continuous, and their tips differ if it jumps. Colours distinguish
/// creases (G0), tangent edges (G1) and curvature-continuous edges (G2); the legend counts them.
/// The 95th percentile of curvature is drawn with a tenth of the model's size; longer teeth are cut
/// at 1.5 times that.
///
/// Call it on the main thread; it needs a display (require_display). Throws InputError if there is
/// no display or nothing to draw, or if the file cannot be written.
void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size = {1600, 1200});

}  // namespace batten
