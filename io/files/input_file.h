// SPDX-License-Identifier: MPL-2.0
// Reads input files with checks, limits their size and nesting depth, and runs third-party readers
// in a child process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace batten {

/// Checks that a file is a readable regular file of at most `kMaxInputFileSize` bytes. Call it
/// before a library opens the file. (Opening a pipe would wait for a writer, and reading a device
/// might never end.) Throws InputError "FILE: found no such file, expected WHAT" or similar for a
/// missing file, a folder, pipe, device or socket, circular links, missing permission, and a file
/// that is too large. `expected`: description of the expected file for the message, such as "a
/// mesh". `where`: prefix of the message, such as the location in another file that names this
/// file.
void require_input_file(const std::filesystem::path& file, const std::string& expected,
                        const std::string& where = "");

/// The contents of a file. Throws InputError as require_input_file() does, and if reading fails
/// midway. `expected`, `where`: as for require_input_file().
std::string read_input_file(const std::filesystem::path& file, const std::string& expected,
                            const std::string& where = "");

/// Size of a file in bytes; 0 if the size cannot be determined.
std::uintmax_t input_file_size(const std::filesystem::path& file) noexcept;

/// Maximum size of an input file: 2³¹ bytes. The data structures read from a file need several
/// times that amount of memory.
inline constexpr std::uintmax_t kMaxInputFileSize = std::uintmax_t{1} << 31;

// Limits on the nesting depth of text formats.

/// Maximum nesting depth of lists, tables and dotted keys in TOML and JSON files, and of elements
/// in XML files. The limit prevents stack overflows.
inline constexpr int kMaxNestingDepth = 64;

/// Checks a TOML or JSON text. Throws InputError with the location in `file` at which the text is
/// nested more deeply than kMaxNestingDepth. Without this check, a text of some thousand brackets
/// would overflow the stack in recursive parsers and destructors. Brackets in quoted strings and
/// comments do not count. O(length).
void check_nesting_depth(std::string_view text, const std::string& file);

/// Checks an XML text. Throws InputError with the location in `file` at which elements are nested
/// more deeply than kMaxNestingDepth. Comments and quoted strings do not count.
void check_xml_nesting_depth(std::string_view text, const std::string& file);

// Runs readers of third-party libraries in a child process, so that a crash does not affect the
// program.

/// Sets whether CAD and VTK files are read in a child process. If a damaged file crashes the
/// library, only the child process terminates. The `batten` program enables this. The default is
/// off, because forking a process with several threads may be unsafe: the child contains only the
/// thread that reads. The setting applies to the whole process; set it before the first file is
/// read.
void enable_sandboxed_read(bool yes);
bool is_sandboxed_read_enabled();

/// Runs `read` in a forked child process and returns the resulting bytes. If
/// is_sandboxed_read_enabled() is false, `read` runs in this process. The child is limited,
/// depending on the size of `file`, to a processor time of 6 s + 4 s per MB, four times that in
/// elapsed time, and memory of 1 GB + 200 times the size of the file. A child that sleeps for two
/// seconds is replaced by another one, up to three times: it waits for a lock that another thread
/// held during the fork. `times` multiplies the time
/// limits; use it if `read` does more than reading. The child writes nothing to the terminal, and
/// is_sandboxed_read_enabled() is false in it.
///
/// An exception of `read` is passed on as InputError; for other exceptions the message begins with
/// "FILE: LIBRARY …", where `library` names the library. Throws InputError also if the child
/// crashed (the message names the signal) or exceeded its time or memory, CancelledError if the
/// child was interrupted, and NoSolutionError if the system does not provide a process, or less
/// memory than these limits and the child needs more. Takes 1 to 10 ms, plus 1 ms per MB of the result.
std::string sandboxed_read(const std::filesystem::path& file, const std::string& library,
                           const std::function<std::string()>& read, int times = 1);

}  // namespace batten
