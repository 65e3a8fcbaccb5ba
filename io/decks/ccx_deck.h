// Formats numbers and lists for CalculiX decks. Internal: not installed.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// Formats a number with as many digits as fit into 20 characters; the relative error is at most
/// 1e-13. (ccx reads 20 characters and silently ignores the rest, exponents included.)
std::string ccx_number(double value);
/// Formats a vector as "x,y,z".
std::string ccx_vector(const Vec3& v);

/// A text for a comment line: control characters such as line ends are replaced by blanks.
std::string one_line(std::string text);

/// Writes node or element numbers, up to 16 per row. `ids` are 0-based; ccx numbers are 1-based.
void write_ccx_ids(std::ostream& out, std::span<const int> ids);

}  // namespace batten
