// The contents of a CAD file on their way out of a child process. Internal.
#pragma once

#include <string>

#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_file.h"

namespace batten {

/// The contents of a file that was read here. Throws what OpenCASCADE does.
CadContents contents_of(const CadFile& cad);

std::string to_bytes(const CadContents& contents);
CadContents contents_from_bytes(const std::string& bytes);

}  // namespace batten
