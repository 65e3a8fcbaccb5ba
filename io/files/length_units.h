// Units of length, as scenes and the command line name them.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// Length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// Throws InputError for another word.
double unit_in_metres(const std::string& unit);

}  // namespace batten
