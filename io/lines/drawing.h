// Reads the curves of DXF and SVG drawings.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// One curve of a drawing: either points or a parametric curve.
struct DrawnLine {
  std::string name;          ///< unique within the file
  std::vector<Vec3> points;  ///< of a polyline, in drawing units; empty if there is a curve
  std::shared_ptr<const InputCurve> curve = {};
};

/// The curves of a drawing file.
struct Drawing {
  std::vector<DrawnLine> lines;
  double unit_in_metres = 0;       ///< 0: unknown, the file declares no unit
  std::vector<std::string> notes;  ///< descriptions of skipped entities
};

// Reads DXF and SVG drawings.

/// Reads a drawing. The extension selects the format:
///
///   .dxf   LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE (with bulges: arcs), SPLINE, in
///          space or in their own planes (extrusion), and the contents of blocks placed by INSERT.
///          Names: the layer, or the file name for layer 0; with _1, _2, … if there are several.
///          Unit: $INSUNITS. Text form only. Read with dxflib.
///   .svg   path, line, polyline, polygon, rect, circle, ellipse, with all transforms, in the plane
///          z = 0 with y upwards. Names: label (Inkscape), else id, else the file name. Unit: that
///          of width and viewBox, else pixels of 1/96 inch. Paths are read with lib2geom.
///
/// Polylines without arcs are returned as points; corners in them are detected as in point tables.
/// Curved entities are kept exactly. Text, hatches, dimensions, images and clones are skipped and
/// listed in `notes`. Throws InputError: a file that cannot be read, is damaged or truncated, or
/// contains no curve.
Drawing read_drawing(const std::filesystem::path& path);

}  // namespace batten
