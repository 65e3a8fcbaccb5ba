// Drawing with VTK, shared by the pictures of surfaces and of meshes. Internal.
#pragma once

#include <vtkSmartPointer.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/pictures.h"

class vtkActor;
class vtkAlgorithmOutput;
class vtkDataArray;
class vtkLookupTable;
class vtkPolyData;
class vtkRenderer;

namespace batten::canvas {

using Colour = Vec3;
inline const Colour kBody(0.70, 0.775, 0.86), kLine(0.83, 0.21, 0.10), kContour(0.13, 0.17, 0.24),
    kParameter(0.30, 0.38, 0.50), kMesh(0.25, 0.30, 0.38), kText(0.14, 0.16, 0.20),
    kLoose(0.10, 0.45, 0.75);

/// Orthonormal: right, up, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  /// Degrees, as PictureScene has them.
  ViewAxes(double azimuth, double elevation);
  /// Against this direction; z upwards, or y where that looks down on the plane z = 0 (by less than
  /// 45 degrees from above or below).
  explicit ViewAxes(const Vec3& towards_camera);
};
/// Onto the plane that fits the points best, from the side of z, y or x that it faces.
ViewAxes best_view(const std::vector<Vec3>& points);

/// A part of the window in pixels, from its lower left corner.
struct Frame {
  double width, height;  // of the viewport
  double top, bottom;    // kept free for text
  double unit;           // 1 at 1600 × 1000: sizes of text and lines go with it
};

struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel in the model
};
/// So that all points are in the frame, at zoom 1.
Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Frame& frame, double zoom);

std::vector<Vec3> points_of(vtkPolyData& data);

vtkSmartPointer<vtkActor> actor(vtkAlgorithmOutput* port, vtkPolyData* data, const Colour& colour);
/// A smooth body in the light of add_lights().
vtkSmartPointer<vtkActor> body(vtkPolyData* facets, const Colour& colour);
/// Lines on the surface, moved towards the camera by a few pixels: parallel projection shows no
/// shift, and the facets cannot cover them.
void add_thin_lines(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double width,
                    const Vec3& offset);
/// Round dots of so many pixels.
void add_dots(vtkRenderer& renderer, vtkPolyData* points, const Colour& colour, double width);
void add_tubes(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double radius,
               const Vec3& offset);
/// Key from the upper left, head light, two fills: no side that faces the viewer stays dark. And
/// the background.
void add_lights(vtkRenderer& renderer);
/// One line of text that fits into `width`: smaller, then shorter.
void add_text(vtkRenderer& renderer, std::string text, double x, double y, double pixels,
              double width, bool centred);
/// Where titles go, and what they leave free.
Frame frame_of(double width, double height, const std::string& title, bool caption_below,
               double bar_height);
void add_title(vtkRenderer& renderer, const std::string& title, double width, double height,
               bool caption_below);
void set_camera(vtkRenderer& renderer, const ViewAxes& axes, const Fit& view, double width,
                double height);

/// Blue below 0, red above.
vtkSmartPointer<vtkLookupTable> diverging_colours(double limit);
/// Light to dark from 0 to the limit.
vtkSmartPointer<vtkLookupTable> sequential_colours(double limit);
/// Light and dark by turns from `low` to `high`, a change at every multiple of `width` above
/// `from`.
vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from, double width);
/// Largest magnitude between the 2nd and the 98th percentile, rounded up.
double field_limit(vtkDataArray& values);
/// The smallest number of two digits that is not below x > 0.
double rounded_up(double x);
/// The largest of 1, 2, 5 times a power of ten that is not above x > 0.
double round_step(double x);
/// Colours, numbers below them, the title above: 100 units high.
void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Frame& frame);

/// One sheet of `count` pictures in `columns`; `draw` fills the renderer of one of them, whose
/// viewport has the given size in pixels. Throws InputError.
Image sheet_image(
    int count, int columns, bool captions_below, const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);
/// The same as a PNG: whole or not at all.
void draw_sheet(
    const std::filesystem::path& path, int count, int columns, bool captions_below,
    const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);

}  // namespace batten::canvas
