// SPDX-License-Identifier: MPL-2.0
// Reads and writes curves of drawings (DXF and SVG files), and reads sketches of connected strokes.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/lines/named_lines.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A curve of a drawing, given either by points or as a parametric curve.
struct DrawnLine {
  std::string name;          ///< unique within the file
  std::vector<Vec3> points;  ///< vertices of a polyline, in drawing units; empty if `curve` is set
  std::shared_ptr<const InputCurve> curve = {};
};

/// The curves of a drawing file and the length unit that the file declares.
struct Drawing {
  std::vector<DrawnLine> lines;
  double unit_in_metres = 0;       ///< drawing unit in metres; 0: the file declares no unit
  /// Sentences about skipped entities: texts, dimensions, images and others that are no curves;
  /// entities that may contain curves.
  std::vector<std::string> notes, warnings;
};

// Reads DXF and SVG drawings.

/// Reads the curves of a drawing file. The extension selects the format:
///
///   .dxf   LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE (bulges become arcs), SPLINE (of
///          control points, or a cubic spline through fit points) and HELIX entities of the model
///          that are visible, in space or in their own plane (extrusion), and the contents of blocks that
///          are inserted by INSERT. A curve is named after its layer (in layer 0, after the file),
///          with _1, _2, … if several curves have the same name. Names that are not valid as names
///          of layers are read from the extended data that write_dxf() adds, unless the curve was
///          moved to another layer. The unit is $INSUNITS. Only text files are supported.
///   .svg   path, line, polyline, polygon, rect, circle and ellipse elements that are displayed and
///          visible (also by style sheets), with all transforms, nested drawings (svg with viewBox
///          and preserveAspectRatio), clones (use) and symbols, in the plane z = 0 with y upwards. A curve is named after its Inkscape label, else its
///          id, else the file. The unit follows from width and viewBox; the default is pixels of
///          1/96 inch. The origin is the lower left corner of the page, or the point in the
///          attribute `data-batten-origin` of the root element, which write_svg() sets.
///
/// Polylines without arcs are returned as points, each of which is a corner of the polyline.
/// Curved entities are converted exactly. Text, hatches, dimensions and images are skipped and listed in `notes`, as are all other entities that are not curves. Throws InputError if the file cannot be read, is damaged or truncated, or
/// contains no curve.
Drawing read_drawing(const std::filesystem::path& path);

// Writes DXF and SVG drawings.

/// Writes curves to a DXF file (AutoCAD 2000), atomically; called by write_curves().
///
/// Each curve is one entity: LINE, LWPOLYLINE (in a plane z = const) or POLYLINE (in space) if all
/// its segments are straight, otherwise an exact SPLINE of degree 3 with the parameter u of the
/// curve and triple knots at corners. Each name gets its own layer; layer 0 contains the curves
/// without a name. The layer has the name of its curves, without characters that DXF does not allow
/// in names of layers. If the names differ, the name of the curve is added as extended data of the
/// application BATTEN. `curves`: as checked by write_curves(), each of positive length. Throws
/// InputError if DXF files cannot declare the unit ($INSUNITS) or the file cannot be written.
void write_dxf(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
               double unit_in_metres);

/// Writes curves to an SVG file, atomically; called by write_curves().
///
/// Each curve is one path of straight lines and cubic Bézier segments, with its name as Inkscape
/// label and a similar id. Coordinates are those of the curves, with y downwards; the page is the
/// bounding box with a margin of 5 %. The curves must lie in a common plane z = const, or else
/// y = const (drawn as x, z) or x = const (drawn as y, z), within 1e-9 of their size.
///
/// `curves`: as for write_dxf(). Returns a sentence about the plane unless it is z = 0, because the
/// file does not contain its position. Throws InputError if the curves do not lie in such a plane
/// or the file cannot be written.
std::vector<std::string> write_svg(const std::filesystem::path& path,
                                   const std::vector<NamedCurve>& curves, double unit_in_metres);

// Reads sketches.

/// Reads the strokes of a sketch graph in the format of CASSIE [Yu2021]:
///
///     strokes   [{"id", "segments": [segment ids, along the stroke]}]
///     segments  [{"id", "stroke_id", "ctrl_pts": [pieces], "nodes": [2 node ids]}]
///     nodes     [{"id", "position", "neighbor_edges"}]
///
/// A piece consists of the four control points of a cubic Bézier curve, or of the two ends of a
/// straight line. Each stroke becomes one curve that consists of exactly these pieces, with the
/// name "stroke 5" for the id 5. Pieces of length zero, strokes without pieces and other keys are
/// skipped. The nodes of the file are not used, because drawn sketches contain superfluous nodes
/// and lack others; the curve network detects nodes itself.
///
/// Throws InputError ("file: segment 7: found X, expected Y") if the file is missing or is not
/// valid JSON; an id is missing or occurs twice; a point does not consist of three finite numbers;
/// consecutive pieces have a gap of more than 1e-6 of the size of the sketch; or there is no
/// stroke.
std::vector<CharacterLine> read_sketch_graph(const std::filesystem::path& path);

/// Attribute of the root element of an SVG file with the origin of the curves, in user coordinates.
inline constexpr const char* kSvgOrigin = "data-batten-origin";

// Functions shared by the readers and writers of DXF and SVG files.

/// Read the curves of a DXF or SVG drawing; called by read_drawing().
Drawing read_dxf(const std::filesystem::path& path);
Drawing read_svg(const std::filesystem::path& path);

/// The straight line from `a` to `b`, as a cubic curve.
std::shared_ptr<const InputCurve> straight_segment(const Vec3& a, const Vec3& b);
/// The image of a curve under an affine transformation.
DrawnLine transformed(const DrawnLine& line, const AffineTransform& transform);

/// The vertices of a curve that is a polyline: given by points, or with straight segments only
/// (within 1e-12 of the coordinates). The first vertex of a closed polyline is repeated at its end.
/// Empty for a curve with a curved segment.
std::vector<Vec3> polyline_vertices(const NamedCurve& curve);
/// True if the cubic is a straight line from its first to its last Bézier point, without reversals.
bool is_straight(const BezierCubic<Vec3>& cubic);
/// The bounding box of the curves' Bézier points, or of their points.
Box3 drawing_box(const std::vector<NamedCurve>& curves);

/// Counts the entities of a drawing that are not converted to curves, by kind.
class SkippedEntities {
 public:
  void add(const std::string& kind) { ++count_[kind]; }
  /// Adds sentences that list the skipped entities to Drawing::notes and Drawing::warnings.
  void report_to(Drawing& drawing) const;

 private:
  std::map<std::string, int> count_;
};

}  // namespace batten
