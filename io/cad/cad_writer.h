// SPDX-License-Identifier: MPL-2.0
// Writes CAD documents to STEP, IGES and BREP.
#pragma once

#include <IGESControl_Writer.hxx>
#include <filesystem>
#include <iosfwd>
#include <ostream>
#include <string>

#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/cad/cad_parts.h"

namespace batten {

/// Options of cad_text().
struct CadWriteOptions {
  CadFormat format = CadFormat::Step;
  bool ap242 = false;            ///< STEP only: AP242 instead of AP214
  double unit_in_metres = 1e-3;  ///< length unit of the file
  std::string name;              ///< name in the file header
};

/// The text of a CAD file with all products of a document and their attributes (BREP: only
/// `shape`). Throws InputError for a unit that CAD files cannot declare, Error if OpenCASCADE
/// fails.
std::string cad_text(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                     const CadWriteOptions& options);

}  // namespace batten

// Writes a STEP file from a filled OpenCASCADE writer.

class STEPControl_Writer;

namespace batten {

class OccSettings;

/// Text fields in the header of a STEP file.
struct StepHeader {
  std::string name, author, description;
};

/// OpenCASCADE's name of a length unit. Throws InputError if CAD files cannot declare the unit.
std::string cad_unit(double model_unit_in_metres);

/// The distance below which OpenCASCADE treats points as coincident when it reads a file: 1e-7 mm,
/// converted to model units.
inline double reader_coincidence(double model_unit_in_metres) {
  return 1e-10 / model_unit_in_metres;
}

/// Writes the text of a STEP file to a stream, with this header, with all digits of its numbers and
/// with the names of curves.
void write_step_text(STEPControl_Writer& writer, const StepHeader& header, std::ostream& out);

/// Header data of a STEP file.
struct StepFileProperties {
  StepHeader header;
  bool ap242 = false;    ///< AP242 instead of AP214
  double tolerance = 0;  ///< declared in the file as its uncertainty, model units
};

/// Writes each part as a product, in the unit of `occ`, with names and colours of faces, names of
/// edges, and curves. The file is written atomically. Throws Error if OpenCASCADE fails, InputError
/// if the file cannot be written.
void write_parts(const std::filesystem::path& path, const std::vector<CadPart>& parts,
                 const StepFileProperties& properties, OccSettings& occ);

/// Writes a part with faces and, if `options` has any, the curves as a separate product "curves".
/// Otherwise as write_parts().
void write_surfaces(const std::filesystem::path& path, const CadPart& part,
                    const StepFileOptions& options, double tolerance, OccSettings& occ);

/// The CAD face of a face of the model, with its name and a colour. The colour only distinguishes
/// faces; a single face gets none.
CadFace face_of_region(const TopoDS_Face& face, const std::string& region, size_t number,
                       size_t regions);

// The text of IGES files.

/// Completes the writer's IGES model and prints it with enough digits for an exact round trip.
/// Returns false if OpenCASCADE fails.
bool print_iges(IGESControl_Writer& writer, std::ostream& out);

}  // namespace batten
