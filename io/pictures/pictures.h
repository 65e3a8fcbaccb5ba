// Offscreen pictures of surfaces and curve networks.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/pictures/image.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Content and view of one picture. The projection is parallel, z points upwards, and the camera is
/// moved so that everything is in view.
struct PictureScene {
  /// Scalar field or colouring of the surface.
  enum class Field {
    None,     ///< one colour
    Mean,     ///< mean curvature, blue below 0, red above
    Gauss,    ///< Gaussian curvature, in the same colours
    Regions,  ///< each face in its own colour
    Value     ///< `value`: light at 0, dark at the limit
  };
  /// A non-negative scalar field on the surface, with the title of its scale.
  struct Value {
    std::string title;
    std::function<double(int region, const Location& where)> at;
    double limit = 0;  ///< upper end of the scale; 0: 98th percentile of the values
  };

  std::vector<const SkinnedRegion*> regions;
  std::string title;  ///< UTF-8; scaled down, then truncated if too wide
  /// Scalar field; its scale is symmetric about 0 and clips 2 % at each end.
  Field field = Field::None;
  Value value;
  int contours = 0;                        ///< number of contour lines of height, evenly spaced
  Vec3 contour_direction = Vec3::UnitZ();  ///< direction of height
  int parameter_lines = 0;                 ///< number of lines of constant u, and of constant v
  bool lines = true;                       ///< true: draw the curves, as tubes
  /// Further curves that belong to no face, in another colour.
  std::vector<HermiteCurve> extra_curves;
  bool mesh = false;  ///< true: draw the element edges inside the trim
  /// Number of zebra stripes (reflection lines), alternately light and dark, at equal steps of the
  /// angle between the exact normal and `zebra_direction`. They cover the range of that angle,
  /// without 2 % at each end. A jump of the stripes shows a crease (G0), a kink a curvature jump
  /// (G1). Cannot be combined with a field.
  int zebra = 0;
  Vec3 zebra_direction{1, 0.6, 0};
  /// Camera direction in degrees. At azimuth 0 the camera looks along +y, at 90 along −x (azimuth
  /// is counter-clockwise seen from above). Elevation is the angle above the horizon, −90 to 90.
  double azimuth = -30, elevation = 30;
  double zoom = 1;       ///< scale factor; 1: everything is in view
  int tessellation = 0;  ///< facets per element edge, at most 64; 0: automatic

  // Set by share_view() for the pictures of a series. By default, each picture determines its own.
  std::vector<Vec3> in_view;  ///< points that the camera fits instead of the faces
  std::optional<std::pair<double, double>> contour_range;  ///< lowest and highest height
  double field_limit = 0;  ///< limit of a field's colours; 0: from its values
};

/// Draws one PNG, written atomically. Call it on the main thread; it takes about 1 s with software
/// OpenGL. Throws InputError if there is no display or no face, a value is out of range, a zebra
/// is combined with a field, or the file cannot be written.
void draw_picture(const std::filesystem::path& path, const PictureScene& scene,
                  const PictureSize& size = {});

/// Draws the same picture to memory, for animations.
Image picture_image(const PictureScene& scene, const PictureSize& size = {});

/// Gives all scenes of a series the same camera, contour heights and colour scale, so that only the
/// surface changes between pictures.
///
/// The camera has the direction of the first scene and is moved so that all scenes fit. Sets
/// in_view, contour_range and field_limit. Throws InputError for invalid scenes, like
/// draw_picture().
void share_view(std::vector<PictureScene>& scenes);

/// Draws several scenes into one PNG, row by row, with their titles as captions below them. `size`
/// is the size of the whole sheet. Throws the exceptions of draw_picture(), and InputError if there
/// are no scenes or no columns.
void draw_contact_sheet(const std::filesystem::path& path, const std::vector<PictureScene>& scenes,
                        int columns, const PictureSize& size = {});

// Pictures of curve networks, with alternative sets of loops that could be filled by surfaces.

/// One alternative: the loops that get a surface.
struct LoopAlternative {
  std::string title;
  /// The curves of each loop, in order; their directions are arbitrary.
  std::vector<std::vector<HermiteCurve>> loops;
  /// true: all loops bound one surface (annulus or hole); false: one surface per loop.
  bool one_surface = false;
};

/// Panels side by side. The first shows the whole network with all loops of all panels; one
/// close-up per alternative follows. Nearly flat loops are viewed perpendicularly.
struct LoopPicture {
  std::vector<HermiteCurve> lines;  ///< all curves of the network
  std::vector<LoopAlternative> alternatives;
  double azimuth = -30, elevation = 30;  ///< view of the first panel, degrees as in PictureScene
};

/// Draws the panels into one PNG, written atomically. The curves of loops are tubes, other curves
/// are thin.
///
/// Each loop is filled with a sheet in its own colour: a fan around its centre, or a band between
/// the two loops of one surface. These sheets are illustrations, not surfaces computed by Batten.
/// Call it on the main thread. Throws InputError if there is no display or no alternative, an
/// alternative has no loop, or the file cannot be written.
void draw_loops(const std::filesystem::path& path, const LoopPicture& picture);

}  // namespace batten
