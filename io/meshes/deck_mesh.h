// Nodes, shells and sets of a deck, collected in whatever order they come.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/mesh_text.h"

namespace batten {

/// What a set of a deck lists, by the deck's numbers: single ones are ranges of one.
struct LabelRange {
  long first, last, step = 1;
};

class DeckMesh {
 public:
  explicit DeckMesh(TextMesh& mesh) : mesh_(mesh) {}

  /// `where`: the field of its number.
  void add_node(long label, std::string_view where, const std::array<double, 3>& xyz,
                const std::array<Field, 3>& fields);
  /// Corners, then as many middle nodes or, where a deck leaves them out, zeros.
  void add_shell(long label, std::string_view where, const std::string& property,
                 std::span<const long> corners, std::span<const long> middle = {});
  /// Counts other elements by the name that the deck has for them; 0 of it where they cannot be
  /// counted.
  void add_other(const std::string& name, long count = 1) { others_[name] += count; }

  /// Joins everything into the mesh. Throws InputError: a number twice, a node that is missing
  /// (`missing_hint` follows the message). Sets refer to the mesh after that.
  void finish(const std::string& missing_hint = {});
  /// Ascending indices; numbers that are not in the mesh are passed over.
  std::vector<int> nodes_of(const std::vector<LabelRange>& ranges) const;
  std::vector<int> faces_of(const std::vector<LabelRange>& ranges) const;
  /// After finish(): "12 CBAR, 3 RBE2 `what` are carried along as text; …".
  void warn_of_others(const std::string& what);
  /// Position of a node's number in the file.
  size_t node_position(int node) const { return node_where_[node]; }

 private:
  struct Shell {
    size_t where, property;
    size_t first;  // of nodes_
    std::uint8_t corners, middle;
  };
  void join_shell(const Shell& shell, long label, const std::string& missing_hint);

  TextMesh& mesh_;
  std::vector<double> coordinates_;
  std::vector<long> node_labels_, shell_labels_, nodes_;
  std::vector<size_t> node_where_;
  std::vector<Shell> shells_;
  std::vector<std::string> properties_;
  std::map<std::string, size_t, std::less<>> property_index_;
  std::map<std::string, long> others_;
};

/// A line as columns of fixed width or as values between commas; lines of both kinds may follow one
/// another. Tabs go to the next multiple of 8 columns.
class DeckLine {
 public:
  /// `data`: a part of the file, without comment.
  explicit DeckLine(std::string_view data);
  bool free() const { return free_; }
  /// Value `index` of a free line, or the columns of a fixed one, without blanks around it; empty
  /// where the line ends before.
  std::string_view value(int index, int column, int width) const;
  /// Where coordinates are that follow one another from value `index`, or from `column`.
  void fields(const MeshText& file, int index, int column, FieldKind fixed_kind,
              FieldKind free_kind, std::span<Field> result) const;

 private:
  size_t byte_of(int column) const;
  std::string_view data_;
  bool free_, tabs_;
  int columns_ = 0, count_ = 0;
  std::array<std::string_view, 24> values_;
};

}  // namespace batten
