// Describes the contents of CAD files as text.
#pragma once

#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// One line: "STEP AP214, in mm, 3 products, 1 solid, 12 faces, closed; 5 names, 2 colours".
std::string contents_line(const CadContents& contents);

/// The full description for `batten info`: products with their positions, names, colours and
/// layers, the first twenty of each. Lengths are in the file's unit.
std::string contents_text(const CadContents& contents);

/// Names that occur more often in `before` than in `after`: "'hull' (3 of 4)", the first few; empty
/// if none. `edges`: true: include edges of faces.
std::string missing_names(const std::vector<CadAttribute>& before,
                          const std::vector<CadAttribute>& after, bool edges);

}  // namespace batten
