// Pictures of curves with their curvature combs: what a batten would feel, to be seen.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fem/curve.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"

namespace batten {

/// Curves in one panel. From each, teeth stand out towards the outside of the bend, as long as the
/// curvature there times a scale; their tips are joined.
struct CombPanel {
  std::string title;
  std::vector<HermiteCurve> curves;
  std::vector<Vec3> points;  ///< drawn as dots
  /// Centre and radius of spheres, drawn as circles: where a brush works.
  std::vector<std::pair<Vec3, double>> spheres;
};

/// Panels side by side, with one scale of teeth, one view and one scale of length for all.
struct CombPicture {
  std::vector<CombPanel> panels;
  std::string unit;  ///< of lengths, for the legend
  /// Panel whose curvature decides the scale: what 95 % of its length does not exceed becomes an
  /// eighth of the drawing's size. Teeth longer than a quarter of it are cut off, and the panel's
  /// caption says how many.
  int scale_panel = 0;
  /// Degrees, as PictureScene has them. None: onto the plane that fits all curves best, x to the
  /// right or z upwards as far as that plane lets them.
  std::optional<std::pair<double, double>> view;
  int columns = 0;  ///< 0: up to three in a row
};

/// Draws one PNG, titles as captions below the panels, the legend of the scale in the first. Whole
/// or not at all; main thread only; needs a display (require_display). About 1 s. Without a size it
/// is 1600 pixels wide and as high as the drawing needs.
/// Throws InputError: no panel, a panel without a curve, a scale panel that is not one.
void draw_combs(const std::filesystem::path& path, const CombPicture& picture,
                const std::optional<PictureSize>& size = {});

}  // namespace batten
