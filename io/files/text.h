// String helpers for readers of text files, and units of length.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// True for white space other than a line feed.
inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
/// The text without white space at both ends.
std::string_view trimmed(std::string_view text);
/// Converts ASCII letters to lower case.
std::string lower_case(std::string text);
/// The extension in lower case: ".obj" for "a.OBJ".
std::string lower_extension(const std::filesystem::path& path);
/// "1 point", "2 points"; with an irregular plural in `many`: "3 tori".
std::string format_count(long count, const std::string& noun, const std::string& many = "");

// Units of length, as named in scenes and on the command line.

/// The names of the supported length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// The length of a unit in metres. Throws InputError for an unknown name.
double unit_in_metres(const std::string& unit);
/// The name of a length unit, including those that only CAD files may have: um, km, mi, mil, uin.
/// For any other length the result looks like "0.002 m".
std::string format_unit(double unit_in_metres);

}  // namespace batten
