// Writes a STEP file once OpenCASCADE has its contents. Internal.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "batten/io/cad/cad_parts.h"

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

/// Puts the file's text, with this header and with all digits of its numbers, into a stream.
void put_step(STEPControl_Writer& writer, const StepHeader& header, std::ostream& out);

/// Writes the file with this header and with all digits of its numbers. It appears whole or not at
/// all. Throws InputError when it cannot be written.
void save_step(STEPControl_Writer& writer, const std::filesystem::path& path,
               const StepHeader& header);

/// Writes a part as one product (AP214) in the unit of `occ`, with the names and colours of its
/// faces and the names of their edges. The file declares `tolerance`. Throws Error when OpenCASCADE
/// fails, InputError when the file cannot be written.
void write_part(const std::filesystem::path& path, const CadPart& part, double tolerance,
                const StepHeader& header, OccSettings& occ);

/// The name and colour of the faces of a region: colours only tell regions apart.
CadFace face_of_region(const TopoDS_Face& face, const std::string& region, size_t number,
                       size_t regions);

}  // namespace batten
