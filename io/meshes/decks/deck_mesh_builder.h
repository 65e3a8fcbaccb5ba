// Collects the nodes, shells and sets of a deck, in any order. Internal.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/text_mesh_content.h"

namespace batten {

/// Numbers in a deck that a set lists: first, first + step, … up to last. A single number is a
/// range of one.
struct LabelRange {
  long first, last, step = 1;
};

/// An element that is no shell, or a connection, by the numbers of its nodes; 0 for one that is left
/// out. `where`: a text in the file, for messages.
struct DeckElement {
  NonShellElement::Kind kind = NonShellElement::Kind::Other;
  std::string name;
  long label = 0;
  std::string_view where;
  std::vector<long> nodes;
  std::vector<double> weights;
};

/// Makes a mesh from the nodes and shells of a deck.
class DeckMeshBuilder {
 public:
  explicit DeckMeshBuilder(TextMeshContent& mesh) : mesh_(mesh) {}

  /// Adds a node. `where`: the text of its number in the file, for messages. `fields`: the places
  /// of its coordinates. Throws InputError for a number below 1.
  void add_node(long label, std::string_view where, const std::array<double, 3>& xyz,
                const std::array<Field, 3>& fields);
  /// Adds a shell with the name of its property, its corners and, in a face of second order, its
  /// middle nodes; 0 stands for one that the deck leaves out. Throws InputError for a number below
  /// 1.
  void add_shell(long label, std::string_view where, const std::string& property,
                 std::span<const long> corners, std::span<const long> middle = {});
  /// Adds an element that is no shell, and counts it.
  void add_element(DeckElement element);
  /// Numbers of points without a place, which elements may have as nodes.
  void add_scalar_points(LabelRange range) { scalar_points_.push_back(range); }
  /// Counts other elements by their name in the deck; `count` is 0 where they cannot be counted.
  void count_other_element(const std::string& name, long count = 1) {
    other_counts_[name] += count;
  }

  /// Makes the mesh of what was added. Throws InputError: a number twice, a node that is missing
  /// (`missing_hint` is put behind the message).
  void finish(const std::string& missing_hint = {});
  /// After finish(): the nodes, or faces, of the mesh with these numbers, as ascending indices.
  /// Numbers that are not in the mesh are passed over.
  std::vector<int> nodes_of(const std::vector<LabelRange>& ranges) const;
  std::vector<int> faces_of(const std::vector<LabelRange>& ranges) const;
  /// After finish(): adds what is beside the shells to the warnings: "12 CBAR, 3 RBE2; 2 nodes that
  /// no shell uses".
  void warn_about_other_elements();
  /// Offset of a node's number in the file, in bytes.
  size_t node_position(int node) const { return node_where_[node]; }

 private:
  struct Shell {
    size_t where, property;
    size_t first;  // its first node in nodes_
    std::uint8_t corners, middle;
  };
  void join_shell(const Shell& shell, long label, const std::string& missing_hint);
  void join_element(DeckElement& element, const std::string& missing_hint);
  bool scalar_point(long label) const;

  TextMeshContent& mesh_;
  std::vector<double> coordinates_;
  std::vector<long> node_labels_, shell_labels_, nodes_;
  std::vector<size_t> node_where_;
  std::vector<Shell> shells_;
  std::vector<std::string> properties_;
  std::map<std::string, size_t, std::less<>> property_index_;
  std::vector<DeckElement> elements_;
  std::vector<LabelRange> scalar_points_;
  std::map<std::string, long> other_counts_;
};

/// One line of a deck: values between commas where it has a comma (a free line), otherwise columns
/// of fixed width. A tab goes to the next multiple of 8 columns.
class DeckLine {
 public:
  /// `data`: the line as a part of the file's text, without its comment.
  explicit DeckLine(std::string_view data);
  bool free() const { return free_; }
  /// Value `index` of a free line, or the `width` columns from `column` of a fixed one, without
  /// blanks around it; empty where the line ends before. Both count from 0.
  std::string_view value(int index, int column, int width) const;
  /// Finds the fields of coordinates that follow one another from value `index` of a free line, or
  /// from `column` of a fixed one.
  void fields(const MeshSourceText& file, int index, int column, FieldKind fixed_kind,
              FieldKind free_kind, std::span<Field> result) const;

 private:
  size_t byte_of(int column) const;
  std::string_view data_;
  bool free_, tabs_;
  int columns_ = 0, count_ = 0;
  std::array<std::string_view, 24> values_;
};

}  // namespace batten
