// The contents of a CAD file on their way out of a child process. Internal.
#pragma once

#include <string>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// As JSON, and back. Throws InputError for numbers that were not finite.
std::string to_bytes(const CadContents& contents);
CadContents contents_from_bytes(const std::string& bytes);

}  // namespace batten
