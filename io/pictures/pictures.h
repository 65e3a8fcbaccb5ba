// SPDX-License-Identifier: MPL-2.0
// Draws pictures of surfaces and curve networks, without a window.
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
/// placed so that everything is visible.
struct PictureScene {
  /// Scalar field or colouring of the surface.
  enum class Field {
    None,     ///< one colour for all faces
    Mean,     ///< mean curvature; negative values blue, positive values red
    Gauss,    ///< Gaussian curvature; negative values blue, positive values red
    Regions,  ///< each face in a different colour
    Value     ///< values of PictureScene::value, from light (0) to dark (upper end of the scale)
  };
  /// A non-negative scalar field on the surface, and the title of its colour scale.
  struct Value {
    std::string title;
    std::function<double(int region, const Location& where)> at;
    double limit = 0;  ///< upper end of the colour scale; 0: 98th percentile of the field
  };

  std::vector<const SkinnedRegion*> regions;
  std::string title;  ///< UTF-8; a long title is first scaled down, then truncated
  /// Scalar field shown by colours. The colour scale of a curvature is symmetric about 0; the
  /// extreme 2 % of the values at each end are clipped.
  Field field = Field::None;
  Value value;
  std::string unit;  ///< length unit, shown with the colour scale of a curvature
  int contours = 0;  ///< number of contour lines of height, at equal height steps
  Vec3 contour_direction = Vec3::UnitZ();  ///< direction along which height is measured
  int parameter_lines = 0;  ///< number of lines of constant u, and of lines of constant v
  bool lines = true;  ///< true: draw the boundary curves and other curves of the faces as tubes
  /// Additional curves that belong to no face; drawn in a different colour.
  std::vector<HermiteCurve> extra_curves;
  bool mesh = false;  ///< true: draw the element edges inside the boundary of each face
  /// Number of zebra stripes (reflection lines), alternately light and dark; 0: none. The stripes
  /// divide the range of the angle between the exact surface normal and `zebra_direction` (without
  /// the extreme 2 % at each end) into equal steps. Stripes that break at an edge show a crease
  /// (G0); stripes with a kink show a curvature jump (G1). Cannot be combined with a field.
  int zebra = 0;
  Vec3 zebra_direction{1, 0.6, 0};
  /// Viewing direction in degrees. At azimuth 0 the camera looks along +y, at azimuth 90 along −x
  /// (azimuth is counter-clockwise as seen from above). Elevation is the angle of the camera above
  /// the horizontal plane, −90 to 90.
  double azimuth = -30, elevation = 30;
  double zoom = 1;       ///< magnification; 1: everything just fits into the picture
  int tessellation = 0;  ///< facets per element edge, at most 64; 0: automatic

  // The following members are set by share_view() for a series of pictures. By default, each
  // picture determines its own values.
  std::vector<Vec3> in_view;  ///< points that must be visible; empty: all points of the faces
  /// Heights of the lowest and the highest contour line; empty: determined from the surfaces.
  std::optional<std::pair<double, double>> contour_range;
  double field_limit = 0;  ///< upper end of the colour scale; 0: determined from the field
};

/// Draws a scene into a PNG file, written atomically. Call draw_picture() on the main thread; it
/// takes about 1 s with software OpenGL. Throws InputError if there is no display or no face, a
/// value is out of range, zebra stripes are combined with a field, or the file cannot be written.
void draw_picture(const std::filesystem::path& path, const PictureScene& scene,
                  const PictureSize& size = {});

/// Draws a scene as draw_picture() does, but into an image in memory, for animations.
Image picture_image(const PictureScene& scene, const PictureSize& size = {});

/// Gives all scenes of a series the same camera, contour heights and colour scale, so that their
/// pictures can be compared.
///
/// The viewing direction is that of the first scene; the camera is placed so that all scenes fit.
/// Sets the members in_view, contour_range and field_limit. Throws InputError for invalid scenes,
/// like draw_picture().
void share_view(std::vector<PictureScene>& scenes);

/// Draws several scenes into one PNG file, row by row, with each title as a caption below its
/// scene. `size` is the size of the whole sheet. Throws the exceptions of draw_picture(), and
/// InputError if there are no scenes or `columns` is 0.
void draw_contact_sheet(const std::filesystem::path& path, const std::vector<PictureScene>& scenes,
                        int columns, const PictureSize& size = {});

// Pictures of curve networks that show which loops of curves could be filled by surfaces.

/// One way to choose the loops of a network that are filled by surfaces.
struct LoopAlternative {
  std::string title;
  /// The curves of each loop, in order along the loop; the direction of a curve is arbitrary.
  std::vector<std::vector<HermiteCurve>> loops;
  /// True: all loops together bound one surface (an annulus, or a face with a hole). False: each
  /// loop bounds its own surface.
  bool one_surface = false;
};

/// Content of a picture of loops, in panels side by side. The first panel shows the whole network
/// with the loops of all alternatives; each further panel is a close-up of one alternative. Nearly
/// planar loops are viewed perpendicularly to their plane.
struct LoopPicture {
  std::vector<HermiteCurve> lines;  ///< all curves of the network
  std::vector<LoopAlternative> alternatives;
  double azimuth = -30, elevation = 30;  ///< view of the first panel, in degrees as in PictureScene
};

/// Draws the panels of `picture` into one PNG file, written atomically. Curves of loops are drawn
/// as tubes, other curves as thin lines.
///
/// Each loop is filled with a sheet in a different colour: a fan of triangles around the centre of
/// the loop, or a band between two loops of one surface. These sheets are illustrations, not
/// surfaces computed by Batten. Call draw_loops() on the main thread. Throws InputError if there is
/// no display or no alternative, an alternative has no loop, or the file cannot be written.
void draw_loops(const std::filesystem::path& path, const LoopPicture& picture);

}  // namespace batten
