// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/abaqus_directions.h"

#include <numeric>

#include "batten/core/containers.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"

namespace batten {

using NumbersKind = RotatingCard::Numbers::Kind;

void AbaqusDirections::note_users(const Keyword& keyword) {
  if (!keyword.has("ORIENTATION")) return;
  const bool elements = keyword.has("ELSET");
  users_.push_back({upper(keyword.value("ORIENTATION")),
                    keyword.value(elements ? "ELSET" : "REF NODE"), elements});
}

bool AbaqusDirections::read(const Keyword& keyword, AbaqusLines& lines, int system) {
  const std::string& name = keyword.name;
  if (name == "ORIENTATION")
    read_orientation(keyword, lines, system);
  else if (name == "TRANSFORM")
    read_transform(keyword, lines, system);
  else if (name == "BEAM SECTION" || name == "BEAM GENERAL SECTION")
    read_section(keyword, lines, system);
  else if (name == "NORMAL")
    read_normals(lines, system);
  else
    return false;
  return true;
}

/// Three numbers of a data line from value `first` on. Omitted numbers are 0.
RotatingCard::Numbers AbaqusDirections::three(std::string_view line, int first,
                                              NumbersKind kind) const {
  Numbers numbers;
  const DeckLine values(line);
  for (int c = 0; c < 3; ++c) numbers.value[c] = file_.real(values.value(first + c, 0, 0), true);
  values.fields(file_, first, 0, FieldKind::Abaqus, FieldKind::Abaqus, numbers.fields);
  numbers.kind = kind;
  return numbers;
}

void AbaqusDirections::read_normal(std::string_view line, int node, long label) {
  if (comma_values(line).size() < 5) return;
  Card card;
  card.card.name = "the normal of node " + std::to_string(label);
  card.card.nodes = {node};
  card.card.numbers = {three(line, 4, NumbersKind::Vector)};
  if (!card.card.numbers[0].value.isZero(0)) cards_.push_back(std::move(card));
}

void AbaqusDirections::read_orientation(const Keyword& keyword, AbaqusLines& lines, int system) {
  const std::string definition = upper(keyword.value("DEFINITION")),
                    type = upper(keyword.value("SYSTEM"));
  // Points that are nodes need no change.
  if (definition == "NODES" || definition == "OFFSET TO NODES" || !lines.next_data()) return;
  Card card;
  card.card.name = "*ORIENTATION " + std::string(keyword.value("NAME"));
  card.card.use = RotatingCard::Use::Shared;
  card.card.system = system;
  card.set = keyword.value("NAME");
  card.of_orientation = true;
  const std::string_view line = lines.line();
  double first = 0;
  // A distribution by its name.
  card.rewritten = parse_real(comma_values(line)[0], first) && !type.starts_with("Z");
  if (card.rewritten) {
    const bool axis = type.starts_with("C") || type.starts_with("S");
    const Vec3 origin = comma_values(line).size() > 6 ? three(line, 6, NumbersKind::Point).value
                                                      : Vec3(Vec3::Zero());
    for (const int at : {0, 3}) {
      card.card.numbers.push_back(three(line, at, axis ? NumbersKind::Point : NumbersKind::Arm));
      card.card.numbers.back().origin = origin;
    }
  }
  cards_.push_back(std::move(card));
}

void AbaqusDirections::read_transform(const Keyword& keyword, AbaqusLines& lines, int system) {
  const std::string type = upper(keyword.value("TYPE"));
  const bool axis = type == "C" || type == "S";
  if (!lines.next_data()) return;
  Card card;
  card.card.name = "*TRANSFORM of " + std::string(keyword.value("NSET"));
  card.card.use = RotatingCard::Use::Shared;
  card.card.system = system;
  card.set = keyword.value("NSET");
  for (const int at : {0, 3})
    card.card.numbers.push_back(
        three(lines.line(), at, axis ? NumbersKind::Point : NumbersKind::Arm));
  cards_.push_back(std::move(card));
}

/// The direction of a section follows the line of its dimensions.
void AbaqusDirections::read_section(const Keyword& keyword, AbaqusLines& lines, int system) {
  Card card;
  card.card.name = "*" + keyword.name + " of " + std::string(keyword.value("ELSET"));
  card.card.use = RotatingCard::Use::Shared;
  card.card.system = system;
  card.set = keyword.value("ELSET");
  card.of_elements = true;
  const std::string section = upper(keyword.value("SECTION"));
  // Round sections need no direction; sections given point by point have lines of their own.
  if (section == "CIRC" || section == "PIPE") return;
  card.rewritten =
      section != "ARBITRARY" && section != "MESHED" && lines.next_data() && lines.next_data();
  if (card.rewritten) card.card.numbers = {three(lines.line(), 0, NumbersKind::Vector)};
  if (!card.rewritten) card.card.name += " without a direction line";
  cards_.push_back(std::move(card));
}

void AbaqusDirections::read_normals(AbaqusLines& lines, int system) {
  while (lines.next_data()) {
    const std::vector<std::string_view> values = comma_values(lines.line());
    if (values.size() < 3) continue;
    Card card;
    card.card.name = "*NORMAL at " + std::string(values[1]);
    card.card.use = RotatingCard::Use::Shared;
    card.card.system = system;
    card.set = values[1];
    card.card.numbers = {three(lines.line(), 2, NumbersKind::Vector)};
    cards_.push_back(std::move(card));
  }
}

void AbaqusDirections::finish(TextMeshContent& mesh, const Nodes& nodes) const {
  std::vector<int> all(static_cast<size_t>(mesh.shells.node_count()));
  std::iota(all.begin(), all.end(), 0);
  for (const Card& found : cards_) {
    RotatingCard card = found.card;
    const auto add = [&](std::string_view set, bool elements) {
      if (const auto members = nodes(set, elements))
        card.nodes.insert(card.nodes.end(), members->begin(), members->end());
    };
    if (found.of_orientation) {
      for (const User& user : users_)
        if (user.orientation == upper(found.set)) add(user.set, user.elements);
    } else if (!found.set.empty()) {
      add(found.set, found.of_elements);
    } else {
      card.system = mesh.systems.of(card.nodes[0]);
    }
    card.nodes = sorted_unique(std::move(card.nodes));
    if (card.nodes.empty()) {
      card.use = RotatingCard::Use::Unknown;
      card.nodes = all;
    }
    if (found.rewritten)
      mesh.rotating_cards.push_back(std::move(card));
    else
      mesh.global_directions.push_back({card.name, card.nodes});
  }
}

}  // namespace batten
