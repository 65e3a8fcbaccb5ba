// Writes numbers and lists of decks of CalculiX. Internal: not installed.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// A number with as many digits as fit into 20 characters; its relative error is 1e-13 at most.
/// (ccx reads 20 characters and silently drops the rest, exponents included.)
std::string ccx_number(double value);
/// A vector as "x,y,z".
std::string ccx_vector(const Vec3& v);

/// A text for a comment: each control character, as of line ends, becomes a blank.
std::string one_line(std::string text);

/// Writes the numbers of nodes or elements, which `ids` counts from 0 and ccx from 1, up to 16 in a
/// row.
void write_ccx_ids(std::ostream& out, std::span<const int> ids);

}  // namespace batten
