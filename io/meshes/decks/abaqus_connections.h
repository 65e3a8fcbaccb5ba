// SPDX-License-Identifier: MPL-2.0
// Rigid bodies, multi-point constraints, equations and couplings of Abaqus and CalculiX input.
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

/// Reader for *RIGID BODY, *MPC, *EQUATION, *COUPLING with *KINEMATIC or *DISTRIBUTING, *KINEMATIC
/// COUPLING and *DISTRIBUTING COUPLING. It collects the cards first, and resolves their nodes in
/// finish().
class AbaqusConnections {
 public:
  AbaqusConnections(MeshSourceText& file, DeckMeshBuilder& deck) : file_(file), deck_(deck) {}

  /// Reads a supported keyword with its data lines. Returns false for all other keywords.
  bool read(const Keyword& keyword, AbaqusLines& lines);
  /// Registers the node of a coupling element (DCOUP) under the element set that contains it.
  void add_coupling_node(std::string_view elset, long node);

  /// Looks up the node (or face) indices of a set by its upper-case name; empty for an unknown set.
  using Sets = std::function<std::optional<std::vector<int>>(const std::string& name, bool faces)>;
  /// Adds the connections to a finished mesh. With `all_here`, an unknown node or set throws
  /// InputError. Without it, the node or set may belong to the assembly, and the connection stays
  /// text.
  void finish(TextMeshContent& mesh, const Sets& sets, bool all_here) const;

 private:
  // The kind of an entity: a node or a node set, a face or a face set, a surface.
  enum class By { Nodes, Faces, Surface };
  struct Term {
    By by;
    std::string_view entity;  // its number or name
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
  Keyword coupling_;  // the most recent *COUPLING
};

}  // namespace batten
