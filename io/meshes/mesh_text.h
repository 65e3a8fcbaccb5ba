// Text of mesh files: read in one piece, gone through line by line, patched where coordinates are.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/io/meshes/mesh_content.h"

namespace batten {

/// How a coordinate is written.
enum class FieldKind : std::uint8_t {
  Free,         ///< as many characters as the double needs
  Nastran8,     ///< fixed columns
  Nastran16,    ///< fixed columns
  NastranFree,  ///< 16 characters at most
  Abaqus,       ///< 20 characters at most
  Dyna16,       ///< fixed columns
  Dyna20,       ///< fixed columns
  DynaFree16,   ///< 16 characters at most
  DynaFree20,   ///< 20 characters at most
  Float32,      ///< binary, little end first
  Float64,
  Float32Swapped,  ///< binary, big end first
  Float64Swapped,
};

/// Columns of a fixed field, or the most characters of a free one; 0: as many as it needs.
int width_of(FieldKind kind);

/// Where one coordinate of a node is in the file.
struct Field {
  size_t begin = 0;
  std::uint32_t length = 0;
  FieldKind kind = FieldKind::Free;
  /// The line ends before this field, or inside it while a later one is missing: it is written in
  /// full width, or with a comma before it, together with the others of its node that are open.
  bool open = false;
  std::uint16_t gap = 0;  ///< open: blanks to write before it
};

inline bool blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
std::string_view trimmed(std::string_view text);
std::string upper(std::string_view text);
/// The next word, which is cut off from `rest`; empty at the end.
std::string_view next_word(std::string_view& rest);

/// Number as Fortran reads it: a decimal point or none, exponents 1.5E3, 1.5D3, 1.5+3. False when
/// it is none or too large for a double.
bool parse_real(std::string_view field, double& value);
bool parse_integer(std::string_view field, long& value);

/// The number with at most `width` characters that is nearest to `value`, a decimal point always in
/// it: exponents as "+3" (Nastran) or "e3". Of the nearest the shortest.
std::string fixed_real(double value, int width, bool nastran);

class MeshText {
 public:
  /// Throws InputError: no file, a folder, empty, UTF-16 and zero bytes unless it is `binary`.
  explicit MeshText(const std::filesystem::path& path, bool binary = false);

  const std::string& text() const { return text_; }
  const std::filesystem::path& path() const { return path_; }
  /// The next line without its line end; false at the end of the file. A byte-order mark is passed
  /// over.
  bool next(std::string_view& line);
  /// Where next() goes on.
  size_t position() const { return at_; }
  void go_to(size_t position) { at_ = position; }

  size_t offset(std::string_view part) const {
    return static_cast<size_t>(part.data() - text_.data());
  }
  /// "file:line:column: message".
  [[noreturn]] void fail(size_t offset, const std::string& message) const;
  [[noreturn]] void fail(std::string_view where, const std::string& message) const {
    fail(offset(where), message);
  }
  [[noreturn]] void fail_at_end(const std::string& message) const { fail(text_.size(), message); }
  long line_of(size_t offset) const;

  /// A finite number. `blank_is_zero` for formats that say so.
  double real(std::string_view field, bool blank_is_zero = false) const;
  long integer(std::string_view field, const std::string& expected) const;

 private:
  std::filesystem::path path_;
  std::string text_;
  size_t at_ = 0;
};

/// Content whose coordinates are bytes of the file.
struct TextMesh : MeshContent {
  explicit TextMesh(MeshText file) : file(std::move(file)) {}
  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions& options) const override;

  MeshText file;
  std::vector<std::array<Field, 3>> fields;  ///< of each node, in the order of the file
};

}  // namespace batten
