// SPDX-License-Identifier: MPL-2.0
// The text of a mesh file and of its included files: reading line by line, and formatting of
// coordinate fields that are replaced in it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"

namespace batten {

/// Type of the field that holds a coordinate in a file.
enum class FieldKind : std::uint8_t {
  Free,         ///< as many characters as the double needs
  Nastran8,     ///< 8 fixed columns
  Nastran16,    ///< 16 fixed columns
  NastranFree,  ///< at most 16 characters, between commas
  Abaqus,       ///< at most 20 characters
  Dyna10,       ///< 10 fixed columns
  Dyna16,       ///< 16 fixed columns
  Dyna20,       ///< 20 fixed columns
  DynaFree10,   ///< at most 10 characters, between commas
  DynaFree16,   ///< at most 16 characters, between commas
  DynaFree20,   ///< at most 20 characters, between commas
  Float32,      ///< binary, little-endian
  /// Binary, little-endian.
  Float64,
  Float32Swapped,  ///< binary, big-endian
  /// Binary, big-endian.
  Float64Swapped,
};

/// Width of a fixed field in columns, or maximum length of a free one; 0: unlimited.
int width_of(FieldKind kind);

/// Location of one coordinate of a node in the file.
struct Field {
  size_t begin = 0;          ///< byte offset in MeshSourceText
  std::uint32_t length = 0;  ///< length in bytes
  FieldKind kind = FieldKind::Free;
  /// True if the line ends before this field, or inside it while a later field is missing. An open
  /// field is written in full width, or with a preceding comma, together with all other open fields
  /// of its node.
  bool open = false;
  std::uint16_t gap = 0;  ///< open fields: blanks (or commas in a free line) to insert before it
};

/// Converts ASCII letters to upper case.
std::string upper(std::string_view text);
/// Removes the next blank-separated token from the front of `rest`; empty at the end.
std::string_view next_token(std::string_view& rest);

/// Parses a Fortran real: with or without a decimal point, with exponents such as 1.5E3, 1.5D3,
/// 1.5+3. The result is false if the field is not a number or exceeds the range of a double.
bool parse_real(std::string_view field, double& value);
/// Parses an integer. The result is false if the field is not an integer or is out of range.
bool parse_integer(std::string_view field, long& value);

/// Formats `value` in at most `width` characters, with a decimal point. Among all texts that fit,
/// it picks the one nearest to `value`, and the shortest of these. Exponents are written "+3" if
/// `nastran` is set, "e3" otherwise.
std::string fixed_real(double value, int width, bool nastran);

/// The text of a file and its included files, with a read position. Byte offsets run through all
/// texts, so a single number identifies the file and the location.
class MeshSourceText {
 public:
  /// One opened file.
  struct Source {
    std::filesystem::path path;
    std::filesystem::path canonical;  ///< absolute, without links
    std::string text;
    size_t base = 0;  ///< offset of its first byte
    /// Offset of the line that includes it; npos for the main file.
    size_t included_at = std::string::npos;
    /// Path relative to the deck's folder, used when a deck is written. Empty if the file is named by
    /// an absolute path; then it is not written.
    std::filesystem::path beside;
    bool ends_with_carriage_returns = false;  ///< line ends of the file, which are '\n' in `text`
  };

  /// Reads the file. Throws InputError for a missing file, a folder or an empty file and, unless
  /// `binary`, for UTF-16 text or zero bytes.
  explicit MeshSourceText(const std::filesystem::path& path, bool binary = false);
  /// Takes the contents of the file, or the text that another program made of it.
  MeshSourceText(const std::filesystem::path& path, std::string content, bool binary);

  /// The text of the main file.
  const std::string& text() const { return sources_.front()->text; }
  const std::filesystem::path& path() const { return sources_.front()->path; }
  /// All files in the order in which they were opened. A file included twice appears twice.
  const std::vector<std::shared_ptr<const Source>>& sources() const { return sources_; }

  /// Reads the next line, without its line end. At the end of an included file, reading continues
  /// after the line that includes it. Returns false at the end of the main file. A byte-order mark
  /// is skipped.
  bool next(std::string_view& line);
  /// Like next(), but returns false at the end of the current file.
  bool next_in_file(std::string_view& line);
  /// Byte offset of the line that next_in_file() will read.
  size_t position() const { return current().base + at_; }
  /// Moves the read position to an offset in the current file.
  void seek(size_t position) { at_ = position - current().base; }

  /// Continues with the first line of another file; at its end, reading resumes after the current
  /// line. `name`, found at `where`, is searched in the folder of the including file, then in that
  /// of the main file, then in `folders`. Throws InputError, with the locations of all including
  /// lines, if the file cannot be read or includes itself.
  void include(const std::string& name, std::string_view where,
               const std::vector<std::string>& folders = {});
  /// Skips the rest of an included file. Returns false in the main file.
  bool leave_file();
  /// Nesting depth of the current file; 0 for the main file.
  int depth() const { return static_cast<int>(open_.size()); }

  /// Byte offset of a view into one of the texts.
  size_t offset(std::string_view part) const;
  /// The `length` bytes at an offset.
  std::string_view part(size_t offset, size_t length) const;
  /// Index in sources() of the file that contains an offset.
  size_t source_index(size_t offset) const;
  const Source& source_of(size_t offset) const { return *sources_[source_index(offset)]; }
  /// Throws InputError: "file:line:column: message".
  [[noreturn]] void fail(size_t offset, const std::string& message) const;
  [[noreturn]] void fail(std::string_view where, const std::string& message) const {
    fail(offset(where), message);
  }
  /// True if the last line of the main file has no line end: the file may be truncated.
  bool ends_in_mid_line() const { return !text().empty() && text().back() != '\n'; }
  /// Throws InputError for the end of the main file.
  [[noreturn]] void fail_at_end(const std::string& message) const {
    fail(sources_.front()->base + text().size(), message);
  }
  /// "line 7"; with the file name if `seen_from` lies in another file.
  std::string line_name(size_t offset, size_t seen_from) const;

  /// Parses a finite real; an empty field is 0 if `blank_is_zero`. Throws InputError otherwise.
  double real(std::string_view field, bool blank_is_zero = false) const;
  /// Parses an integer. Throws InputError otherwise; `expected` describes the value for the
  /// message.
  long integer(std::string_view field, const std::string& expected) const;

 private:
  struct Including {
    size_t source, at;  // the including file and the position at which to resume
  };
  const Source& current() const { return *sources_[current_]; }
  void open(Source source, bool binary);
  std::string include_trace(size_t offset) const;

  std::vector<std::shared_ptr<const Source>> sources_;
  std::vector<Including> open_;
  std::set<std::filesystem::path> included_;  ///< canonical paths
  size_t current_ = 0, at_ = 0;
  size_t different_bytes_ = 0;  ///< of the files, each counted once
};

// Formatting of coordinates in the fields of a file.

/// True if fields of this kind occupy fixed columns.
bool is_fixed_width(FieldKind kind);
/// True for fields of decks, whose width is limited.
inline bool is_deck_field(FieldKind kind) { return width_of(kind) > 0; }
/// The characters that represent `value`; empty if it cannot be represented. `written` receives the
/// number that a reader will parse.
std::string format_field(double value, FieldKind kind, double& written);
/// Pads `text` like the old content `old` of the field: left-aligned, or right-aligned to the last
/// column.
std::string aligned(const std::string& text, const Field& field, std::string_view old);
/// Converts a small-field GRID line to two large-field lines with the given coordinates.
std::string large_field_grid(std::string_view line, const std::array<std::string, 3>& coordinates,
                             const std::string& line_end);

}  // namespace batten
