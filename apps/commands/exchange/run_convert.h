// Implements `batten convert`: converts a file to another format.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"

namespace batten {

/// Input of run_convert().
struct ConvertTask {
  std::filesystem::path from, to;
  std::string unit;       ///< unit of the output file; empty: that of the input
  std::string from_unit;  ///< unit of an input file that states none; empty: unknown
  /// Chord tolerance of triangles from CAD faces, in the unit of the output file; 0: 1e-3 of the
  /// size.
  double chord = 0;
  bool ap242 = false;  ///< true: STEP AP242 instead of AP214
};

/// Report of a conversion.
struct ConvertReport : RunReport {
  std::string text;  ///< summary of input and output, several lines
};

/// Converts a file. Supported conversions:
///
///   CAD (.step .stp .iges .igs .brep .brp)  to CAD and .glb: convert_cad(); to .stl .obj .ply .off
///                                           .vtp .vtu .3mf: tessellate_cad(); to .csv .curves: its
///                                           curves
///   a mesh, or a deck's shells              to .stl .obj .ply .off .vtp .vtu, and with
///                                           `from_unit` to .glb .3mf, which are in one unit
///   lines                                   to what write_curves() writes
///
/// report.failed_checks lists what the output lacks compared with the input: faces, area,
/// closedness, names. It also lists triangles farther from the faces than the chord tolerance, and
/// cracks between them. Throws InputError like the readers and writers, and for unsupported pairs:
/// a mesh cannot be converted to CAD faces.
ConvertReport run_convert(const ConvertTask& task, const Progress& progress = {});

}  // namespace batten
