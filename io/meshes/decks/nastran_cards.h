// SPDX-License-Identifier: MPL-2.0
// Cards of Nastran bulk data, including included files.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/decks/deck_mesh_builder.h"

namespace batten {

/// One line of a card: its name, whether it is large-field, and its values 1 to 8 (large field: 1
/// to 4; a free line may have more).
struct CardLine {
  explicit CardLine(std::string_view line);
  bool continues() const { return name.empty() || name[0] == '+' || name[0] == '*'; }
  int count() const { return count_; }
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

 private:
  int count_ = 8;
};

/// A card with all its lines.
struct BulkCard {
  std::string_view at(int i) const {
    return i < static_cast<int>(values.size()) ? values[i] : std::string_view();
  }
  /// Locations of the values `first` to `first` + 2.
  std::array<Field, 3> fields(const MeshSourceText& file, int first) const;
  /// The values `first` to `first` + 2; omitted ones are 0.
  Vec3 vector(const MeshSourceText& file, int first) const;

  std::vector<CardLine> lines;
  std::vector<std::string_view> values;
};

/// Reads the lines of a deck. INCLUDE is followed, also inside included files.
class NastranCards {
 public:
  explicit NastranCards(MeshSourceText& file) : file_(file) {}
  /// Reads the next line of the deck, of any kind.
  bool next(std::string_view& line);
  /// Reads the continuation line of a card, if there is one, skipping comments before it.
  bool next_line(std::optional<CardLine>& card);
  /// A card with its continuation lines.
  BulkCard whole(const CardLine& card);
  /// All values of a card and its continuation lines; 8 per small-field line.
  std::vector<std::string_view> values_of(const CardLine& card) { return whole(card).values; }

 private:
  bool follow(std::string_view line);
  MeshSourceText& file_;
};

/// Parses numbers, including ranges "A THRU B". The result is the first value that is neither, or
/// empty.
std::string_view read_ranges(std::span<const std::string_view> values,
                             std::vector<LabelRange>& ranges);

}  // namespace batten
