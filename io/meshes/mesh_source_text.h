// The text of a mesh file and of the files that it includes. Each is read in one piece and parsed
// line by line; coordinates are replaced in it. Internal.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>
#include <array>

#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"

namespace batten {

/// The kind of field in which a file holds a coordinate.
enum class FieldKind : std::uint8_t {
  Free,         ///< as many characters as the double needs
  Nastran8,     ///< 8 fixed columns
  Nastran16,    ///< 16 fixed columns
  NastranFree,  ///< 16 characters at most
  Abaqus,       ///< 20 characters at most
  Dyna16,       ///< 16 fixed columns
  Dyna20,       ///< 20 fixed columns
  DynaFree16,   ///< 16 characters at most
  DynaFree20,   ///< 20 characters at most
  Float32,      ///< binary, little end first
  Float64,
  Float32Swapped,  ///< binary, big end first
  Float64Swapped,
};

/// The columns of a fixed field, or the most characters of a free one; 0: as many as it needs.
int width_of(FieldKind kind);

/// The place of one coordinate of a node in the file.
struct Field {
  size_t begin = 0;          ///< offset in bytes
  std::uint32_t length = 0;  ///< bytes
  FieldKind kind = FieldKind::Free;
  /// The line ends before this field, or inside it while a later one is missing: it is written in
  /// full width, or with a comma before it, together with the others of its node that are open.
  bool open = false;
  std::uint16_t gap = 0;  ///< open: blanks, or commas in a free line, to write before it
};

std::string upper(std::string_view text);
/// Takes the next word away from the front of `rest` and returns it; empty at the end.
std::string_view next_word(std::string_view& rest);

/// Reads a number as Fortran does: with a decimal point or without, exponents 1.5E3, 1.5D3, 1.5+3.
/// Returns false when the field is not a number or its value is out of a double's range.
bool parse_real(std::string_view field, double& value);
/// Reads a whole number. Returns false when the field is not one, or is out of range.
bool parse_integer(std::string_view field, long& value);

/// The text of at most `width` characters, with a decimal point, whose number is nearest to
/// `value`; the shortest of these. Exponents are written "+3" (Nastran) or "e3".
std::string fixed_real(double value, int width, bool nastran);

/// The text of a file, of the files that it includes, and a position in them from which lines are
/// read. Offsets count through all texts, so that one number says file and place.
class MeshSourceText {
 public:
  struct Source {
    std::filesystem::path path;
    std::string text;
    size_t base = 0;  ///< offset of its first byte
    /// Offset of the line that includes it; npos for the file that was named first.
    size_t included_at = std::string::npos;
    /// Where a deck that is written has it, from the folder of the deck. Empty: it lies outside of
    /// that folder or is named by a whole path; it is not written.
    std::filesystem::path beside;
  };

  /// Reads the file. Throws InputError: no file, a folder, an empty file and, unless it is
  /// `binary`, UTF-16 text or zero bytes.
  explicit MeshSourceText(const std::filesystem::path& path, bool binary = false);

  /// The file that was named first.
  const std::string& text() const { return sources_.front()->text; }
  const std::filesystem::path& path() const { return sources_.front()->path; }
  /// All files in the order in which they were opened. A file that is included twice is here twice.
  const std::vector<std::shared_ptr<const Source>>& sources() const { return sources_; }

  /// Reads the next line, without its line end; after the last line of an included file that behind
  /// the line which includes it. Returns false at the end of everything. A byte-order mark is
  /// passed over.
  bool next(std::string_view& line);
  /// The same, but returns false at the end of the current file.
  bool next_in_file(std::string_view& line);
  /// Offset, in bytes, of the line that next_in_file() reads.
  size_t position() const { return current().base + at_; }
  /// To a position in the current file.
  void seek(size_t position) { at_ = position - current().base; }

  /// Goes on with the first line of another file, and after its last one behind the current line.
  /// `name`, as it stands at `where`, is looked for from the folder of that file, from that of the
  /// first file, then in `folders`. Throws InputError with the places of all including lines:
  /// a file that cannot be read, one that includes itself.
  void include(const std::string& name, std::string_view where,
               const std::vector<std::string>& folders = {});
  /// Leaves the rest of an included file. Returns false in the file that was named first.
  bool leave_file();
  /// In how many including files the current one lies.
  int depth() const { return static_cast<int>(open_.size()); }

  /// Offset of a part of a text, in bytes.
  size_t offset(std::string_view part) const;
  /// `length` bytes from an offset.
  std::string_view part(size_t offset, size_t length) const;
  /// The index in sources() of the file in which an offset lies.
  size_t source_index(size_t offset) const;
  const Source& source_of(size_t offset) const { return *sources_[source_index(offset)]; }
  /// Throws InputError: "file:line:column: message".
  [[noreturn]] void fail(size_t offset, const std::string& message) const;
  [[noreturn]] void fail(std::string_view where, const std::string& message) const {
    fail(offset(where), message);
  }
  /// Whether the last line has no line end: the file may be cut short, or was typed so.
  bool ends_in_mid_line() const { return !text().empty() && text().back() != '\n'; }
  [[noreturn]] void fail_at_end(const std::string& message) const {
    fail(sources_.front()->base + text().size(), message);
  }
  /// "line 7", with the name of the file where `seen_from` lies in another one.
  std::string line_name(size_t offset, size_t seen_from) const;

  /// Reads a finite number; an empty field is 0 with `blank_is_zero`. Throws InputError.
  double real(std::string_view field, bool blank_is_zero = false) const;
  /// Reads a whole number. Throws InputError, in which `expected` says what it should be.
  long integer(std::string_view field, const std::string& expected) const;

 private:
  struct Including {
    size_t source, at;  // of the file that goes on, and where
  };
  const Source& current() const { return *sources_[current_]; }
  void open(Source source, bool binary);
  std::string include_trace(size_t offset) const;

  std::vector<std::shared_ptr<const Source>> sources_;
  std::vector<Including> open_;
  size_t current_ = 0, at_ = 0;
};


// The characters that stand for a coordinate in a field of a file. Internal.

/// Whether fields of this kind fill columns.
bool is_fixed_width(FieldKind kind);
/// Whether it is a field of a deck, whose width is bounded.
inline bool is_deck_field(FieldKind kind) { return width_of(kind) > 0; }
/// The characters that stand for `value`, and what a reader will make of them; empty where none do.
std::string format_field(double value, FieldKind kind, double& written);
/// `text` where the old field has its own: at the left, or in the last column.
std::string aligned(const std::string& text, const Field& field, std::string_view old);
/// A small-field GRID as two large-field lines.
std::string large_field_grid(std::string_view line, const std::array<std::string, 3>& coordinates,
                             const std::string& line_end);

}  // namespace batten
