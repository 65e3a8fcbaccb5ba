// SPDX-License-Identifier: MPL-2.0
// String functions for readers of text files, and units of length.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// True for space, tab, carriage return, form feed and vertical tab, but not for line feeds.
inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
/// The text without white space at both ends.
std::string_view trimmed(std::string_view text);
/// Converts ASCII letters to lower case; other characters are unchanged.
std::string lower_case(std::string text);
/// The file extension in lower case, with the dot: ".obj" for "a.OBJ".
std::string lower_extension(const std::filesystem::path& path);
/// Replaces the line ends of a text whose lines end with a carriage return only (classic Mac OS).
/// True if there were such line ends.
bool replace_carriage_returns(std::string& text);
/// A count with its noun: "1 point", "2 points". `many`: plural of an irregular noun, as in "3
/// tori".
std::string format_count(long count, const std::string& noun, const std::string& many = "");

// Functions for writers of text files.

/// The shortest decimal representation that reads back as the same number, with a decimal point in
/// every locale.
std::string exact_number(double value);
/// The text in one row: control characters are replaced by blanks.
std::string single_row(std::string text);
/// The code points of a UTF-8 text. Each byte that is not valid UTF-8 is interpreted as a character
/// of Latin-1.
std::u32string code_points(std::string_view text);
/// Encodes code points as UTF-8. utf8(code_points(text)) makes any text valid UTF-8.
std::string utf8(std::u32string_view points);

// Text for terminals.

/// What printable() does with line feeds.
enum class LineFeeds {
  Escape,            ///< for names, and texts of one row
  KeepBeforeIndent,  ///< for messages: only before lines that begin with two blanks
  Keep               ///< for texts of several rows, whose names are printable already
};
/// The text without characters that control a terminal, so that names from files can neither move
/// the cursor nor look like lines of the program: control characters, also those of the order of
/// characters (Unicode's U+202E and its kin), become escapes such as \n, \x1B or \u009B, and bytes
/// that are not valid UTF-8 become \xE9.
std::string printable(std::string_view text, LineFeeds line_feeds = LineFeeds::Escape);

// Units of length, as named in scenes and on the command line.

/// The names of the supported length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// The length of a unit in metres. Throws InputError for an unknown unit.
double unit_in_metres(const std::string& unit);
/// The name of a length unit, including units that occur only in CAD files: um, km, mi, mil, uin. A
/// length without a name is formatted as "0.002 m".
std::string format_unit(double unit_in_metres);

}  // namespace batten
