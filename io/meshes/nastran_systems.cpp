#include "batten/io/meshes/nastran_systems.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/isize.h"

namespace batten {

void NastranSystems::read(const std::string& name, std::span<const std::string_view> values) {
  const auto at = [&](size_t i) { return i < values.size() ? values[i] : std::string_view(); };
  Definition definition;
  CoordinateSystemDefinition& plan = definition.plan;
  const char last = name.back();
  plan.kind = last == 'C'   ? CoordinateFrame::Kind::Cylindrical
              : last == 'S' ? CoordinateFrame::Kind::Spherical
                            : CoordinateFrame::Kind::Rectangular;
  if (name == "CORD1R" || name == "CORD1C" || name == "CORD1S") {
    // Two systems a card.
    for (size_t first = 0; first < values.size() && !at(first).empty(); first += 4) {
      for (size_t k = 0; k < 3; ++k)
        definition.nodes[k] = file_.integer(
            at(first + 1 + k).empty() ? at(first).substr(at(first).size()) : at(first + 1 + k),
            "a node number");
      add(definition, at(first));
    }
    return;
  }
  if (name == "CORD2R" || name == "CORD2C" || name == "CORD2S") {
    if (!at(1).empty()) definition.in = file_.integer(at(1), "a coordinate system");
    for (size_t i = 0; i < 9; ++i)
      plan.points[i / 3][static_cast<int>(i % 3)] = at(2 + i).empty() ? 0 : file_.real(at(2 + i));
  } else {
    plan.unsupported_name = name;
  }
  add(definition, at(0));
}

void NastranSystems::add(Definition definition, std::string_view label) {
  definition.plan.label = file_.integer(label, "the number of a coordinate system");
  definition.plan.where = file_.offset(label);
  definitions_.push_back(definition);
}

int NastranSystems::index_of(long label) const { return labels_.find(label).value_or(-1); }

void NastranSystems::resolve(const TextMeshContent& mesh, int index,
                             NodeCoordinateSystems& systems) const {
  const Definition& definition = definitions_[index];
  CoordinateSystemDefinition& plan = systems.plans[index];
  if (definition.in != 0) {
    plan.in = index_of(definition.in);
    if (plan.in < 0)
      file_.fail(plan.where, "found coordinate system " + std::to_string(definition.in) +
                                 ", in which system " + std::to_string(plan.label) +
                                 " is given, expected one that the deck defines");
  }
  for (size_t k = 0; k < 3; ++k) {
    if (definition.nodes[k] == 0) continue;
    const auto node = mesh.node_labels.find(definition.nodes[k]);
    if (!node)
      file_.fail(plan.where, "found node " + std::to_string(definition.nodes[k]) +
                                 " in coordinate system " + std::to_string(plan.label) +
                                 ", expected the number of a node");
    plan.nodes[k] = *node;
  }
}

void NastranSystems::transform_nodes(TextMeshContent& mesh, const DeckMeshBuilder& deck,
                                     const std::vector<long>& systems) {
  if (std::all_of(systems.begin(), systems.end(), [](long label) { return label == 0; })) return;
  std::vector<long> labels;
  NodeCoordinateSystems all;
  for (const Definition& definition : definitions_) {
    labels.push_back(definition.plan.label);
    all.plans.push_back(definition.plan);
  }
  labels_ = Labels(std::move(labels));
  if (const auto duplicate = labels_.duplicate())
    file_.fail(
        all.plans[duplicate->second].where,
        "found coordinate system " + std::to_string(all.plans[duplicate->second].label) +
            " a second time, the first is in " +
            file_.line_name(all.plans[duplicate->first].where, all.plans[duplicate->second].where));
  for (int i = 0; i < isize(systems); ++i) {
    all.of_node.push_back(systems[i] == 0 ? -1 : index_of(systems[i]));
    if (systems[i] != 0 && all.of_node.back() < 0)
      file_.fail(deck.node_position(i), "found node " + std::to_string(mesh.node_labels.of(i)) +
                                            " in coordinate system " + std::to_string(systems[i]) +
                                            ", expected one that the deck defines");
  }
  // Only what nodes use, and what that uses, has to be there.
  std::vector<char> seen(definitions_.size());
  std::vector<int> open;
  const auto use = [&](int index) {
    if (index >= 0 && !seen[index]) open.push_back(index);
    if (index >= 0) seen[index] = 1;
  };
  for (const int index : all.of_node) use(index);
  while (!open.empty()) {
    const int index = open.back();
    open.pop_back();
    resolve(mesh, index, all);
    use(all.plans[index].in);
  }
  nodes_to_global(mesh, std::move(all));
}

}  // namespace batten
