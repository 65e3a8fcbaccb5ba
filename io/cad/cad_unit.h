// What CAD files say of themselves: schema and unit of length. Internal.
#pragma once

#include <string>

#include "batten/io/cad/cad_format.h"

class IGESData_IGESModel;
class StepData_StepModel;

namespace batten {

/// What a file says of itself.
struct CadHeader {
  CadFormat format = CadFormat::Step;
  std::string schema;            ///< of STEP, as the file names it; of IGES the version; else ""
  double unit_in_metres = 1e-3;  ///< of its lengths
  bool unit_stated = false;      ///< false where the unit is only what such files mostly have
  std::string note;              ///< what is odd about its unit; "" for nothing
};

/// The schema and unit of a STEP file. Where its parts have several units, the header has that of
/// the first, and says so.
CadHeader step_header(const StepData_StepModel& model);

/// The version and unit of an IGES file; without a unit it is in inches, as the standard has it.
CadHeader iges_header(const IGESData_IGESModel& model);

/// BREP has no unit: programs take it for millimetres.
CadHeader brep_header();
/// Nor have sets of patches.
CadHeader patches_header();

}  // namespace batten
