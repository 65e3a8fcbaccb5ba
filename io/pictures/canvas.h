// Functions that draw with VTK, shared by the pictures of surfaces, curves and meshes. Internal.
#pragma once

#include <vtkSmartPointer.h>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/core/eigen.h"

namespace batten::detail {

// The camera of a picture: its direction, and the scale at which the model fits. Internal.

/// The camera's axes, orthonormal: to the right, upwards, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  /// Axes of a camera at this azimuth and elevation, in degrees as in PictureScene. `up`: the axis
  /// that points upwards, 0 (x) to 2 (z); the next one, cyclically, then stands for x.
  ViewAxes(double azimuth, double elevation, int up_axis = 2);
  /// Axes of a camera in this direction from the model. z points upwards in the picture; y does
  /// where the direction is less than 45 degrees away from +z or -z.
  explicit ViewAxes(const Vec3& towards_camera);
};
/// Axes of a camera that looks at right angles onto the plane that fits the points best: from above
/// (+z); from the front (-y) where that plane is steeper than 45 degrees; from the right (+x) where
/// it faces sideways. O(points).
ViewAxes best_view(const std::vector<Vec3>& points);

/// A part of the window in pixels, from its lower left corner.
struct Viewport {
  double width, height;  // size of the viewport
  double top, bottom;    // heights of the strips that are kept free for text
  double unit;           // scale of text and lines; 1 at 1600 × 1000
};

/// The point in the middle of a picture, and its scale.
struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel in the model
};
/// The focus and scale at which all points are in the viewport when `zoom` is 1; a zoom of 2 draws
/// everything twice as large. O(points).
Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom);

}  // namespace batten::detail

class vtkActor;
class vtkAlgorithmOutput;
class vtkLookupTable;
class vtkPolyData;
class vtkRenderer;

namespace batten::detail {

using Colour = Vec3;
inline const Colour kBody(0.70, 0.775, 0.86), kLine(0.83, 0.21, 0.10), kContour(0.13, 0.17, 0.24),
    kParameter(0.30, 0.38, 0.50), kMesh(0.25, 0.30, 0.38), kText(0.14, 0.16, 0.20),
    kExtraCurve(0.10, 0.45, 0.75);

/// The points of VTK's data, in its order.
std::vector<Vec3> points_of(vtkPolyData& data);
/// An actor that draws the output of `port` or, where that is null, `data` in one colour.

vtkSmartPointer<vtkActor> actor(vtkAlgorithmOutput* port, vtkPolyData* data, const Colour& colour);
/// An actor that draws facets as a smooth body in the light of add_lights().
vtkSmartPointer<vtkActor> body(vtkPolyData* facets, const Colour& colour);
/// Draws lines on the surface, `width` pixels wide. `offset` moves them towards the camera by a few
/// pixels, so that the facets do not cover them; parallel projection does not show the shift.
void add_thin_lines(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double width,
                    const Vec3& offset);
/// Draws points as round dots, `width` pixels across.
void add_dots(vtkRenderer& renderer, vtkPolyData* points, const Colour& colour, double width);
/// Draws lines as tubes. `radius` is in model units; `offset` is as in add_thin_lines().
void add_tubes(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double radius,
               const Vec3& offset);
/// Sets the background and four lights: from the upper left, from the camera, and two weak ones
/// from the right and from below, so that no side that faces the camera is dark.
void add_lights(vtkRenderer& renderer);
/// Writes one line of text, `pixels` high, at (x, y) in pixels from the lower left corner. A text
/// wider than `width` is made smaller (to 65 % at most), then cut.
void add_text(vtkRenderer& renderer, std::string text, double x, double y, double pixels,
              double width, bool centred);
/// The viewport of a picture with this title (a caption below it, or a title above) and with a
/// scalar bar of `bar_height` units (0 for none). All in pixels but that height.
Viewport viewport_of(double width, double height, const std::string& title, bool caption_below,
                     double bar_height);
void add_title(vtkRenderer& renderer, const std::string& title, double width, double height,
               bool caption_below);
void set_camera(vtkRenderer& renderer, const ViewAxes& axes, const Fit& view, double width,
                double height);

/// Draws a scalar bar at the lower edge: colours, numbers, and the title above. It is 100 units
/// (Viewport::unit) high.
void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Viewport& viewport);

/// Draws one sheet of `count` pictures in `columns` columns, in memory. `draw` fills the renderer
/// of one picture, whose viewport has the given size in pixels. Throws InputError: no display, a
/// size out of its range, pictures smaller than 32 pixels; NoSolutionError when VTK draws nothing.
Image sheet_image(
    int count, int columns, bool captions_below, const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);
/// Draws the same sheet and writes it as a PNG, which appears whole or not at all. Throws
/// InputError also when the file cannot be written, which is found out before drawing.
void draw_sheet(
    const std::filesystem::path& path, int count, int columns, bool captions_below,
    const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);

}  // namespace batten::detail
