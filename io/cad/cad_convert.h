// Converts CAD files to other CAD formats and to glTF, meshes their faces, and summarises their
// contents.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// Options of convert_cad().
struct CadConvertOptions {
  double unit_in_metres = 0;  ///< of the output; 0: that of the input (BREP: mm)
  bool ap242 = false;         ///< write STEP AP242 instead of AP214
  /// glTF only: largest distance between triangles and faces, in the output unit; 0: 1e-3 of the
  /// model size.
  double chord = 0;
};

/// Result of a conversion: contents of the input, and of the output when it is read back.
struct CadConversion {
  CadContents before, after;  ///< `after` is empty for glTF
  /// One sentence for each kind of data that the output format cannot store.
  std::vector<std::string> notes;
  double unit_in_metres = 1e-3;  ///< of the output
  /// glTF only, in the output unit; see CadFacets.
  double size = 0, chord = 0, deviation = 0;
  int triangles = 0, cracks = 0, unmeshed = 0;
};

/// Converts a STEP, IGES or BREP file. The extension of `to` selects the output format:
///
///   .step .stp    AP214 or AP242, exact geometry; products, instances, layers, names and colours
///                 of products, faces and curves; coordinates with all digits; declares the unit
///   .iges .igs    boundary representation (5.3); names, colours, layers; each instance becomes
///                 a shape of its own; declares the unit
///   .brep .brp    geometry only: no names, no colours, no unit (other programs assume mm)
///   .glb          one triangle mesh per product, with its name and the colours of its faces; glTF
///                 uses metres, with the y axis up
///
/// The output file is written atomically: complete or not at all. Throws InputError as
/// read_cad_lines() does if the input cannot be read, for an unknown extension and for a unit that
/// CAD files cannot declare. Throws what AtomicFile throws, and Error if OpenCASCADE fails to write
/// the file. Takes about 0.3 s per MB.
CadConversion convert_cad(const std::filesystem::path& from, const std::filesystem::path& to,
                          const CadConvertOptions& options = {});

// Meshes CAD files: conforming triangles within a chord tolerance of the faces.

/// Options of tessellate_cad().
struct CadFacetOptions {
  double unit_in_metres = 0;  ///< of the mesh; 0: the file's own unit
  double chord = 0;  ///< largest distance from the faces, in that unit; 0: 1e-3 of the model size
  /// Use curved triangles (see PnTriangle). Far fewer of them meet the chord tolerance, but along
  /// edges the chords stay straight.
  bool curved = false;
};

/// Reads a STEP, IGES or BREP file and meshes its faces. Adjacent faces share the nodes on their
/// common edge. Free edges within 1e-5 of the model size of each other are sewn first (in IGES
/// files all edges are free). The mesh is refined up to four times until `deviation` is at most
/// `chord`. Throws InputError as read_cad_lines() does for files and entities, for a file without
/// faces, and for a chord below 1e-7 of the model size or not a valid length.
CadFacets tessellate_cad(const std::filesystem::path& file, const CadFacetOptions& options = {});

// Reads a summary of a CAD file.

/// Reads a STEP, IGES or BREP file and summarises its contents. Faces and curves without a colour
/// of their own inherit that of their product. Throws InputError as read_cad_lines() does for files
/// and entities. Costs 0.1 s per MB for reading, and twice that for areas and volumes.
CadContents read_cad_contents(const std::filesystem::path& file);

}  // namespace batten
