// How numbers and lists are written in decks of CalculiX. Internal: not installed.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// ccx reads the first 20 characters of a number and silently drops the rest, exponents included:
/// as many digits as fit, relative error 1e-13 at most.
std::string ccx_number(double value);
/// "x,y,z"
std::string ccx_vector(const Vec3& v);

/// For a comment: without line ends and other control characters.
std::string one_line(std::string text);

/// Nodes or elements that Batten counts from 0 and ccx from 1, up to 16 a row.
void write_ccx_ids(std::ostream& out, std::span<const int> ids);

}  // namespace batten
