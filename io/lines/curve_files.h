// Writes curves to files: as points, as polylines for ParaView, or as B-splines for CAD.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/lines/named_lines.h"

namespace batten {

/// Endings of files, with their dots, that write_curves() knows.
const std::vector<std::string>& curve_file_extensions();

/// Writes all curves into one file, which appears whole or not at all. Its ending says the kind.
///
///   .curves .csv .obj   The points on the curves at `parameters`, so that a faired file has as
///                       many points as before (less those that fairing moved to the place of
///                       their neighbour). read_point_lines() reads the digits back as the
///                       same numbers. Names are comments in .csv and `o` records in .obj; .curves
///                       has none.
///   .vtp                A polyline of 400 points or more for each curve (at jumps of curvature two
///                       in one place). Point data: u, Curvature, Curvature_vector (towards the
///                       centre); cell data: Name, Closed. A single point is a cell of that point
///                       twice.
///   .step .stp          Each C1 stretch between corners as one exact B-spline of degree 3 over the
///   .iges .igs          curve's own u, named NAME or NAME.1, NAME.2, …; closed smooth curves are
///                       closed B-splines. The file declares the model's unit.
///
/// Returns a sentence for each line that was left out because this kind of file cannot hold it: a
/// line of one point in .csv and .obj, a line without a curve in CAD files. Takes about 1 µs for
/// each point of text, 20 µs for each segment of CAD.
///
/// Throws InputError: nothing to write (also when all was left out), another ending, a unit that
/// CAD files cannot have, parameters or points that are not finite, a file that cannot be written;
/// Error when OpenCASCADE fails.
std::vector<std::string> write_curves(const std::filesystem::path& path,
                                      const std::vector<NamedCurve>& curves,
                                      const CurveFileOptions& options = {});

}  // namespace batten
