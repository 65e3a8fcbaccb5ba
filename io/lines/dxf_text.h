// SPDX-License-Identifier: MPL-2.0
// Strings and units of DXF files, for their reader and their writer.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace batten {

/// Lengths in metres of the units that $INSUNITS declares by a number.
inline constexpr std::pair<int, double> kInsUnits[] = {
    {1, 0.0254}, {2, 0.3048},  {3, 1609.344}, {4, 1e-3},    {5, 0.01},   {6, 1},
    {7, 1e3},    {8, 2.54e-8}, {9, 2.54e-5},  {10, 0.9144}, {11, 1e-10}, {12, 1e-9},
    {13, 1e-6},  {14, 0.1},    {15, 10},      {16, 100}};

/// Extended data (XDATA) of this application contain the names of curves that are not valid as
/// names of layers: the layer, followed by the name in one or more parts.
inline constexpr const char* kXDataApplication = "BATTEN";

/// The text of a DXF string in UTF-8. Characters that are not in the code page of the file are
/// written in DXF as `\U+XXXX`, in UTF-16.
std::string dxf_decoded(std::string_view text);
/// A character as one or two codes `\U+XXXX`.
std::string unicode_escapes(char32_t c);
/// A character of a DXF string in ASCII. The escape codes and '^', which starts the code of a
/// control character, are escaped too.
std::string dxf_character(char32_t c);

}  // namespace batten
