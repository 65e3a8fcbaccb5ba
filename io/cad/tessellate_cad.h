// Meshes CAD files: triangles that are within a chord tolerance of the faces and hang together.
#pragma once

#include <filesystem>

#include "batten/io/cad/cad_facets.h"

namespace batten {

struct CadFacetOptions {
  double unit_in_metres = 0;  ///< of the mesh; 0: the file's own
  double chord = 0;           ///< largest distance from the faces, that unit; 0: 1e-3 of the size
  /// Triangles that bulge as PnTriangle says: far fewer keep the chord, but chords along edges are straight.
  bool curved = false;
};

/// Reads a STEP, IGES or BREP file and meshes its faces. Faces that share an edge share its nodes;
/// where edges with one face lie within 1e-5 of the size of each other (all do in IGES), they are
/// made one before. Finer deflections are tried, four times at most, until `deviation` is below the
/// chord. Throws InputError as read_cad_lines() does of files and entities, for a file without
/// faces, and for a chord that is below 1e-7 of the size or not a length.
CadFacets tessellate_cad(const std::filesystem::path& file, const CadFacetOptions& options = {});

}  // namespace batten
