// Cards of Nastran bulk data, through included files. Internal.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {

/// One line of a card: its name, whether its fields are large, the values 1 to 8 (large: 1 to 4).
struct CardLine {
  explicit CardLine(std::string_view line);
  bool continues() const { return name.empty() || name[0] == '+' || name[0] == '*'; }
  int count() const { return large ? 4 : 8; }
  int column(int field) const { return large ? 16 * field - 8 : 8 * field; }
  std::string_view value(int field) const {
    return cells.value(field, column(field), large ? 16 : 8);
  }
  void fields(const MeshSourceText& file, int first, std::span<Field> result) const {
    cells.fields(file, first, column(first), large ? FieldKind::Nastran16 : FieldKind::Nastran8,
                 FieldKind::NastranFree, result);
  }

  std::string_view data;
  DeckLine cells;
  std::string_view name;
  bool large = false;
};

/// Reads the lines of a deck. INCLUDE, also inside of included files, is followed.
class NastranCards {
 public:
  explicit NastranCards(MeshSourceText& file) : file_(file) {}
  /// The next line of the deck, whatever it is.
  bool next(std::string_view& line);
  /// The line that continues a card, if there is one; comments may stand between.
  bool next_line(std::optional<CardLine>& card);
  /// All values of a card and of the lines that continue it, 8 for each line of small fields.
  std::vector<std::string_view> values_of(const CardLine& card);

 private:
  bool follow(std::string_view line);
  MeshSourceText& file_;
};

/// Reads numbers of which "A THRU B" are many. Returns the first value that is something else, or
/// nothing.
std::string_view read_ranges(std::span<const std::string_view> values,
                             std::vector<LabelRange>& ranges);

}  // namespace batten
