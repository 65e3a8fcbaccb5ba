// Units of length, as scenes and the command line name them.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// The names of length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// The length of a unit in metres. Throws InputError for another word.
double unit_in_metres(const std::string& unit);
/// The name of a unit that CAD files may have: those above and um, km, mi, mil, uin; "0.002 m" for
/// another.
std::string format_unit(double unit_in_metres);

}  // namespace batten
