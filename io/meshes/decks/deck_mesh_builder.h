// SPDX-License-Identifier: MPL-2.0
// Builds a mesh from the nodes, elements and sets of a deck, which may come in any order.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/text_mesh_content.h"

namespace batten {

/// A range of numbers in a deck: first, first + step, …, up to last. A single number is a range of
/// length one.
struct LabelRange {
  long first, last, step = 1;
};

/// Ascending indices of the labels in the ranges; unknown numbers are skipped.
std::vector<int> indices_of(const Labels& labels, const std::vector<LabelRange>& ranges);

/// A non-shell element or a connection, defined by its node numbers; 0 stands for an omitted node.
/// `where` is a view into the file's text, for messages.
struct DeckElement {
  NonShellElement::Kind kind = NonShellElement::Kind::Other;
  std::string name;
  long label = 0;
  std::string_view where;
  std::vector<long> nodes;
  std::vector<double> weights;
};

/// Builds a mesh from the nodes and shells of a deck.
class DeckMeshBuilder {
 public:
  explicit DeckMeshBuilder(TextMeshContent& mesh) : mesh_(mesh) {}

  /// Adds a node. `where`: its number in the file's text, for messages; `fields`: locations of its
  /// coordinates. Throws InputError for a number below 1.
  void add_node(long label, std::string_view where, const std::array<double, 3>& xyz,
                const std::array<Field, 3>& fields);
  /// Adds a shell with the name of its property, its corners and, for second-order faces, its
  /// mid-side nodes; 0 stands for a mid-side node that the deck omits. Throws InputError for a
  /// number below 1.
  void add_shell(long label, std::string_view where, const std::string& property,
                 std::span<const long> corners, std::span<const long> middle = {});
  /// Adds a non-shell element and counts it.
  void add_element(DeckElement element);
  /// Adds a card whose numbers rotate with the given node numbers; none: nobody knows to which nodes
  /// it belongs.
  void add_rotating(RotatingCard card, std::vector<long> nodes = {}) {
    rotating_.push_back({std::move(card), std::move(nodes)});
  }
  /// Adds a card with global directions that Batten cannot rewrite, at the given node numbers; none:
  /// anywhere in the mesh.
  void add_global_directions(const std::string& name, const std::vector<long>& nodes = {}) {
    auto& all = global_directions_[name];
    all.insert(all.end(), nodes.begin(), nodes.end());
  }
  /// Declares scalar points: numbers without a position that elements may use as nodes.
  void add_scalar_points(LabelRange range) { scalar_points_.push_back(range); }
  /// Adds a tie after finish(). `faces`: shells that the nodes follow; empty: all shells. Nodes of
  /// these shells are omitted.
  void add_tie(const std::string& name, std::vector<int> nodes, std::vector<int> faces,
               double reach = 0);
  /// The shells of the property with this name; call after finish().
  std::vector<int> faces_of_property(const std::string& name) const;
  /// The shells whose corners are all among the nodes; call after finish().
  std::vector<int> faces_among(const std::vector<int>& nodes) const;
  /// The nodes of these shells; call after finish().
  std::vector<int> nodes_of_faces(const std::vector<int>& faces) const;
  /// Counts elements that are not read, by their name in the deck; `count` is 0 if they cannot be
  /// counted.
  void count_other_element(const std::string& name, long count = 1) {
    other_counts_[name] += count;
  }

  /// Builds the mesh. Throws InputError for a duplicate number or a missing node; `missing_hint` is
  /// appended to the latter message.
  void finish(const std::string& missing_hint = {});
  /// Ascending indices of the nodes (or faces) with these numbers; call after finish(). Unknown
  /// numbers are skipped. Throws InputError if the sets and elements have together more nodes and
  /// faces than a deck of this size can reasonably have: a few ranges may name any number of them.
  std::vector<int> nodes_of(const std::vector<LabelRange>& ranges);
  std::vector<int> faces_of(const std::vector<LabelRange>& ranges);
  /// Adds a warning about everything that is not a shell, such as "12 CBAR, 3 RBE2; 2 nodes that no
  /// shell uses". Call after finish().
  void warn_about_other_elements();
  /// Byte offset of a node's number in the file.
  size_t node_position(int node) const { return node_where_[node]; }

 private:
  struct Shell {
    size_t where, property;
    size_t first;  // index in nodes_ of its first node
    std::uint8_t corners, middle;
  };
  void join_shell(const Shell& shell, long label, const std::string& missing_hint);
  void join_element(DeckElement& element, const std::string& missing_hint);
  void join_directions();
  std::vector<int> known_nodes(const std::vector<long>& labels) const;
  bool scalar_point(long label) const;
  size_t text_size() const;
  void count_members(size_t count);
  void count_members(const std::vector<LabelRange>& ranges, const Labels& labels);

  TextMeshContent& mesh_;
  size_t members_ = 0;  // nodes and faces of sets and elements
  std::vector<double> coordinates_;
  std::vector<long> node_labels_, shell_labels_, nodes_;
  std::vector<size_t> node_where_;
  std::vector<Shell> shells_;
  std::vector<std::string> properties_;
  std::map<std::string, size_t, std::less<>> property_index_;
  std::vector<DeckElement> elements_;
  struct Rotating {
    RotatingCard card;
    std::vector<long> nodes;
  };
  std::vector<Rotating> rotating_;
  std::map<std::string, std::vector<long>> global_directions_;
  std::vector<LabelRange> scalar_points_;
  std::map<std::string, long> other_counts_;
};

/// One line of a deck. A line with a comma is free-format (values between commas), any other line
/// has fixed columns. A tab advances to the next multiple of 8 columns.
class DeckLine {
 public:
  /// `data`: the line as a view into the file's text, without its comment.
  explicit DeckLine(std::string_view data);
  /// True if values are separated by commas.
  bool free() const { return free_; }
  /// Number of values of a free line.
  int count() const { return count_; }
  /// Value `index` of a free line, or the `width` columns from `column` of a fixed line, without
  /// surrounding blanks. Empty if the line ends earlier. Both arguments are 0-based.
  std::string_view value(int index, int column, int width) const;
  /// Determines the fields of consecutive coordinates, starting at value `index` of a free line, or
  /// at `column` of a fixed line.
  void fields(const MeshSourceText& file, int index, int column, FieldKind fixed_kind,
              FieldKind free_kind, std::span<Field> result) const;

 private:
  size_t byte_of(int column) const;
  std::string_view at(int index) const {
    const auto inside = static_cast<int>(values_.size());
    return index < inside ? values_[index] : more_[index - inside];
  }
  std::string_view data_;
  bool free_, tabs_;
  int columns_ = 0, count_ = 0;
  std::array<std::string_view, 24> values_;
  std::vector<std::string_view> more_;  // values of long free lines beyond the array
};

}  // namespace batten
