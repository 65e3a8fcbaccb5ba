// Writes curves to files: as points, as polylines for ParaView, or as B-splines for CAD.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/lines/named_lines.h"

namespace batten {

/// File extensions that write_curves() supports, with the dot.
const std::vector<std::string>& curve_file_extensions();

/// Writes all curves to one file, atomically. The extension selects the format:
///
///   .curves .csv .obj   The points on the curves at `parameters`, so that a faired file has as
///                       many points as its input (minus those that fairing moved onto their
///                       neighbour). read_point_lines() reads back exactly the same numbers. Names
///                       are comments in .csv and `o` records in .obj; .curves has no names.
///   .vtp                A polyline of at least 400 points for each curve (two coincident points
///                       at jumps of the curvature). Point data: u, Curvature, Curvature_vector
///                       (towards the centre of curvature); cell data: Name, Closed. A single
///                       point is a cell that contains the point twice.
///   .step .stp          Each C1 segment between corners as one exact B-spline of degree 3 over
///   .iges .igs          the curve's own u, named NAME or NAME.1, NAME.2, …; smooth closed curves
///                       are closed B-splines. The file declares the model unit.
///
/// Returns a sentence for each curve that was left out because the format cannot store it: a curve
/// of one point in .csv and .obj, a curve given only by points in CAD files. Takes about 1 µs per
/// point of text, 20 µs per curve segment in CAD files.
///
/// Throws InputError: nothing to write (also if everything was left out), an unknown extension, a
/// unit that CAD files cannot declare, non-finite parameters or points, a file that cannot be
/// written. Throws Error if OpenCASCADE fails.
std::vector<std::string> write_curves(const std::filesystem::path& path,
                                      const std::vector<NamedCurve>& curves,
                                      const CurveFileOptions& options = {});

}  // namespace batten
