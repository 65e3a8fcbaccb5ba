// What is in CAD files, in words.
#pragma once

#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"

namespace batten {

/// One row: "STEP AP214, in mm, 3 products, 1 solid, 12 faces, closed; 5 names, 2 colours".
std::string contents_line(const CadContents& contents);

/// All of it, for `batten info`: products with their places, names, colours, layers; the first
/// twenty of each. Lengths are in the file's unit.
std::string contents_text(const CadContents& contents);

/// Names that `before` has more often than `after`: "'hull' (3 of 4)", the first few; "" for none.
/// `edges`: whether edges of faces count.
std::string missing_names(const std::vector<CadAttribute>& before,
                          const std::vector<CadAttribute>& after, bool edges);

}  // namespace batten
