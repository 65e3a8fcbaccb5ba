// SPDX-License-Identifier: MPL-2.0
// Converts CAD files to other CAD formats and to glTF, meshes their faces, and summarises their
// contents.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// Options for converting a CAD file to another format.
struct CadConvertOptions {
  /// Length unit of the output file in metres; 0: unit of the input file (mm for BREP).
  double unit_in_metres = 0;
  bool ap242 = false;  ///< true: write STEP AP242; false: AP214
  /// glTF only: largest distance between the triangles and the CAD faces, in the output unit; 0:
  /// 1e-3 of the size of the model.
  double chord = 0;
};

/// Result of a CAD conversion: contents of the input file, and of the output file read back.
struct CadConversion {
  CadContents before, after;  ///< `after` is empty for glTF
  /// One sentence for each kind of data that the output format cannot store.
  std::vector<std::string> notes;
  double unit_in_metres = 1e-3;  ///< length unit of the output file, in metres
  /// Accuracy of the triangle mesh, for glTF output only, in the output unit. The members are those
  /// of CadFacets with the same names.
  double size = 0, chord = 0, deviation = 0;
  int triangles = 0, cracks = 0, unmeshed = 0;
};

/// Converts a STEP, IGES or BREP file. The extension of `to` selects the output format:
///
///   .step .stp    STEP AP214 or AP242 with exact geometry; products, instances, layers, names and
///                 colours of products, faces and curves; full precision; declares the unit
///   .iges .igs    IGES 5.3 boundary representation; names, colours, layers; each instance becomes
///                 a separate shape; declares the unit
///   .brep .brp    geometry only, without names, colours and unit (other programs assume mm)
///   .glb          glTF: one triangle mesh per product, with the name of the product and the
///                 colours of its faces; coordinates are in metres, with the y axis up
///
/// The output file is written atomically: complete or not at all. Throws InputError for an input
/// file that cannot be read (as read_cad_lines()), an unknown extension, or a unit that CAD files
/// cannot declare. Throws FileError if the output file cannot be created, and Error if OpenCASCADE
/// fails to write it. Takes about 0.3 s per MB.
CadConversion convert_cad(const std::filesystem::path& from, const std::filesystem::path& to,
                          const CadConvertOptions& options = {});

// Meshes the faces of CAD files by conforming triangles within a chord tolerance.

/// Options for meshing the faces of a CAD file by triangles.
struct CadFacetOptions {
  double unit_in_metres = 0;  ///< length unit of the mesh in metres; 0: unit of the file
  /// Largest distance between the triangles and the CAD faces, in the unit of the mesh; 0: 1e-3 of
  /// the size of the model.
  double chord = 0;
  /// True: compute curved triangles (PnTriangle). Far fewer curved than flat triangles are needed
  /// for a given chord tolerance, but mesh edges on edges of CAD faces stay straight.
  bool curved = false;
  /// True: if all faces are primitives (CadFacets::primitives), which need no triangles for exact
  /// points, the chord tolerance of curved triangles is at least 1e-3 of the size of the model.
  bool coarse_primitives = false;
};

/// Reads a STEP, IGES or BREP file and triangulates its faces. Adjacent faces share the nodes on
/// common edges. Free edges that are within 1e-5 of the model size of each other are sewn first (in
/// IGES files all edges are free). The mesh is refined up to four times, until CadFacets::deviation
/// is at most `chord`. Throws InputError for a file that cannot be read (as read_cad_lines()), a
/// file without faces, or a chord that is invalid or below 1e-7 of the model size.
CadFacets tessellate_cad(const std::filesystem::path& file, const CadFacetOptions& options = {});

// Summaries of CAD files.

/// Reads a STEP, IGES or BREP file and summarises its contents. Faces and curves without a colour
/// inherit the colour of their product. Throws InputError for a file that cannot be read (as
/// read_cad_lines()). Takes 0.1 s per MB for reading, and 0.2 s per MB for areas and volumes.
CadContents read_cad_contents(const std::filesystem::path& file);

}  // namespace batten
