// SPDX-License-Identifier: MPL-2.0
// Adds faces to the faces of a CAD file and writes both as one shell or solid.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/continuity_report.h"

namespace batten {

/// Options of join_cad_files().
struct CadJoinOptions {
  std::vector<std::string> only, without;  ///< faces of `part`, as in CadFaceSelection
  double model_unit_in_metres = 1e-3;      ///< unit of `tolerance` and of the report
  /// Largest distance between edges that are merged, model units; above 0.
  double tolerance = 0;
  bool ap242 = false;  ///< STEP AP242 instead of AP214
};

/// Measurements of a STEP file of joined faces, after it was read back.
struct CadJoinReport {
  int faces = 0, added = 0;  ///< number of faces; of them, those that were added
  int solids = 0, shells = 0, closed_shells = 0;
  bool valid = false;        ///< true if the file passes the checks of OpenCASCADE
  double volume = 0;         ///< total volume of all solids, cubed model units
  double max_tolerance = 0;  ///< largest tolerance of edges and vertices, model units
  /// Continuity across all edges of the file, in model units.
  ContinuityReport continuity;
};

/// Joins faces of a CAD file with the faces of a second file, `added`, along coincident edges, and
/// writes a STEP file in the unit of `part`. The faces of `part` keep their surfaces, names and
/// colours; edges that both files have become one edge, with its curve and vertices in `part`. If one
/// edge of one file coincides with several of the other, OpenCASCADE's sewing selects the curve. A closed shell becomes a solid, with outward normals.
/// Several products of `part` become one.
///
/// The file is written atomically, then read back and measured. Throws InputError for a file that
/// cannot be read or written, for an unknown name of a face and for a tolerance that is not above 0;
/// Error if OpenCASCADE fails.
CadJoinReport join_cad_files(const std::filesystem::path& part, const std::filesystem::path& added,
                             const std::filesystem::path& to, const CadJoinOptions& options);

}  // namespace batten
