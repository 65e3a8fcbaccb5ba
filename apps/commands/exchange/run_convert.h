// Does the work of `batten convert`: a file into a file of another kind.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"

namespace batten {

struct ConvertTask {
  std::filesystem::path from, to;
  std::string unit;       ///< of the file that is written; "": that of the file that is read
  std::string from_unit;  ///< of a file that states none; "": not said
  double chord =
      0;  ///< of triangles from CAD faces, unit of the file that is written; 0: 1e-3 of the size
  bool ap242 = false;  ///< STEP AP242 instead of AP214
};

struct ConvertReport : RunReport {
  std::string text;  ///< what was read and written, rows of a summary
};

/// Converts
///
///   CAD (.step .stp .iges .igs .brep .brp)  to CAD and .glb: convert_cad(); to .stl .obj .ply .off
///                                           .vtp .vtu .3mf: tessellate_cad(); to .csv .curves: its
///                                           curves
///   a mesh, or a deck's shells              to .stl .obj .ply .off .vtp .vtu, and with
///                                           `from_unit` to .glb .3mf, which are in one unit
///   lines                                   to what write_curves() writes
///
/// report.missed has what the written file lacks of the one that was read: faces, area, closedness,
/// names; and triangles that are farther from the faces than the chord, or have cracks between
/// them. Throws InputError as the readers and writers do, and for pairs that cannot be: a mesh is
/// not made into CAD faces.
ConvertReport run_convert(const ConvertTask& task, const Progress& progress = {});

}  // namespace batten
