// The text of a mesh file. It is read in one piece and parsed line by line; coordinates are
// replaced in it. Internal.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/meshes/mesh_content.h"

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

/// The text of a file, and a position in it from which lines are read.
class MeshText {
 public:
  /// Reads the file. Throws InputError: no file, a folder, an empty file and, unless it is
  /// `binary`, UTF-16 text or zero bytes.
  explicit MeshText(const std::filesystem::path& path, bool binary = false);

  const std::string& text() const { return text_; }
  const std::filesystem::path& path() const { return path_; }
  /// Reads the next line, without its line end. Returns false at the end of the file. A byte-order
  /// mark is passed over.
  bool next(std::string_view& line);
  /// Offset, in bytes, of the line that next() reads.
  size_t position() const { return at_; }
  void go_to(size_t position) { at_ = position; }

  /// Offset of a part of text() in it, in bytes.
  size_t offset(std::string_view part) const {
    return static_cast<size_t>(part.data() - text_.data());
  }
  /// Throws InputError: "file:line:column: message".
  [[noreturn]] void fail(size_t offset, const std::string& message) const;
  [[noreturn]] void fail(std::string_view where, const std::string& message) const {
    fail(offset(where), message);
  }
  /// Whether the last line has no line end: the file may be cut short, or was typed so.
  bool ends_in_mid_line() const { return !text_.empty() && text_.back() != '\n'; }
  [[noreturn]] void fail_at_end(const std::string& message) const { fail(text_.size(), message); }
  long line_of(size_t offset) const;

  /// Reads a finite number; an empty field is 0 with `blank_is_zero`. Throws InputError.
  double real(std::string_view field, bool blank_is_zero = false) const;
  /// Reads a whole number. Throws InputError, in which `expected` says what it should be.
  long integer(std::string_view field, const std::string& expected) const;

 private:
  std::filesystem::path path_;
  std::string text_;
  size_t at_ = 0;
};

/// The content of a mesh file in which coordinates are replaced field by field.
struct TextMesh : MeshContent {
  explicit TextMesh(MeshText file) : file(std::move(file)) {}
  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions& options) const override;

  MeshText file;
  std::vector<std::array<Field, 3>> fields;  ///< the fields of each node's x, y, z
};

}  // namespace batten
