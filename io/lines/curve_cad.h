// Writes curves to STEP and IGES files. Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/lines/curve_file_options.h"
#include "batten/io/lines/named_curve.h"

namespace batten {

/// Writes CAD files, by their ending, for write_curves(). All lines have curves. Throws InputError:
/// a unit that CAD files cannot have, a file that cannot be written; Error when OpenCASCADE fails.
void write_cad_curves(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options);

}  // namespace batten
