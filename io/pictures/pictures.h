// Pictures of surfaces, drawn without a window on the screen.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// What one picture shows, and from where. Projection is parallel, z points upwards, and the camera
/// is moved so that everything fits.
struct PictureScene {
  enum class Field {
    None,     ///< one colour
    Mean,     ///< mean curvature, blue below 0, red above
    Gauss,    ///< Gauss curvature, in the same colours
    Regions,  ///< each region in a colour of its own
    Value     ///< `value`, light at 0 and dark at the limit
  };
  /// A quantity of the surface that is not below 0, and what its scale says.
  struct Value {
    std::string title;
    std::function<double(int region, const Location& where)> at;
    double limit = 0;  ///< of the colours; 0: from the values, 2 % of which may lie above
  };

  std::vector<const SkinnedRegion*> regions;
  std::string title;          ///< UTF-8; made smaller, then shortened, when it is too wide
  Field field = Field::None;  ///< its scale is symmetric about 0; 2 % at each end may lie outside
  Value value;
  int contours = 0;                        ///< number of lines of equal height, evenly spaced
  Vec3 contour_direction = Vec3::UnitZ();  ///< direction in which heights are measured
  int parameter_lines = 0;  ///< number of lines of equal u, and of equal v, evenly spaced
  bool lines = true;        ///< whether character lines are drawn, as tubes
  std::vector<HermiteCurve> extra_curves;  ///< further lines, on no region, in another colour
  bool mesh = false;                       ///< whether element edges inside the trim are drawn
  /// Number of stripes, light and dark in turn, of equal angle between the exact normal and
  /// zebra_direction. They are spread over the range of that angle (without 2 % at each end). A
  /// jump of the stripes is an edge, a kink in them a jump of curvature. Not together with a field.
  int zebra = 0;
  Vec3 zebra_direction{1, 0.6, 0};
  /// Place of the camera, in degrees. At azimuth 0 it looks along +y, at 90 along -x (it goes
  /// counter-clockwise seen from above). Elevation is the angle above the horizon, -90 to 90.
  double azimuth = -30, elevation = 30;
  double zoom = 1;       ///< scale of the picture; at 1 all is in view
  int tessellation = 0;  ///< facets along each element edge, to 64; 0: as many as look smooth

  // share_view() sets these for the pictures of a series. Otherwise each picture has its own.
  std::vector<Vec3> in_view;  ///< the camera fits these points instead of the regions
  std::optional<std::pair<double, double>> contour_range;  ///< lowest and highest height
  double field_limit = 0;  ///< limit of the colours of a field; 0: from its values
};

/// Draws one PNG, which appears whole or not at all. To be called on the main thread. About 1 s
/// with software OpenGL. Throws InputError: no display, no region, a value out of its range, a
/// zebra beside a field, a file that cannot be written.
void draw_picture(const std::filesystem::path& path, const PictureScene& scene,
                  const PictureSize& size = {});

/// Draws the same picture in memory, for animations.
Image picture_image(const PictureScene& scene, const PictureSize& size = {});

/// Gives all scenes the same camera (that of the first, moved so that everything of all of them
/// fits), the same heights of contours and the same colours of fields, so that only the surface
/// moves in the series. Replaces in_view, contour_range and field_limit. Throws InputError as
/// draw_picture() does of scenes.
void share_view(std::vector<PictureScene>& scenes);

/// Draws several scenes into one PNG, row by row, with their titles as captions below them. `size`
/// is that of the whole sheet. Throws InputError as draw_picture() does, and when there are no
/// scenes or no columns.
void draw_contact_sheet(const std::filesystem::path& path, const std::vector<PictureScene>& scenes,
                        int columns, const PictureSize& size = {});


// Pictures of a network's lines, with surfaces that could be made in loops of them.

/// One way to have surfaces: the loops that have one.
struct LoopAlternative {
  std::string title;
  /// The lines of each loop, one after the other, any way round.
  std::vector<std::vector<HermiteCurve>> loops;
  bool one_surface = false;  ///< the loops bound one surface, a ring or a hole, not one each
};

/// Panels side by side. The first shows all lines from afar, with all loops of all panels; then
/// follows one panel for each way, from near; loops that are nearly flat are seen at right angles.
struct LoopPicture {
  std::vector<HermiteCurve> lines;  ///< all lines of the network
  std::vector<LoopAlternative> alternatives;
  double azimuth = -30, elevation = 30;  ///< of the first panel, degrees as in PictureScene
};

/// Draws one PNG, which appears whole or not at all: the loops' lines as tubes, a sheet in each
/// loop in a colour of its own (a fan around its middle; a band between the two loops of one
/// surface: no surfaces of Batten), other lines thin.
/// To be called on the main thread. Throws InputError: no display, no way, ways without a loop, a
/// file that cannot be written.
void draw_loops(const std::filesystem::path& path, const LoopPicture& picture);

}  // namespace batten
