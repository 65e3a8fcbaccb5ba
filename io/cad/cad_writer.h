// Writes CAD documents as text. Internal.
#pragma once

#include <string>
#include <filesystem>
#include <iosfwd>
#include <IGESControl_Writer.hxx>
#include <ostream>

#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/step_options.h"

namespace batten {

struct CadWriteOptions {
  CadFormat format = CadFormat::Step;
  bool ap242 = false;            ///< of STEP, instead of AP214
  double unit_in_metres = 1e-3;  ///< of the file
  std::string name;              ///< of the file, in its header
};

/// The text of a file with all products of a document and their attributes, of BREP the shape.
/// Throws InputError for a unit that such files cannot have, Error when OpenCASCADE fails.
std::string cad_text(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                     const CadWriteOptions& options);

}  // namespace batten

// Writes a STEP file once OpenCASCADE has its contents. Internal.

class STEPControl_Writer;

namespace batten {

class OccSettings;

struct StepHeader {
  std::string name, author, description;
};

/// OpenCASCADE's name of a length unit that CAD files can have. Throws InputError.
std::string cad_unit(double model_unit_in_metres);

/// The distance within which OpenCASCADE takes points for one when it reads a file: 1e-7 mm, in
/// model units.
inline double reader_coincidence(double model_unit_in_metres) {
  return 1e-10 / model_unit_in_metres;
}

/// Puts the file's text, with this header, with all digits of its numbers and with the names of
/// curves, into a stream.
void write_step_text(STEPControl_Writer& writer, const StepHeader& header, std::ostream& out);

/// What a STEP file says of itself.
struct StepFileProperties {
  StepHeader header;
  bool ap242 = false;    ///< instead of AP214
  double tolerance = 0;  ///< that it declares, model units
};

/// Writes each part as a product in the unit of `occ`, with the names and colours of its faces, the
/// names of their edges, and its curves. The file appears whole or not at all. Throws Error when
/// OpenCASCADE fails, InputError when the file cannot be written.
void write_parts(const std::filesystem::path& path, const std::vector<CadPart>& parts,
                 const StepFileProperties& properties, OccSettings& occ);

/// Writes a part with faces and, where there are any, the lines as a part of their own, as
/// write_parts() does.
void write_surfaces(const std::filesystem::path& path, const CadPart& part,
                    const StepFileOptions& options, double tolerance, OccSettings& occ);

/// The name and colour of the faces of a region: colours only tell regions apart.
CadFace face_of_region(const TopoDS_Face& face, const std::string& region, size_t number,
                       size_t regions);


// The text of IGES files. Internal.

/// Completes the model of a writer and prints it with digits that come back as the same numbers. Returns false
/// where OpenCASCADE cannot.
bool print_iges(IGESControl_Writer& writer, std::ostream& out);

}  // namespace batten
