// Pictures of curves with their curvature combs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include <array>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/core/eigen.h"

namespace batten {

/// Curves in one panel. From each, teeth stand out towards the outside of the bend, as long as the
/// curvature there times a scale; their tips are joined.
struct CombPanel {
  std::string title;
  std::vector<HermiteCurve> curves;
  std::vector<Vec3> points;  ///< points that are drawn as dots
  /// Centre and radius of spheres, drawn as circles: where a brush works.
  std::vector<std::pair<Vec3, double>> spheres;
};

/// Panels side by side, with one scale of teeth, one view and one scale of length for all.
struct CombPicture {
  std::vector<CombPanel> panels;
  std::string unit;  ///< unit of lengths, for the legend
  /// The panel whose curvature decides the scale of the teeth: the curvature that 95 % of its
  /// length does not exceed is drawn as an eighth of the drawing's size, or a quarter of the median
  /// size of its curves where that is less. Teeth longer than 1.5 times that are cut off, and the
  /// panel's caption says how many.
  int scale_panel = 0;
  /// Azimuth and elevation of the camera, in degrees as in PictureScene. Without them the camera
  /// looks onto the plane that fits all curves best.
  std::optional<std::pair<double, double>> view;
  int columns = 0;  ///< 0: up to three in a row
};

/// Draws one PNG, which appears whole or not at all. Titles are captions below the panels; the
/// first panel has the legend of the scale. Without a size the picture is 1600 pixels wide and as
/// high as the drawing needs. To be called on the main thread; needs a display (require_display).
/// About 1 s. Throws InputError: no display, no panel, a panel without a curve, a scale panel that
/// does not exist, a view or size out of its range, a file that cannot be written.
void draw_combs(const std::filesystem::path& path, const CombPicture& picture,
                const std::optional<PictureSize>& size = {});


// Pictures of how faces bend across their edges.

/// An edge between two faces: points along it, and at each of them the normal curvature across the
/// edge times the unit normal, of both faces.
struct EdgeComb {
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  std::vector<Vec3> line;
  std::array<std::vector<Vec3>, 2> curvature_vectors;
};

struct EdgePicture {
  std::string title, unit;
  std::vector<EdgeComb> edges;
  std::vector<std::vector<Vec3>> free_edges;  ///< edges with one face
  /// Azimuth and elevation of the camera, in degrees as in PictureScene.
  std::pair<double, double> view{30, 25};
};

/// Draws one PNG, which appears whole or not at all. From each edge two combs stand out, away from
/// the centres of curvature, one for either face: where curvature goes on they are one, where it
/// jumps their tips are apart. Their colour tells creases, tangent edges and edges of one curvature
/// apart; the legend counts them. The curvature that 95 % of the teeth do not exceed is a tenth of
/// the model's size; longer teeth are cut at 1.5 times that. To be called on the main thread; needs
/// a display (require_display). Throws InputError: no display, nothing to draw, a file that cannot be
/// written.
void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size = {1600, 1200});

}  // namespace batten
