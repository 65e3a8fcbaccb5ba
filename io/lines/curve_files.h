// SPDX-License-Identifier: MPL-2.0
// Reads curves given by points from text files. Writes curves as points, as polylines for ParaView,
// as drawings, or as B-splines for CAD.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/lines/named_lines.h"

namespace batten {

/// Reads the curves of a text file. The extension selects the format:
///
///   .csv .txt .xyz .dat   One point per row: 2 or 3 numbers (with 2 numbers, z = 0) separated by
///                         commas, semicolons, tabs or blanks. If the separator is not a comma, or
///                         the number is in double quotes, a comma inside a number is a decimal
///                         comma. A separator at the end of all rows is passed over. '#' and '//' start comments.
///                         Rows of words before the numbers are titles, even if they contain
///                         digits. A header row with at least two of the names x, y, z selects the
///                         columns; other columns are skipped. A column "line", "name" or "curve"
///                         assigns each point to a curve. A field in double quotes may contain
///                         separators, comment signs and, doubled, quotes. Without a header, the
///                         first of four columns may be the index of the point. Rows that are blank
///                         or contain only separators separate curves; a row of words after such a
///                         row is the name of the next curve. Curves without a name are named after
///                         the file, with _1, _2, … if there are several. A row `CURVE 3` starts a
///                         curve with the name "curve 3". An offset table (OffsetTable) has one
///                         curve per station, a Lednicer airfoil (join_lednicer) one curve around
///                         both sides.
///   .obj                  `v` and `l` records; vertex indices count from 1, negative ones from the
///                         end. Each `l` record is one curve, named after the last `o` or `g`
///                         record before it (numbered if several curves have the same name), or
///                         else after the file. In a name, '#' and '//' do not start comments.
///                         Records of two vertices are chained into curves by chain_segments(). All
///                         other records are skipped.
///   .curves               Drawn strokes. A stroke is a row `v N`, then N rows of three numbers;
///                         blank rows and comments are skipped. Strokes are named as in .csv. A
///                         stroke may be a single point, because drawn sketches contain such
///                         strokes.
///
/// Repeated points are kept. A UTF-8 byte-order mark and CRLF line ends are accepted.
/// `file_unit_over_model_unit` multiplies all coordinates. Reads about 3 million points per second;
/// the whole file is held in memory. Throws InputError ("file:line:column: found X, expected Y") if
/// the extension is unknown; the file is missing, invalid or without points; a curve has only one
/// point (except in .curves); a number is not finite; or the unit factor is not above 0.
std::vector<NamedPoints> read_point_lines(const std::filesystem::path& path,
                                          double file_unit_over_model_unit = 1);

// Writes curves.

/// The file extensions that write_curves() supports, with the dot.
const std::vector<std::string>& curve_file_extensions();

/// Writes curves to one file, atomically. The extension selects the format:
///
///   .curves .csv .obj   The points of each curve at NamedCurve::parameters. A faired file has as
///                       many points as its input, except for points that fairing moved onto their
///                       neighbour. read_point_lines() reads back exactly the same numbers.
///                       Names are in the column "curve" of .csv and in `o` records of .obj;
///                       .curves has no names.
///   .vtp                A polyline of at least 400 points per curve, with two coincident points
///                       where the curvature jumps. Point data: u, Curvature, Curvature_vector
///                       (towards the centre of curvature); cell data: Name, Closed. A curve of a
///                       single point becomes a cell that contains the point twice.
///   .dxf                Each curve as a polyline or as one exact B-spline; see write_dxf(). The
///                       file declares the model unit.
///   .svg                Plane curves as lines and Bézier curves; see write_svg(). The size of the
///                       page declares the model unit.
///   .step .stp          Each C1 segment between corners as one exact B-spline of degree 3 with the
///   .iges .igs          parameter u of the curve, named NAME or NAME.1, NAME.2, …; smooth closed
///                       curves become closed B-splines. The file declares the model unit.
///
/// Names may contain any Unicode characters; control characters become blanks, and bytes that are
/// not UTF-8 are taken as Latin-1. All formats except .curves keep the names, but not blanks at the
/// ends of names in .obj and CAD files. Readers make names unique.
///
/// The result contains one sentence per curve that was omitted because the format cannot store it:
/// curves of one point in .csv and .obj, curves without length in drawings, curves given only by
/// points in CAD files. It also contains a sentence if names are lost (.curves), or the plane of
/// the curves (.svg). Takes about 1 µs per point in text files, and 20 µs per curve segment in CAD
/// files.
///
/// Throws InputError if there are no curves or all of them were omitted, the extension is unknown,
/// CAD or DXF files cannot declare the unit, curves for SVG do not lie in a plane x, y or z =
/// const, a parameter or point is not finite, or the file cannot be written. Throws Error if
/// OpenCASCADE fails.
std::vector<std::string> write_curves(const std::filesystem::path& path,
                                      const std::vector<NamedCurve>& curves,
                                      const CurveFileOptions& options = {});

}  // namespace batten
