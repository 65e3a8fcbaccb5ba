// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/nastran_directions.h"

#include <algorithm>

#include "batten/core/containers.h"

namespace batten {

using NumbersKind = RotatingCard::Numbers::Kind;

namespace {

const std::string kSprings = "springs and dampers along global axes";

}  // namespace

long NastranDirections::number(const BulkCard& card, int i) const {
  long value = 0;
  parse_integer(card.at(i), value);
  return value;
}

/// True for three components, false for a node number or nothing.
bool NastranDirections::is_vector(const BulkCard& card, int first) const {
  long node = 0;
  const bool single = card.at(first + 1).empty() && card.at(first + 2).empty();
  if (single && (card.at(first).empty() || parse_integer(card.at(first), node))) return false;
  double value = 0;
  for (int i = first; i < first + 3; ++i)
    if (!card.at(i).empty() && !parse_real(card.at(i), value)) return false;
  return true;
}

void NastranDirections::use(long system, std::vector<long> nodes) {
  auto& all = users_[system];
  all.insert(all.end(), nodes.begin(), nodes.end());
}

void NastranDirections::add_vector(const std::string& name, std::vector<long> nodes,
                                   const BulkCard& card, int first, bool local) {
  if (!is_vector(card, first)) return;
  Vectors vectors{name, std::move(nodes), {}, local};
  vectors.numbers.value = card.vector(file_, first);
  vectors.numbers.fields = card.fields(file_, first);
  if (!vectors.numbers.value.isZero(0)) vectors_.push_back(std::move(vectors));
}

void NastranDirections::read_system(const std::string& name, const BulkCard& card) {
  if (!name.starts_with("CORD2")) return;
  System system;
  const std::string label(card.at(0));
  system.in = number(card, 1);
  system.card.name = name + " " + label;
  system.card.use = RotatingCard::Use::Shared;
  const bool axes_only = name.back() == 'R';
  const Vec3 origin = card.vector(file_, 2);
  for (const int first : {2, 5, 8}) {
    if (axes_only && first == 2) continue;
    RotatingCard::Numbers numbers;
    numbers.fields = card.fields(file_, first);
    numbers.value = card.vector(file_, first);
    numbers.kind = axes_only ? NumbersKind::Arm : NumbersKind::Point;
    numbers.origin = origin;
    system.card.numbers.push_back(numbers);
  }
  systems_[number(card, 0)] = std::move(system);
}

/// Bars and beams: an orientation vector at `first`, a flag, pin flags, and the offsets of both
/// ends. Letters of the flag: B (vector in the basic system), O (offset in the element system).
void NastranDirections::read_bar(const std::string& name, const BulkCard& card, int first) {
  const std::string title = name + " " + std::string(card.at(0));
  const long a = number(card, 2), b = number(card, 3);
  std::string flag = upper(card.at(first + 3));
  if (flag.size() != 3 || flag.find_first_not_of("BGOE") != flag.npos) flag = "GGG";
  add_vector(title, {a, b}, card, first, flag[0] != 'B');
  if (name == "CBEND" || name == "CBEAM3") return;
  if (flag[1] == 'G') add_vector(title, {a}, card, 10, true);
  if (flag[2] == 'G') add_vector(title, {b}, card, 13, true);
}

void NastranDirections::read_bush(const std::string& name, const BulkCard& card) {
  const std::string title = name + " " + std::string(card.at(0));
  std::vector<long> nodes{number(card, 2)};
  if (const long b = number(card, 3); b > 0) nodes.push_back(b);
  if (!card.at(7).empty()) {
    const long system = number(card, 7);
    if (system > 0) return use(system, nodes);
    if (system == 0)
      global_[name + " in the basic system"].insert(global_[name + " in the basic system"].end(),
                                                    nodes.begin(), nodes.end());
    return;
  }
  add_vector(title, nodes, card, 4, true);
  if (name != "CBUSH" || card.at(9).empty()) return;
  if (const long in = number(card, 9); in == 0) add_vector(title, nodes, card, 10, false);
}

/// The offset of a mass, and its inertia about its own axes.
void NastranDirections::read_mass(const BulkCard& card) {
  const long node = number(card, 1), system = number(card, 2);
  if (system > 0) return use(system, {node});
  const std::string title = "CONM2 " + std::string(card.at(0));
  // System -1: the three numbers are a position.
  if (system == 0) add_vector(title, {node}, card, 4, false);
  if (system < 0 && is_vector(card, 4)) {
    add_vector(title, {node}, card, 4, false);
    if (!vectors_.empty() && vectors_.back().name == title)
      vectors_.back().numbers.kind = NumbersKind::Point;
  }
  bool inertia = false;
  for (int i = 8; i < 14; ++i) {
    double value = 0;
    inertia |= parse_real(card.at(i), value) && value != 0;
  }
  if (inertia && system <= 0) global_["CONM2 with inertia in the basic system"].push_back(node);
}

void NastranDirections::read_element(const std::string& name, const BulkCard& card) {
  if (name == "CBAR" || name == "CBEAM" || name == "CBEND") return read_bar(name, card, 4);
  if (name == "CBEAM3") return read_bar(name, card, 5);
  if (name == "CBUSH" || name == "CGAP") return read_bush(name, card);
  if (name == "CONM2") return read_mass(card);
  if (name == "CHEXA" || name == "CPENTA" || name == "CTETRA" || name == "CPYRAM")
    for (int i = 2; i < static_cast<int>(card.values.size()); ++i)
      if (const long node = number(card, i); node > 0)
        solid_nodes_[number(card, 1)].push_back(node);
  // Springs and dampers along the axes of the displacement systems of their nodes.
  if ((name.starts_with("CELAS") || name.starts_with("CDAMP")) && number(card, 2) > 0 &&
      number(card, 3) > 0)
    global_[kSprings + (" (" + name + ")")].push_back(number(card, 2));
}

void NastranDirections::read_material_angle(std::string_view element, std::string_view value,
                                            const Field& field, int face) {
  long system = 0;
  if (value.empty() || !parse_integer(value, system)) return;
  if (system > 0)
    faces_[system].push_back(face);
  else if (system == 0)
    material_directions_.push_back(
        {"the material angle of element " + std::string(element), field, face, Vec3::UnitX()});
}

bool NastranDirections::is_property_or_load(const std::string& name) {
  static const std::set<std::string, std::less<>> names{"PSOLID", "FORCE", "MOMENT"};
  return names.contains(name);
}

void NastranDirections::read_property_or_load(const std::string& name, const BulkCard& card) {
  if (name == "PSOLID") {
    if (card.at(2).empty()) return;
    system_of_property_[number(card, 0)] = number(card, 2);
  } else if (const long system = number(card, 2); system > 0) {
    use(system, {number(card, 1)});
  }
}

void NastranDirections::finish_systems(TextMeshContent& mesh, const std::vector<long>& systems) {
  std::set<long> of_positions;
  for (size_t i = 0; i < systems.size(); ++i) {
    if (systems[i] > 0) of_positions.insert(systems[i]);
    const auto own = displacement_.find(static_cast<int>(i));
    const long displacement = own == displacement_.end() ? default_displacement_ : own->second;
    if (displacement > 0) use(displacement, {mesh.node_labels.of(static_cast<int>(i))});
  }
  for (const auto& [property, system] : system_of_property_) {
    if (system > 0) use(system, solid_nodes_[property]);
    if (system == 0 && !solid_nodes_[property].empty()) {
      auto& all = global_["PSOLID " + std::to_string(property) + " in the basic system"];
      all.insert(all.end(), solid_nodes_[property].begin(), solid_nodes_[property].end());
    }
  }
  for (const auto& [label, system] : systems_) of_positions.insert(system.in);
  for (auto& [label, system] : systems_) {
    RotatingCard& card = system.card;
    for (const long node : users_[label])
      if (const auto index = mesh.node_labels.find(node)) card.nodes.push_back(*index);
    for (const int f : faces_[label])
      card.nodes.insert(card.nodes.end(), mesh.shells.face(f).begin(), mesh.shells.face(f).end());
    card.nodes = sorted_unique(std::move(card.nodes));
    if (card.nodes.empty()) continue;
    // Positions are given in the system, or the system in another one.
    if (of_positions.contains(label) || system.in != 0)
      mesh.global_directions.push_back(
          {card.name + ", in which nodes or systems are given", card.nodes});
    else
      mesh.rotating_cards.push_back(card);
  }
}

void NastranDirections::finish_vectors(TextMeshContent& mesh) {
  for (const Vectors& vectors : vectors_) {
    RotatingCard card{vectors.name, {}, {vectors.numbers}};
    for (const long label : vectors.nodes)
      if (const auto node = mesh.node_labels.find(label)) card.nodes.push_back(*node);
    if (card.nodes.empty()) continue;
    // A displacement system rotates itself, or is named.
    const auto own = displacement_.find(card.nodes[0]);
    const long system = own == displacement_.end() ? default_displacement_ : own->second;
    if (!vectors.local || system <= 0) mesh.rotating_cards.push_back(std::move(card));
  }
}

void NastranDirections::finish(TextMeshContent& mesh, const std::vector<long>& systems) {
  finish_systems(mesh, systems);
  finish_vectors(mesh);
  for (const auto& [name, labels] : global_) {
    GlobalDirections card{std::to_string(labels.size()) + " " + name, {}};
    for (const long label : labels)
      if (const auto node = mesh.node_labels.find(label);
          node && !(name.starts_with(kSprings) && displacement_.contains(*node)))
        card.nodes.push_back(*node);
    card.nodes = sorted_unique(std::move(card.nodes));
    mesh.global_directions.push_back(std::move(card));
  }
  mesh.material_directions = std::move(material_directions_);
}

}  // namespace batten
