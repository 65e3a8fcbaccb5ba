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
/// COUPLING, *DISTRIBUTING COUPLING, *TIE, *CONTACT PAIR with TIED, and *SHELL TO SOLID COUPLING. It
/// collects the cards first, and resolves their nodes in
/// finish().
class AbaqusConnections {
 public:
  AbaqusConnections(MeshSourceText& file, DeckMeshBuilder& deck) : file_(file), deck_(deck) {}

  /// Reads a supported keyword with its data lines. Returns false for all other keywords.
  bool read(const Keyword& keyword, AbaqusLines& lines);
  /// Sets the shift of the node numbers of the assembly level, for the following keywords.
  void set_shift(long shift) { shift_ = shift; }
  /// Registers the node of a coupling element (DCOUP) under the element set that contains it.
  void add_coupling_node(std::string_view elset, long node);

  /// Looks up the node (or face) indices of a set by its upper-case name; empty for an unknown set.
  using Sets = std::function<std::optional<std::vector<int>>(const std::string& name, bool faces)>;
  /// Finds the elements of an element set, as indices into TextMeshContent::other_elements.
  using Others = std::function<std::vector<int>(const std::string& name)>;
  /// Adds the connections to a finished mesh. With `all_here`, an unknown node or set throws
  /// InputError. Without it, the node or set may belong to the assembly, and the connection stays
  /// text.
  void finish(TextMeshContent& mesh, const Sets& sets, const Others& others, bool all_here) const;

 private:
  // The kind of an entity: a node or a node set, a face or a face set, a surface.
  enum class By { Nodes, Faces, Surface };
  struct Term {
    By by;
    std::string_view entity;  // its number or name
    double weight = 1;
    long shift = 0;  // added to its number: nodes of the assembly
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
  struct Tie {
    std::string name;
    std::string_view first, second;  // surfaces
    double reach;
  };
  class Finder;
  void read_ties(const Keyword& keyword, AbaqusLines& lines);
  void finish_ties(TextMeshContent& mesh, const Sets& sets, const Others& others) const;

  Connection& add(NonShellElement::Kind kind, const Keyword& keyword);
  void read_rigid_body(const Keyword& keyword, AbaqusLines& lines);
  void read_mpc(const Keyword& keyword, AbaqusLines& lines);
  void read_equation(const Keyword& keyword, AbaqusLines& lines);
  void read_coupling_data(Connection& connection, bool weights, AbaqusLines& lines);
  void read_surface(const Keyword& keyword, AbaqusLines& lines);

  MeshSourceText& file_;
  DeckMeshBuilder& deck_;
  std::vector<Connection> connections_;
  std::vector<Tie> ties_;
  std::vector<std::string> unread_;  // sentences
  std::map<std::string, Surface> surfaces_;
  std::map<std::string, long> coupling_nodes_;
  Keyword coupling_;  // the most recent *COUPLING
  long shift_ = 0;
};

}  // namespace batten
