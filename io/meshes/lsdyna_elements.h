// Elements and connections of LS-DYNA decks that are no shells. Internal.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/meshes/deck_mesh_builder.h"
#include "batten/io/meshes/lsdyna_lines.h"

namespace batten {

/// Reads *ELEMENT_SOLID, _BEAM, _DISCRETE, _SEATBELT, _MASS, _INERTIA, _PLOTEL,
/// *CONSTRAINED_NODAL_RIGID_BODY, _SPOTWELD, _RIVET, _INTERPOLATION. Of other elements, and those
/// with options that are not known, it counts the blocks.
class DynaElements {
 public:
  DynaElements(MeshSourceText& file, DynaLines& lines, DeckMeshBuilder& deck)
      : file_(file), lines_(lines), deck_(deck) {}

  /// Returns false for a keyword that is none of these.
  bool read(const DynaKeyword& keyword);
  /// Adds bodies that are given by sets of nodes to a finished mesh. `set`: the nodes of a set.
  void finish(TextMeshContent& mesh,
              const std::function<std::optional<std::vector<int>>(long set)>& set) const;

 private:
  struct Body {
    std::string name;
    long label, set, node;
  };
  bool plain(const DynaKeyword& keyword, const std::string& name, NonShellElement::Kind kind,
             int nodes, const std::set<std::string>& one_more_card);
  bool solids(const DynaKeyword& keyword);
  bool bodies(const DynaKeyword& keyword);
  bool pairs(const DynaKeyword& keyword, const std::string& name);
  bool interpolation(const DynaKeyword& keyword);
  void skip(int cards);

  MeshSourceText& file_;
  DynaLines& lines_;
  DeckMeshBuilder& deck_;
  std::vector<Body> bodies_;
};

}  // namespace batten
