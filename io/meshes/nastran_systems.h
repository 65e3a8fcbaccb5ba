// Coordinate systems of Nastran decks. Internal.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {

/// Collects CORD1R, CORD1C, CORD1S, CORD2R, CORD2C, CORD2S; then places the nodes that are given in
/// them.
class NastranSystems {
 public:
  explicit NastranSystems(const MeshSourceText& file) : file_(file) {}
  /// Reads a card whose name begins with CORD.
  void read(const std::string& name, std::span<const std::string_view> values);
  /// Moves the nodes of a finished mesh from the numbers in their systems to their places.
  /// `systems`: the number of each node's system, 0 for the basic one. Throws InputError: a system
  /// that is not there, and what nodes_to_global() throws.
  void transform_nodes(TextMeshContent& mesh, const DeckMeshBuilder& deck,
                       const std::vector<long>& systems);

 private:
  struct Definition {
    CoordinateSystemDefinition plan;
    long in = 0;
    std::array<long, 3> nodes{};
  };
  void add(Definition definition, std::string_view label);
  void resolve(const TextMeshContent& mesh, int index, NodeCoordinateSystems& systems) const;
  int index_of(long label) const;

  const MeshSourceText& file_;
  std::vector<Definition> definitions_;
  Labels labels_;
};

}  // namespace batten
