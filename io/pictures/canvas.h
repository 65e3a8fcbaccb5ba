// Drawing with VTK, shared by the pictures of surfaces and of meshes. Internal.
#pragma once

#include <vtkSmartPointer.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/io/pictures/camera.h"
#include "batten/io/pictures/image.h"

class vtkActor;
class vtkAlgorithmOutput;
class vtkLookupTable;
class vtkPolyData;
class vtkRenderer;

namespace batten::canvas {

using Colour = Vec3;
inline const Colour kBody(0.70, 0.775, 0.86), kLine(0.83, 0.21, 0.10), kContour(0.13, 0.17, 0.24),
    kParameter(0.30, 0.38, 0.50), kMesh(0.25, 0.30, 0.38), kText(0.14, 0.16, 0.20),
    kLoose(0.10, 0.45, 0.75);

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
Viewport viewport_of(double width, double height, const std::string& title, bool caption_below,
                     double bar_height);
void add_title(vtkRenderer& renderer, const std::string& title, double width, double height,
               bool caption_below);
void set_camera(vtkRenderer& renderer, const ViewAxes& axes, const Fit& view, double width,
                double height);

/// Colours, numbers below them, the title above: 100 units high.
void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Viewport& viewport);

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
