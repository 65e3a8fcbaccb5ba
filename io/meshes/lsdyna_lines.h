// Keywords and cards of LS-DYNA decks, through included files. Internal.
#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

/// Columns of numbers, coordinates, and the fields of all other cards.
struct DynaWidths {
  int integer = 8, real = 16, card = 10;
  FieldKind kind = FieldKind::Dyna16, free_kind = FieldKind::DynaFree16;
  bool operator==(const DynaWidths&) const = default;
};

struct DynaKeyword {
  std::string name;
  DynaWidths widths;
  std::string_view line;
};

/// Parts of "A_B_C" after `first`; nothing when the name does not start with it.
std::optional<std::set<std::string>> options_after(const std::string& name,
                                                   const std::string& first);

/// Reads keywords and their cards. *INCLUDE is followed; *END in an included file ends it.
class DynaLines {
 public:
  explicit DynaLines(MeshSourceText& file) : file_(file) {}

  /// The next keyword; cards before it are passed over. Nothing at the end.
  std::optional<DynaKeyword> next_keyword();
  /// The next card of this keyword, which line() then is.
  bool next_card();
  /// The same, passing over blank lines.
  bool next_record();
  std::string_view line() const { return line_; }
  /// *END was found.
  bool ended() const { return ended_; }
  /// *INCLUDE_… that are not followed.
  long skipped_includes() const { return skipped_includes_; }

 private:
  bool next(std::string_view& line);
  void leave_file();
  DynaKeyword read_keyword();
  void read_format(const DynaKeyword& keyword, std::string_view options);
  bool include(const DynaKeyword& keyword);
  std::vector<std::string_view> rest_of_block();
  std::vector<std::pair<std::string, std::string_view>> names(bool transformed,
                                                              const DynaKeyword& keyword);
  void require_identity(std::span<const std::string_view> cards, const DynaKeyword& keyword) const;

  MeshSourceText& file_;
  DynaWidths widths_;
  std::vector<DynaWidths> outer_;  // of including files
  std::vector<std::string> folders_;
  std::string_view line_;
  bool ended_ = false;
  long skipped_includes_ = 0;
};

}  // namespace batten
