// What CAD files say of themselves: schema and unit of length. Internal.
#pragma once

#include "batten/io/cad/cad_file.h"

class IGESData_IGESModel;
class StepData_StepModel;

namespace batten {

/// The schema and unit of a STEP file. Where its parts have several units, the header has that of the
/// first, and says so.
CadHeader step_header(const StepData_StepModel& model);

/// The version and unit of an IGES file; without a unit it is in inches, as the standard has it.
CadHeader iges_header(const IGESData_IGESModel& model);

/// BREP has no unit: programs take it for millimetres.
CadHeader brep_header();

}  // namespace batten
