// SPDX-License-Identifier: MPL-2.0
// VTK drawing functions shared by the pictures of surfaces, curves and meshes.
#pragma once

#include <vtkSmartPointer.h>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/pictures/drawing_primitives.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/picture_camera.h"

class vtkActor;
class vtkAlgorithmOutput;
class vtkLookupTable;
class vtkPolyData;
class vtkRenderer;

namespace batten::detail {

/// Red, green and blue, 0 to 1.
using Colour = Vec3;
inline const Colour kBody(0.535, 0.665, 0.795), kLine(0.83, 0.19, 0.09), kContour(0.13, 0.17, 0.24),
    kParameter(0.30, 0.38, 0.50), kMesh(0.25, 0.30, 0.38), kText(0.14, 0.16, 0.20),
    kExtraCurve(0.10, 0.45, 0.75);

/// Creates an actor that draws the output of `port` (or `data`, if `port` is null) in one colour.
vtkSmartPointer<vtkActor> actor(vtkAlgorithmOutput* port, vtkPolyData* data, const Colour& colour);
/// How an actor reflects light; see shading.h.
enum class Finish;
/// Creates an actor that draws facets as a smoothly shaded body.
vtkSmartPointer<vtkActor> body(vtkPolyData* facets, const Colour& colour, Finish finish);
/// Draws lines on the surface, `width` pixels wide. `offset` moves them towards the camera by a few
/// pixels, so that the facets do not hide them. Parallel projection does not show this shift.
void add_thin_lines(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double width,
                    const Vec3& offset);
/// Draws points as round dots, `width` pixels in diameter.
void add_dots(vtkRenderer& renderer, vtkPolyData* points, const Colour& colour, double width);
/// Draws lines as tubes. `radius` is in model units; `offset` as in add_thin_lines().
void add_tubes(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double radius,
               const Vec3& offset);
/// Sets the background of a picture of surfaces, to which sheet_image() adds ambient occlusion.
void set_stage(vtkRenderer& renderer);
/// Draws one line of text, `pixels` high, at (x, y) in pixels from the lower left corner. A text
/// wider than `width` is scaled down (to 65 % at most), then truncated.
void add_text(vtkRenderer& renderer, std::string text, double x, double y, double pixels,
              double width, bool centred);
/// Height of the text of scalar bars and legends, in pixels.
double label_pixels(double width, double height);
/// The viewport of a picture with this title (a caption below the picture, or above it), and with
/// `rows` rows of labels at the lower edge. All other lengths are in pixels.
Viewport viewport_of(double width, double height, const std::string& title, bool caption_below,
                     double rows);
/// Draws the title, or the caption below the picture.
void add_title(vtkRenderer& renderer, const std::string& title, double width, double height,
               bool caption_below);
/// Places the parallel-projection camera of a renderer.
void set_camera(vtkRenderer& renderer, const ViewAxes& axes, const Fit& view, double width,
                double height);

/// Rows of labels (see viewport_of()) that a scalar bar needs.
inline constexpr double kScalarBarRows = 4.8;
/// Draws a scalar bar at the lower edge: colours, round numbers, and the title above them. If
/// `values`, the range of the field, exceeds the range of the table, the end of the bar is pointed,
/// and the title gives the extreme value.
void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Range& values, const Viewport& viewport);

/// Renders a sheet of `count` pictures in `columns` columns to memory.
///
/// `draw` fills the renderer of one picture, whose viewport has the given size in pixels. Throws
/// InputError if there is no display, the size is out of range, or a picture is smaller than 32
/// pixels; NoSolutionError if VTK draws nothing.
Image sheet_image(
    int count, int columns, bool captions_below, const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);
/// Renders such a sheet and writes it as a PNG, atomically. Also throws InputError if the file
/// cannot be written, which is checked before drawing.
void draw_sheet(
    const std::filesystem::path& path, int count, int columns, bool captions_below,
    const PictureSize& size,
    const std::function<void(vtkRenderer&, int index, double width, double height)>& draw);

}  // namespace batten::detail
