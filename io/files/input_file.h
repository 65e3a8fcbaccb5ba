// Files that are read: which may be, and their bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace batten {

/// Only regular files are read: a pipe would wait for its other end, a device never ends. Throws
/// InputError "FILE: found no such file, expected WHAT" and the like for no file, a folder, a pipe,
/// a device, a socket, links that lead in a circle, a file that may not be read or is larger than
/// `kMaxInputFileSize`. `expected` is said in the message: "a mesh"; `where`, the place in another
/// file that names this one, before it. For libraries that open files themselves.
void require_input_file(const std::filesystem::path& file, const std::string& expected,
                        const std::string& where = "");

/// Returns the bytes of a file. Throws as require_input_file(), and when the system stops in the
/// middle of it.
std::string read_input_file(const std::filesystem::path& file, const std::string& expected,
                            const std::string& where = "");

/// Bytes of a file; 0 where the system does not tell.
std::uintmax_t input_file_size(const std::filesystem::path& file) noexcept;

/// Bytes: 2³¹. What is made of a file takes several times its size.
inline constexpr std::uintmax_t kMaxInputFileSize = std::uintmax_t{1} << 31;


// How deep the lists and tables of a text lie in each other.

/// Lists, tables and the parts of a dotted key may lie in each other so deep.
inline constexpr int kMaxNestingDepth = 64;

/// Throws InputError with the place in `file` at which a TOML or JSON text goes deeper than
/// kMaxNestingDepth. Parsers, and destructors of what they made, call themselves at each level: text
/// of some thousand brackets would take the whole stack. What stands in quotes or comments does not
/// count. O(length).
void check_nesting_depth(std::string_view text, const std::string& file);

/// The same of the elements of an XML text. What stands in comments and quotes does not count.
void check_xml_nesting_depth(std::string_view text, const std::string& file);

}  // namespace batten
