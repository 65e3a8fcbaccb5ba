// SPDX-License-Identifier: MPL-2.0
// Directions in Abaqus and CalculiX input: local axes of elements and nodes, section directions,
// nodal normals.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/meshes/decks/abaqus_lines.h"
#include "batten/io/meshes/text_mesh_content.h"

namespace batten {

/// Reader for *ORIENTATION, *TRANSFORM, *NORMAL, the direction lines of *BEAM SECTION and *BEAM
/// GENERAL SECTION, and the normals of *NODE. It collects the cards first, and resolves their nodes
/// in finish().
class AbaqusDirections {
 public:
  explicit AbaqusDirections(MeshSourceText& file) : file_(file) {}

  /// Notes which elements or nodes use an orientation. Reads no line.
  void note_users(const Keyword& keyword);
  /// Reads a supported keyword with its data lines. `system`: coordinate system of the part; -1:
  /// global. Returns false for all other keywords.
  bool read(const Keyword& keyword, AbaqusLines& lines, int system);
  /// Reads the normal of a node, the values 4 to 6 of its line.
  void read_normal(std::string_view line, int node, long label);

  /// Finds nodes by name. `elements`: the name is that of an element set, whose nodes are returned.
  /// Empty for unknown names.
  using Nodes =
      std::function<std::optional<std::vector<int>>(std::string_view name, bool elements)>;
  /// Adds the cards to a finished mesh.
  void finish(TextMeshContent& mesh, const Nodes& nodes) const;

 private:
  struct Card {
    RotatingCard card;
    std::string_view set;  // of nodes or elements
    bool of_elements = false, of_orientation = false;
    bool rewritten = true;  // false: the card is only named
  };
  struct User {
    std::string orientation;
    std::string_view set;
    bool elements;
  };
  using Numbers = RotatingCard::Numbers;
  Numbers three(std::string_view line, int first, Numbers::Kind kind) const;
  void read_orientation(const Keyword& keyword, AbaqusLines& lines, int system);
  void read_transform(const Keyword& keyword, AbaqusLines& lines, int system);
  void read_section(const Keyword& keyword, AbaqusLines& lines, int system);
  void read_normals(AbaqusLines& lines, int system);

  MeshSourceText& file_;
  std::vector<Card> cards_;
  std::vector<User> users_;
};

}  // namespace batten
