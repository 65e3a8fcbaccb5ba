// Connections of nodes in Abaqus and CalculiX input. Internal.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/decks/abaqus_lines.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"

namespace batten {

/// Collects *RIGID BODY, *MPC, *EQUATION, *COUPLING with *KINEMATIC or *DISTRIBUTING, *KINEMATIC
/// COUPLING, *DISTRIBUTING COUPLING; then finds their nodes.
class AbaqusConnections {
 public:
  AbaqusConnections(MeshSourceText& file, DeckMeshBuilder& deck) : file_(file), deck_(deck) {}

  /// Reads such a keyword with its data. Returns false for any other one.
  bool read(const Keyword& keyword, AbaqusLines& lines);
  /// The node of a coupling element, by the set that it is in.
  void add_coupling_node(std::string_view elset, long node);

  /// Indices of nodes, or faces, of a set by its name in upper case; nothing for an unknown one.
  using Sets = std::function<std::optional<std::vector<int>>(const std::string& name, bool faces)>;
  /// Adds what was read to a finished mesh. With `all_here`, throws InputError for a node or a set
  /// that is not there; otherwise it may be the assembly's, and the connection stays text.
  void finish(TextMeshContent& mesh, const Sets& sets, bool all_here) const;

 private:
  enum class By { Nodes, Faces, Surface };  // what a word names: a node or set, a set of faces, …
  struct Term {
    By by;
    std::string_view word;
    double weight = 1;
  };
  struct Connection {
    NonShellElement::Kind kind;
    std::string name;
    std::string_view where;
    std::vector<Term> first, rest;
    bool first_known = true;
  };
  struct Surface {
    bool of_nodes;
    std::vector<std::pair<std::string_view, std::string>> parts;  // a set and its side
  };
  class Finder;

  Connection& add(NonShellElement::Kind kind, const Keyword& keyword);
  void read_rigid_body(const Keyword& keyword, AbaqusLines& lines);
  void read_mpc(const Keyword& keyword, AbaqusLines& lines);
  void read_equation(const Keyword& keyword, AbaqusLines& lines);
  void read_coupling_data(Connection& connection, bool weights, AbaqusLines& lines);
  void read_surface(const Keyword& keyword, AbaqusLines& lines);

  MeshSourceText& file_;
  DeckMeshBuilder& deck_;
  std::vector<Connection> connections_;
  std::map<std::string, Surface> surfaces_;
  std::map<std::string, long> coupling_nodes_;
  Keyword coupling_;  // the last *COUPLING
};

}  // namespace batten
