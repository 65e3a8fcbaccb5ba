// Small things that all readers of text need.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// A blank other than a line end.
inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);
/// ASCII letters only.
std::string lower_case(std::string text);
/// ".obj" for "a.OBJ".
std::string lower_extension(const std::filesystem::path& path);
/// "1 point", "2 points"; "3 tori" with `many`.
std::string format_count(long count, const std::string& noun, const std::string& many = "");


// Units of length, as scenes and the command line name them.

/// The names of length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// The length of a unit in metres. Throws InputError for another word.
double unit_in_metres(const std::string& unit);
/// The name of a unit that CAD files may have: those above and um, km, mi, mil, uin; "0.002 m" for
/// another.
std::string format_unit(double unit_in_metres);

}  // namespace batten
