// Writes a STEP file once OpenCASCADE has its contents. Internal.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/step_file_options.h"

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

}  // namespace batten
