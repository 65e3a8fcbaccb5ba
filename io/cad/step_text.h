// How Batten writes a STEP file once OpenCASCADE has its contents. Internal.
#pragma once

#include <filesystem>
#include <string>

class STEPControl_Writer;
class TopoDS_Shape;

namespace batten {

class OccSettings;

struct StepHeader {
  std::string name, author, description;
};

/// OpenCASCADE's name of a length unit that CAD files can have. Throws InputError.
std::string cad_unit(double model_unit_in_metres);

/// Header and numbers in digits that come back as the same numbers; whole or not at all. Throws
/// InputError.
void save_step(STEPControl_Writer& writer, const std::filesystem::path& path,
               const StepHeader& header);

/// A shape as one product (AP214) in the unit of `occ`. `tolerance`: what the file declares. Throws
/// Error, InputError.
void write_shape(const std::filesystem::path& path, const TopoDS_Shape& shape, double tolerance,
                 const std::string& product, const StepHeader& header, OccSettings& occ);

}  // namespace batten
