// Pictures of surfaces, drawn without a window on the screen.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/skinning/region/region.h"

namespace batten {

/// What one picture shows and from where. Parallel projection, z upwards; the camera is moved so
/// that everything fits.
struct PictureScene {
  enum class Field {
    None,    ///< one colour
    Mean,    ///< mean curvature, blue below 0, red above
    Gauss,   ///< Gauss curvature, the same
    Regions  ///< each region in a colour of its own
  };

  std::vector<const SkinnedRegion*> regions;
  std::string title;          ///< UTF-8; made smaller, then shortened, when it is too wide
  Field field = Field::None;  ///< its scale is symmetric about 0; 2 % at each end may lie outside
  int contours = 0;           ///< lines of equal height, evenly spaced between lowest and highest
  Vec3 contour_direction = Vec3::UnitZ();  ///< in which heights are measured
  int parameter_lines = 0;          ///< lines of equal u, and as many of equal v, evenly spaced
  bool lines = true;                ///< character lines, embedded ones too, as tubes
  std::vector<HermiteCurve> loose;  ///< further lines, on no region: in another colour
  bool mesh = false;                ///< element edges, as far as they are inside
  /// Light and dark stripes of equal angle between normal and zebra_direction, as many between its
  /// lowest and highest value (2 % at each end apart): a jump of the stripes is an edge, a kink in
  /// them a jump of curvature. From exact normals; in place of a field.
  int zebra = 0;
  Vec3 zebra_direction{1, 0.6, 0};
  /// Where the camera stands, degrees: azimuth 0 looks along +y, 90 along -x (the camera goes
  /// counter-clockwise seen from above); elevation above the horizon, -90 to 90.
  double azimuth = -30, elevation = 30;
  double zoom = 1;       ///< 1: all in view
  int tessellation = 0;  ///< facets along each element edge; 0: as many as look smooth

  // What pictures of a series have in common, hold_view(); without, each has its own.
  std::vector<Vec3> in_view;  ///< the camera fits these points instead of the regions
  std::optional<std::pair<double, double>> contour_range;  ///< lowest and highest height
  double field_limit = 0;                                  ///< of the scale of a field; 0: its own
};

/// Draws one PNG. Whole or not at all; main thread only. About 1 s with software OpenGL.
/// Throws InputError: no display, no region, a value out of its range, a file that cannot be
/// written.
void draw_picture(const std::filesystem::path& path, const PictureScene& scene,
                  const PictureSize& size = {});

/// The same in memory, for animations.
Image picture_image(const PictureScene& scene, const PictureSize& size = {});

/// Gives all scenes one camera (that of the first, moved so that everything of all of them fits),
/// and contours and colours of fields the same heights and values: what moves in the series then is
/// the surface. Replaces in_view, contour_range and field_limit. Throws InputError.
void hold_view(std::vector<PictureScene>& scenes);

/// Several scenes in one PNG, row by row, with their titles as captions below them. `size` is that
/// of the whole sheet.
void draw_contact_sheet(const std::filesystem::path& path, const std::vector<PictureScene>& scenes,
                        int columns, const PictureSize& size = {});

}  // namespace batten
