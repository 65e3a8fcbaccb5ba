// CAD files into other CAD files, and into glTF, with their names, colours, layers and assemblies.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"

namespace batten {

struct CadConvertOptions {
  double unit_in_metres = 0;  ///< of the file that is written; 0: that of the file read, of BREP mm
  bool ap242 = false;         ///< STEP AP242 instead of AP214
  double chord =
      0;  ///< glTF: largest distance of triangles from faces, that unit; 0: 1e-3 of the size
};

/// What was read, and what the file that was written is when it is read back.
struct CadConversion {
  CadContents before, after;       ///< `after` of a glTF file: nothing
  std::vector<std::string> notes;  ///< what this kind of file cannot hold, sentences
  double unit_in_metres = 1e-3;    ///< of the file that was written
  /// Of glTF only, in that unit: as in CadFacets.
  double size = 0, chord = 0, deviation = 0;
  int triangles = 0, cracks = 0, unmeshed = 0;
};

/// Reads a STEP, IGES or BREP file and writes it by the ending of `to`:
///
///   .step .stp    AP214, or AP242: exact; products, instances, names and colours of faces, curves
///                 and products, layers; coordinates with all digits; the unit is declared
///   .iges .igs    boundary representation (5.3); names, colours, layers; instances become shapes
///                 of their own; the unit is declared
///   .brep .brp    shapes only: no names, no colours, and no unit, which programs take for mm
///   .glb          triangles by products with their names, in the colours of the faces; glTF is in
///                 metres, y up
///
/// The file appears whole or not at all. Throws InputError as read_cad_lines() does of the file
/// that is read, another ending, a unit that CAD files cannot have, what AtomicFile throws; Error
/// when OpenCASCADE cannot write it. Takes about 0.3 s a MB.
CadConversion convert_cad(const std::filesystem::path& from, const std::filesystem::path& to,
                          const CadConvertOptions& options = {});


// Meshes CAD files: triangles that are within a chord tolerance of the faces and hang together.

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


// Reads what is in a CAD file.

/// Reads a STEP, IGES or BREP file with its attributes. Colours of products come down to their
/// faces and curves unless these have their own. Throws InputError as read_cad_lines() does of
/// files and entities. Costs a reading of the file, 0.1 s a MB, and twice as long for areas and
/// volumes.
CadContents read_cad_contents(const std::filesystem::path& file);

}  // namespace batten
