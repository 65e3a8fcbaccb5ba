// The lines of a drawing.
#pragma once

#include <memory>
#include <string>
#include <vector>
#include <filesystem>

#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// One line of a drawing.
struct DrawnLine {
  std::string name;          ///< unique in the file
  std::vector<Vec3> points;  ///< of a polyline, in the drawing's numbers; else there is a curve
  std::shared_ptr<const InputCurve> curve = {};
};

struct Drawing {
  std::vector<DrawnLine> lines;
  double unit_in_metres = 0;       ///< 0: the file does not say
  std::vector<std::string> notes;  ///< what was passed over, in words
};


// Reads lines of drawings: DXF and SVG.

/// Reads a drawing; its extension says the format.
///
///   .dxf   LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE (with bulges: arcs), SPLINE, in
///          space or in planes of their own (extrusion), and what INSERT places of blocks. Names:
///          the layer's, on layer 0 the file's, with _1, _2, … when there are several. Unit:
///          $INSUNITS. Text form only. Read by dxflib.
///   .svg   path, line, polyline, polygon, rect, circle, ellipse, with all transforms, in z = 0 with
///          y upwards. Names: label (Inkscape), else id, else the file's. Unit: that of width and
///          viewBox, else pixels of 1/96 inch. Paths are read by lib2geom.
///
/// Polylines without arcs are points, of which corners are found as in tables; what is round is
/// kept as it is. Text, hatches, dimensions, images and clones are passed over, and named in
/// `notes`. Throws InputError: a file that cannot be read, is damaged or cut off, or has no line.
Drawing read_drawing(const std::filesystem::path& path);

}  // namespace batten
