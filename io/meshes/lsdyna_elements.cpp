#include "batten/io/meshes/lsdyna_elements.h"

#include <algorithm>

namespace batten {
namespace {

using Kind = NonShellElement::Kind;

/// The fields of one card, all of the same width.
struct Card {
  Card(std::string_view line, int width) : line(line), width(width) {}
  std::string_view at(int i) const { return line.value(i, i * width, width); }
  long number(const MeshSourceText& file, int i, const char* expected = "a node number") const {
    return at(i).empty() ? 0 : file.integer(at(i), expected);
  }
  DeckLine line;
  int width;
};

/// Without repeated nodes: solids with fewer than 8 corners repeat some.
void add_once(std::vector<long>& nodes, long node) {
  if (node != 0 && std::find(nodes.begin(), nodes.end(), node) == nodes.end())
    nodes.push_back(node);
}

bool only(const std::set<std::string>& options, const std::set<std::string>& known) {
  return std::includes(known.begin(), known.end(), options.begin(), options.end());
}

}  // namespace

bool DynaElements::read(const DynaKeyword& keyword) {
  const std::set<std::string> beam_cards{"ELBOW", "OFFSET",  "ORIENTATION", "PID",    "SCALAR",
                                         "SCALR", "SECTION", "THICKNESS",   "WARPAGE"};
  if (plain(keyword, "ELEMENT_BEAM", Kind::Beam, 3, beam_cards) ||
      plain(keyword, "ELEMENT_DISCRETE", Kind::Bush, 2, {"LCO"}) ||
      plain(keyword, "ELEMENT_SEATBELT", Kind::Beam, 2, {}) || solids(keyword) || bodies(keyword) ||
      pairs(keyword, "ELEMENT_PLOTEL") || pairs(keyword, "ELEMENT_MASS") ||
      pairs(keyword, "ELEMENT_INERTIA") || pairs(keyword, "CONSTRAINED_SPOTWELD") ||
      pairs(keyword, "CONSTRAINED_RIVET") || interpolation(keyword))
    return true;
  if (!keyword.name.starts_with("ELEMENT_") &&
      !keyword.name.starts_with("CONSTRAINED_NODAL_RIGID_BODY"))
    return false;
  deck_.count_other_element("*" + keyword.name, 0);
  return true;
}

void DynaElements::skip(int cards) {
  while (cards-- > 0 && lines_.next_card()) {
  }
}

/// Number, part, nodes: one card, and one for each option.
bool DynaElements::plain(const DynaKeyword& keyword, const std::string& name, Kind kind, int nodes,
                         const std::set<std::string>& one_more_card) {
  const auto options = options_after(keyword.name, name);
  if (!options || !only(*options, one_more_card)) return false;
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.integer);
    DeckElement element{kind, "*" + name, 0, card.at(0), {}, {}};
    element.label = file_.integer(card.at(0), "an element number");
    for (int i = 0; i < nodes; ++i) element.nodes.push_back(card.number(file_, 2 + i));
    deck_.add_element(std::move(element));
    skip(static_cast<int>(options->size()));
  }
  return true;
}

/// The nodes stand behind the part, or in cards of their own.
bool DynaElements::solids(const DynaKeyword& keyword) {
  const auto options = options_after(keyword.name, "ELEMENT_SOLID");
  if (!options || !only(*options, {"H20", "ORTHO"})) return false;
  const bool second_order = options->contains("H20");
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.integer);
    DeckElement element{Kind::Solid, "*ELEMENT_SOLID", 0, card.at(0), {}, {}};
    element.label = file_.integer(card.at(0), "an element number");
    if (!card.at(2).empty()) {
      for (int i = 2; i < 10; ++i) add_once(element.nodes, card.number(file_, i));
    } else {
      for (int more = second_order ? 2 : 1; more > 0; --more) {
        if (!lines_.next_card()) file_.fail(element.where, "found a solid without its nodes");
        const Card nodes(lines_.line(), keyword.widths.integer);
        for (int i = 0; i < 10; ++i) add_once(element.nodes, nodes.number(file_, i));
      }
    }
    deck_.add_element(std::move(element));
    skip(options->contains("ORTHO") ? 2 : 0);
  }
  return true;
}

