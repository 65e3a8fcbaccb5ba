// What is in a CAD file that was read, counted and measured. Internal.
#pragma once

#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_file.h"

namespace batten {

/// The contents of a file that was read here. Throws what OpenCASCADE does.
CadContents contents_of(const CadFile& cad);

}  // namespace batten
