// Checked reading of input files, and limits on their size and nesting depth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace batten {

/// Checks that a file is a readable regular file of at most `kMaxInputFileSize` bytes. (Opening a
/// pipe would wait for its other end, and a device never ends.) Call it before a library opens the
/// file itself. Throws InputError "FILE: found no such file, expected WHAT" and similar for a
/// missing file, a folder, pipe, device or socket, circular links, missing permission, and a file
/// that is too large. `expected`: what the message says was expected, "a mesh". `where`: prefix of
/// the message, the position in another file that refers to this one.
void require_input_file(const std::filesystem::path& file, const std::string& expected,
                        const std::string& where = "");

/// The contents of a file. Throws as require_input_file(), and if reading fails midway.
std::string read_input_file(const std::filesystem::path& file, const std::string& expected,
                            const std::string& where = "");

/// Size of a file in bytes; 0 if it is unknown.
std::uintmax_t input_file_size(const std::filesystem::path& file) noexcept;

/// Maximum size of an input file: 2³¹ bytes. The data read from a file take several times its size.
inline constexpr std::uintmax_t kMaxInputFileSize = std::uintmax_t{1} << 31;

// Limits on the nesting depth of text formats.

/// Maximum nesting depth of lists, tables and parts of a dotted key.
inline constexpr int kMaxNestingDepth = 64;

/// Throws InputError with the position in `file` at which a TOML or JSON text is nested deeper than
/// kMaxNestingDepth. Parsers and the destructors of their results are recursive, so a text of some
/// thousand brackets would overflow the stack. Quoted strings and comments do not count. O(length).
void check_nesting_depth(std::string_view text, const std::string& file);

/// The same check for the elements of an XML text. Comments and quoted strings do not count.
void check_xml_nesting_depth(std::string_view text, const std::string& file);

}  // namespace batten
