// Curves into STEP and IGES files. Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/lines/named_curve.h"

namespace batten {

/// What write_curves does for CAD; all lines have curves. Throws InputError.
void write_cad_curves(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
                      double model_unit_in_metres, bool iges);

}  // namespace batten