bool DynaElements::bodies(const DynaKeyword& keyword) {
  const auto options = options_after(keyword.name, "CONSTRAINED_NODAL_RIGID_BODY");
  if (!options || !only(*options, {"INERTIA", "OVERRIDE", "SPC", "TITLE"})) return false;
  const bool titled = options->contains("TITLE");
  while (lines_.next_record()) {
    if (titled && !lines_.next_record()) break;
    const Card card(lines_.line(), keyword.widths.card);
    Body body{"*CONSTRAINED_NODAL_RIGID_BODY", card.number(file_, 0, "a part number"),
              card.number(file_, 2, "the number of a set"), card.number(file_, 3)};
    if (body.set == 0) body.set = body.label;
    deck_.count_other_element(body.name);
    bodies_.push_back(body);
    // Options have cards of their own.
    if (options->size() > (titled ? 1u : 0u)) break;
  }
  return true;
}

/// Elements whose card has a layout of its own, and joints of two nodes.
bool DynaElements::pairs(const DynaKeyword& keyword, const std::string& name) {
  auto options = options_after(keyword.name, name);
  const bool joint = name.starts_with("CONSTRAINED_");
  if (!options || !only(*options, joint ? std::set<std::string>{"FILTERED", "FORCE", "ID"}
                                  : name == "ELEMENT_INERTIA" ? std::set<std::string>{"OFFSET"}
                                                              : std::set<std::string>{}))
    return false;
  while (lines_.next_record()) {
    DeckElement element{Kind::Rigid, "*" + name, 0, {}, {}, {}};
    if (joint && options->contains("ID")) {
      element.label = Card(lines_.line(), keyword.widths.card).number(file_, 0, "a number");
      if (!lines_.next_record()) break;
    }
    const Card card(lines_.line(), joint ? keyword.widths.card : keyword.widths.integer);
    element.where = card.at(0);
    if (joint) {
      element.nodes = {card.number(file_, 0), card.number(file_, 1)};
    } else {
      element.kind = name == "ELEMENT_PLOTEL" ? Kind::Other : Kind::Mass;
      element.label = file_.integer(card.at(0), "an element number");
      element.nodes = {card.number(file_, 1)};
      if (name == "ELEMENT_PLOTEL") element.nodes.push_back(card.number(file_, 2));
    }
    deck_.add_element(std::move(element));
    if (name == "ELEMENT_INERTIA") skip(1 + static_cast<int>(options->size()));
    if (joint && options->contains("FILTERED")) skip(1);
  }
  return true;
}

bool DynaElements::interpolation(const DynaKeyword& keyword) {
  if (keyword.name != "CONSTRAINED_INTERPOLATION") return false;
  if (!lines_.next_record()) return true;
  const Card first(lines_.line(), keyword.widths.card);
  if (first.number(file_, 4, "0 or 1") != 0) {  // nodes by sets
    deck_.count_other_element("*" + keyword.name);
    return true;
  }
  DeckElement element{Kind::Interpolation, "*" + keyword.name, 0, first.at(0), {}, {}};
  element.label = first.number(file_, 0, "a number");
  element.nodes.push_back(first.number(file_, 1));
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.card);
    const double weight = file_.real(card.at(2), true);
    element.nodes.push_back(card.number(file_, 0));
    element.weights.push_back(weight == 0 ? 1 : weight);
  }
  deck_.add_element(std::move(element));
  return true;
}

void DynaElements::finish(
    TextMeshContent& mesh,
    const std::function<std::optional<std::vector<int>>(long set)>& set) const {
  for (const Body& body : bodies_) {
    NonShellElement element{Kind::Rigid, body.name, body.label, {}, {}};
    const auto first = mesh.node_labels.find(body.node);
    if (first) element.nodes.push_back(*first);
    if (const auto nodes = set(body.set))
      for (const int node : *nodes)
        if (!first || node != *first) element.nodes.push_back(node);
    if (!element.nodes.empty()) mesh.other_elements.push_back(std::move(element));
  }
}

}  // namespace batten
