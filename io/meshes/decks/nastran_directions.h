// SPDX-License-Identifier: MPL-2.0
// Directions in Nastran bulk data: orientation vectors, offsets, material directions, coordinate
// systems.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/decks/nastran_cards.h"

namespace batten {

/// Collects the vectors of bars, beams, bushes, gaps and masses, the material systems of shells, and
/// the coordinate systems CORD2R, CORD2C and CORD2S that only give directions. A system rotates with
/// the nodes and elements that use it. Cards that cannot be rewritten are listed in
/// TextMeshContent::global_directions.
class NastranDirections {
 public:
  explicit NastranDirections(const MeshSourceText& file) : file_(file) {}

  void set_default_displacement_system(long system) { default_displacement_ = system; }
  /// `node`: index of a node; `system`: system of its displacements.
  void add_displacement_system(int node, long system) { displacement_[node] = system; }
  void read_system(const std::string& name, const BulkCard& card);
  void read_element(const std::string& name, const BulkCard& card);
  /// The material angle (real) or material system (integer) of shell `face`.
  void read_material_angle(std::string_view element, std::string_view value, const Field& field,
                           int face);
  static bool is_property_or_load(const std::string& name);
  void read_property_or_load(const std::string& name, const BulkCard& card);
  /// Adds the cards to a finished mesh. `systems`: system of each node's coordinates.
  void finish(TextMeshContent& mesh, const std::vector<long>& systems);

 private:
  struct Vectors {
    std::string name;
    std::vector<long> nodes;
    RotatingCard::Numbers numbers;
    bool local = false;  // in the displacement system of the first node
  };
  struct System {
    RotatingCard card;
    long in = 0;
  };
  void add_vector(const std::string& name, std::vector<long> nodes, const BulkCard& card, int first,
                  bool local);
  void read_bar(const std::string& name, const BulkCard& card, int first);
  void read_bush(const std::string& name, const BulkCard& card);
  void read_mass(const BulkCard& card);
  long number(const BulkCard& card, int i) const;
  bool is_vector(const BulkCard& card, int first) const;
  void use(long system, std::vector<long> nodes);
  void finish_systems(TextMeshContent& mesh, const std::vector<long>& systems);
  void finish_vectors(TextMeshContent& mesh);

  const MeshSourceText& file_;
  long default_displacement_ = 0;
  std::map<int, long> displacement_;
  std::map<long, System> systems_;
  std::map<long, std::vector<long>> users_;        // node numbers of each system
  std::map<long, std::vector<int>> faces_;         // shells whose material has the system
  std::map<long, long> system_of_property_;        // of solids
  std::map<long, std::vector<long>> solid_nodes_;  // of each property
  std::vector<Vectors> vectors_;
  std::vector<MaterialDirection> material_directions_;
  std::map<std::string, std::vector<long>> global_;  // cards in the basic system
};

}  // namespace batten
