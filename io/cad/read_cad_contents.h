// Reads what is in a CAD file.
#pragma once

#include <filesystem>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// Reads a STEP, IGES or BREP file with its attributes. Colours of products come down to their
/// faces and curves unless these have their own. Throws InputError as read_cad_lines() does of
/// files and entities. Costs a reading of the file, 0.1 s a MB, and twice as long for areas and
/// volumes.
CadContents read_cad_contents(const std::filesystem::path& file);

}  // namespace batten
