// SPDX-License-Identifier: MPL-2.0
// Reads Nastran bulk data: GRIDs, elements and coordinate systems. Everything else stays text.

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"
#include "batten/io/meshes/decks/nastran_cards.h"
#include "batten/io/meshes/decks/nastran_directions.h"

namespace batten {

// Coordinate systems of Nastran decks.

/// Collects CORD1R, CORD1C, CORD1S, CORD2R, CORD2C and CORD2S, and transforms the nodes given in
/// them.
class NastranSystems {
 public:
  explicit NastranSystems(const MeshSourceText& file) : file_(file) {}
  /// Reads a card whose name begins with CORD.
  void read(const std::string& name, std::span<const std::string_view> values);
  /// Transforms the nodes of a finished mesh from local to global coordinates. `systems`: system
  /// number of each node, 0 for the basic system. Throws InputError for an undefined system, and
  /// the exceptions of nodes_to_global().
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

void NastranSystems::read(const std::string& name, std::span<const std::string_view> values) {
  const auto at = [&](size_t i) { return i < values.size() ? values[i] : std::string_view(); };
  Definition definition;
  CoordinateSystemDefinition& plan = definition.plan;
  const char last = name.back();
  plan.kind = last == 'C'   ? CoordinateFrame::Kind::Cylindrical
              : last == 'S' ? CoordinateFrame::Kind::Spherical
                            : CoordinateFrame::Kind::Rectangular;
  if (name == "CORD1R" || name == "CORD1C" || name == "CORD1S") {
    // Two systems per card.
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
  // Only systems that nodes use, directly or indirectly, must be defined.
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

// Non-shell elements and connections of Nastran decks.

/// True for the names of non-shell elements and connections.
bool is_non_shell_element(const std::string& name);

/// Adds a non-shell element or connection. `values`: values of all lines of the card. Cards whose
/// nodes are not read are only counted. Throws InputError, with the location, for an invalid node
/// number.
void add_non_shell_element(const std::string& name, std::span<const std::string_view> values,
                           const MeshSourceText& file, DeckMeshBuilder& deck);

namespace {

using Kind = NonShellElement::Kind;

/// Positions of the nodes among the values of a card; the element number is value 0. `nodes` follow
/// the element's node order. Value `direction` may be an orientation node, or the first of three
/// vector components; -1: none.
struct CardLayout {
  Kind kind = Kind::Other;
  std::vector<int> nodes;
  int direction = -1;
};

std::vector<int> numbered_fields(int first, int count) {
  std::vector<int> places;
  for (int i = 0; i < count; ++i) places.push_back(first + i);
  return places;
}

const std::map<std::string, CardLayout>& card_layouts() {
  static const std::map<std::string, CardLayout> all{
      {"CHEXA", {Kind::Solid, numbered_fields(2, 20)}},
      {"CPENTA", {Kind::Solid, numbered_fields(2, 15)}},
      {"CTETRA", {Kind::Solid, numbered_fields(2, 10)}},
      {"CPYRAM", {Kind::Solid, numbered_fields(2, 13)}},
      {"CPYRA", {Kind::Solid, numbered_fields(2, 13)}},
      {"CBAR", {Kind::Beam, {2, 3}, 4}},
      {"CBEAM", {Kind::Beam, {2, 3}, 4}},
      {"CBEND", {Kind::Beam, {2, 3}, 4}},
      {"CBEAM3", {Kind::Beam, {2, 3, 4}, 5}},
      {"CROD", {Kind::Beam, {2, 3}}},
      {"CTUBE", {Kind::Beam, {2, 3}}},
      {"CONROD", {Kind::Beam, {1, 2}}},
      {"CVISC", {Kind::Bush, {2, 3}}},
      {"CBUSH", {Kind::Bush, {2, 3}, 4}},
      {"CBUSH1D", {Kind::Bush, {2, 3}}},
      {"CBUSH2D", {Kind::Bush, {2, 3}}},
      {"CGAP", {Kind::Bush, {2, 3}, 4}},
      {"CELAS1", {Kind::Bush, {2, 4}}},
      {"CELAS2", {Kind::Bush, {2, 4}}},
      {"CDAMP1", {Kind::Bush, {2, 4}}},
      {"CDAMP2", {Kind::Bush, {2, 4}}},
      {"CDAMP5", {Kind::Bush, {2, 3}}},
      {"CFAST", {Kind::Bush, {6, 7, 5}}},
      {"CWELD", {Kind::Bush, {4, 5, 2}}},
      {"CMASS1", {Kind::Mass, {2, 4}}},
      {"CMASS2", {Kind::Mass, {2, 4}}},
      {"CONM1", {Kind::Mass, {1}}},
      {"CONM2", {Kind::Mass, {1}}},
      {"CSHEAR", {Kind::Other, numbered_fields(2, 4)}},
      {"PLOTEL", {Kind::Other, {1, 2}}},
      {"RBAR1", {Kind::Rigid, {1, 2}}},
      {"RJOINT", {Kind::Rigid, {1, 2}}},
      {"RTRPLT", {Kind::Rigid, {1, 2, 3}}},
      {"RTRPLT1", {Kind::Rigid, {1, 2, 3}}}};
  return all;
}

/// Elements whose nodes are not read: those with scalar points, boundary elements, plane elements,
/// couplings between elements.
bool counted_only(const std::string& name) {
  static const std::set<std::string, std::less<>> names{
      "CCONEAX", "CDAMP3", "CDAMP4", "CELAS3",  "CELAS4",  "CHBDYG",  "CHBDYP",
      "CMASS3",  "CMASS4", "CQUAD",  "CQUADX",  "CQUADX4", "CQUADX8", "CSEAM",
      "CTRAX3",  "CTRAX6", "CTRIAX", "CTRIAX6", "CBARAO",  "RBE2GS",  "RSSCON"};
  return names.contains(name);
}

/// The values of one card.
class BulkDataCard {
 public:
  BulkDataCard(const std::string& name, std::span<const std::string_view> values,
               const MeshSourceText& file)
      : values_(values), file_(file) {
    element_.name = name;
    element_.where = values.front();
    parse_integer(values.front(), element_.label);
  }

  DeckElement read() {
    const std::string& name = element_.name;
    if (const auto layout = card_layouts().find(name); layout != card_layouts().end()) {
      read(layout->second);
    } else if (name == "RBAR" || name == "RROD") {
      rigid_bar(name == "RROD");
    } else if (name == "RBE1") {
      rigid_body();
    } else if (name == "RBE2") {
      spider();
    } else if (name == "RBE3") {
      average();
    } else if (name == "RSPLINE") {
      for (int i = 2; i < count(); i += i == 2 ? 1 : 2) add(i);
    } else if (name == "MPC") {
      equation();
    }
    return std::move(element_);
  }

 private:
  int count() const { return static_cast<int>(values_.size()); }
  std::string_view at(int i) const { return i < count() ? values_[i] : std::string_view(); }
  bool is_integer(int i) const {
    long value = 0;
    return parse_integer(at(i), value);
  }
  static bool is_real(std::string_view text) {
    double value = 0;
    return text.find_first_of(".eEdD") != text.npos && parse_real(text, value);
  }
  void add(int i) {
    if (!at(i).empty()) element_.nodes.push_back(file_.integer(at(i), "a node number"));
  }

  void read(const CardLayout& layout) {
    element_.kind = layout.kind;
    for (const int i : layout.nodes) add(i);
    const int d = layout.direction;
    if (d > 0 && at(d + 1).empty() && at(d + 2).empty() && is_integer(d)) add(d);
  }

  /// For RBAR, the components independent at A and B are given; for RROD, the dependent ones.
  void rigid_bar(bool rod) {
    element_.kind = Kind::Rigid;
    const bool b_first = rod ? !at(3).empty() : at(3).empty() && !at(4).empty();
    add(b_first ? 2 : 1);
    add(b_first ? 1 : 2);
  }

  /// RBE1: pairs of a node and its components; those after UM are dependent.
  void rigid_body() {
    element_.kind = Kind::Rigid;
    bool node = true;
    for (int i = 1; i < count(); ++i) {
      if (at(i).empty() || upper(at(i)) == "UM") continue;
      if (is_real(at(i))) break;  // thermal expansion
      if (node) add(i);
      node = !node;
    }
  }

  /// At THRU, adds the nodes between the preceding and the following one.
  bool thru(int i) {
    if (upper(at(i)) != "THRU" || element_.nodes.empty()) return false;
    const long last = file_.integer(at(i + 1), "a node number");
    // A node takes more than one byte of the deck.
    const MeshSourceText::Source& source = *file_.sources().back();
    if (last - element_.nodes.back() > static_cast<long>(source.base + source.text.size()))
      file_.fail(at(i + 1), "found more nodes than an element has");
    for (long n = element_.nodes.back() + 1; n < last; ++n) element_.nodes.push_back(n);
    return true;
  }

  void spider() {
    element_.kind = Kind::Rigid;
    add(1);
    // A real number is the thermal expansion coefficient.
    for (int i = 3; i < count() && !is_real(at(i)); ++i)
      if (!thru(i)) add(i);
  }

  /// RBE3: a weight with its components starts a group of nodes. Weights of rotations alone do not
  /// constrain translations.
  void average() {
    element_.kind = Kind::Interpolation;
    if (at(2).empty()) file_.fail(at(0), "found an RBE3 without its reference node, expected one");
    add(2);
    double weight = 0;
    bool moves = false;
    for (int i = 4; i < count(); ++i) {
      const std::string field = upper(at(i));
      if (field == "UM" || field == "ALPHA") break;
      if (is_real(field)) {
        weight = file_.real(at(i));
        moves = at(++i).find_first_of("123") != std::string_view::npos;
      } else if (moves && !thru(i)) {
        add(i);
      }
      element_.weights.resize(element_.nodes.size() - 1, weight);
    }
  }

  /// Two terms per line: node, component, coefficient.
  void equation() {
    for (int i = 0; i < count(); i += 8) {
      add(i + 1);
      add(i + 4);
    }
  }

  std::span<const std::string_view> values_;
  const MeshSourceText& file_;
  DeckElement element_;
};

}  // namespace

bool is_non_shell_element(const std::string& name) {
  return card_layouts().contains(name) || counted_only(name) || name == "RBAR" || name == "RROD" ||
         name == "RBE1" || name == "RBE2" || name == "RBE3" || name == "RSPLINE" || name == "MPC";
}

void add_non_shell_element(const std::string& name, std::span<const std::string_view> values,
                           const MeshSourceText& file, DeckMeshBuilder& deck) {
  if (counted_only(name)) return deck.count_other_element(name);
  deck.add_element(BulkDataCard(name, values, file).read());
}

namespace {

class NastranReader {
 public:
  explicit NastranReader(TextMeshContent& mesh)
      : mesh_(mesh),
        file_(mesh.file),
        cards_(mesh.file),
        deck_(mesh),
        coordinates_(mesh.file),
        directions_(mesh.file) {}

  void read() {
    go_to_bulk();
    std::string_view line;
    bool ended = false;
    while (!ended && cards_.next(line)) {
      if (line.empty() || line[0] == '$') continue;
      const CardLine card(line);
      if (card.continues()) continue;
      const std::string name = upper(card.name);
      ended = name == "ENDDATA";
      read(card, name, line);
    }
    if (!ended && begun_)
      file_.fail_at_end(
          "found the end of a deck with BEGIN BULK, expected ENDDATA: the file may be "
          "truncated");
    finish();
    if (!ended) mesh_.warnings.push_back("the deck has no ENDDATA: the file may be truncated");
    mesh_.warn_about_unwritten_includes();
  }

 private:
  /// Skips the executive and case control sections, if present; they end with BEGIN BULK.
  void go_to_bulk() {
    const auto begins = [](std::string_view line) {
      const std::string first = upper(next_token(line)), second = upper(next_token(line));
      return first == "BEGIN" && second.starts_with("BULK");
    };
    const size_t start = file_.position();
    std::string_view line;
    while (!begun_ && file_.next_in_file(line)) begun_ = begins(line);
    file_.seek(start);
    if (begun_)
      while (cards_.next(line) && !begins(line)) {
      }
  }

  void read(const CardLine& card, const std::string& name, std::string_view line) {
    if (name == "GRID") {
      grid(card);
    } else if (name == "CTRIA3" || name == "CTRIAR") {
      shell(card, 3, 0);
    } else if (name == "CQUAD4" || name == "CQUADR") {
      shell(card, 4, 0);
    } else if (name == "CTRIA6") {
      shell(card, 3, 3);
    } else if (name == "CQUAD8") {
      shell(card, 4, 4);
    } else if (name == "SET1") {
      sets_.push_back(cards_.values_of(card));
    } else if (name == "GRDSET") {
      if (!card.value(2).empty()) default_system_ = file_.integer(card.value(2), "a system");
      if (!card.value(6).empty())
        directions_.set_default_displacement_system(file_.integer(card.value(6), "a system"));
    } else if (name.starts_with("CORD")) {
      const BulkCard all = cards_.whole(card);
      coordinates_.read(name, all.values);
      directions_.read_system(name, all);
    } else if (name == "SPOINT" || name == "EPOINT") {
      std::vector<LabelRange> points;
      read_ranges(cards_.values_of(card), points);
      for (const LabelRange& range : points) deck_.add_scalar_points(range);
    } else if (is_non_shell_element(name)) {
      const BulkCard all = cards_.whole(card);
      add_non_shell_element(name, all.values, file_, deck_);
      directions_.read_element(name, all);
      if (name == "CFAST" || name == "CWELD") fasteners_.push_back(all);
    } else if (NastranDirections::is_property_or_load(name)) {
      directions_.read_property_or_load(name, cards_.whole(card));
    } else {
      other(name, line);
    }
  }

  void other(const std::string& name, std::string_view line) {
    if (name == "BGSET")
      mesh_.warnings.push_back(
          "BGSET (glued contact, " + file_.line_name(file_.offset(line), 0) +
          ") is not followed; parts that only glue connects need handles or features of their own");
    if (name.starts_with("BEGIN") && upper(line).find("SUPER") != std::string::npos)
      file_.fail(line,
                 "found " + quoted_excerpt(line) + ", expected one model without superelements");
    if (name.starts_with("BEGIN") && begun_)
      file_.fail(line, "found a second " + quoted_excerpt(line) + ", expected one model");
    // BEGIN BULK inside an included file, in a deck that consists of include lines only.
    if (name.starts_with("BEGIN")) begun_ = true;
    if (name.starts_with("="))
      file_.fail(line,
                 "found a repeated card " + quoted_excerpt(line) + ", expected every card in full");
  }

  void grid(const CardLine& card) {
    std::array<Field, 3> fields;
    std::array<std::string_view, 3> values{card.value(3), card.value(4)};
    std::string_view second_value;
    if (card.large) {
      std::optional<CardLine> second;
      if (!cards_.next_line(second))
        file_.fail(card.name, "found a GRID* without its second line, expected one");
      card.fields(file_, 3, {fields.data(), 2});
      second->fields(file_, 1, {fields.data() + 2, 1});
      values[2] = second->value(1);
      second_value = second->value(2);
    } else {
      card.fields(file_, 3, fields);
      values[2] = card.value(5);
    }
    std::array<double, 3> xyz;
    for (int c = 0; c < 3; ++c) xyz[c] = file_.real(values[c], true);
    const std::string_view label = card.value(1), system = card.value(2);
    const std::string_view displacement = card.large ? second_value : card.value(6);
    if (!displacement.empty())
      directions_.add_displacement_system(isize(systems_), file_.integer(displacement, "a system"));
    deck_.add_node(file_.integer(label, "a node number"), label, xyz, fields);
    systems_.push_back(system.empty() ? kDefault : file_.integer(system, "a coordinate system"));
  }

  void shell(const CardLine& card, size_t corners, size_t middle) {
    // The material angle or system follows the nodes, in CQUAD8 after the four thicknesses.
    const size_t angle = 2 + corners + middle + (middle == 4 ? 4 : 0);
    std::array<std::string_view, 15> values{};
    Field angle_field;
    size_t count = 0;
    std::optional<CardLine> line(card);
    do {
      for (int i = 1; i <= line->count() && count <= angle; ++i) {
        if (count == angle) line->fields(file_, i, {&angle_field, 1});
        values[count++] = line->value(i);
      }
    } while (count <= angle && cards_.next_line(line));
    const long label = file_.integer(values[0], "an element number");
    std::array<long, 8> nodes{};
    for (size_t i = 0; i < corners + middle; ++i) {
      const std::string_view value = values[2 + i];
      if (i < corners && value.empty())
        file_.fail(card.name, "found " + format_count(static_cast<long>(i), "corner") +
                                  " of element " + std::to_string(label) + ", expected " +
                                  std::to_string(corners));
      if (!value.empty()) nodes[i] = file_.integer(value, "a node number");
    }
    directions_.read_material_angle(values[0], values[angle], angle_field, face_count_++);
    // A missing property number defaults to the element number.
    deck_.add_shell(label, values[0], std::string(values[1].empty() ? values[0] : values[1]),
                    {nodes.data(), corners}, {nodes.data() + corners, middle});
  }

  void finish() {
    deck_.finish();
    for (long& system : systems_)
      if (system == kDefault) system = default_system_;
    coordinates_.transform_nodes(mesh_, deck_, systems_);
    directions_.finish(mesh_, systems_);
    for (const BulkCard& card : fasteners_) fastener(card);
    for (const auto& values : sets_) set(values);
    deck_.warn_about_other_elements();
  }

  /// The shells of a property, or one shell by its number.
  std::vector<int> faces_of(bool property, std::string_view label) const {
    if (property) return deck_.faces_of_property(std::string(label));
    long number = 0;
    const auto face = parse_integer(label, number) ? mesh_.face_labels.find(number) : std::nullopt;
    return face ? std::vector<int>{*face} : std::vector<int>();
  }

  /// A fastener without end nodes, or with ends that belong to no shell, is projected onto the
  /// shells.
  void fastener(const BulkCard& card) {
    const bool weld = upper(card.lines.front().name) == "CWELD";
    const auto node_at = [&](int i) -> std::optional<int> {
      long label = 0;
      return parse_integer(card.at(i), label) ? mesh_.node_labels.find(label) : std::nullopt;
    };
    const std::string type = upper(card.at(weld ? 3 : 2)),
                      name = (weld ? "CWELD " : "CFAST ") + std::string(card.at(0));
    const bool property = type == "PROP" || type == "PARTPAT";
    std::vector<std::vector<int>> sides;
    if (property || type == "ELEM" || type == "ELEMID" || type == "ELPAT")
      for (const int i : weld ? std::array{8, 9} : std::array{3, 4})
        sides.push_back(faces_of(property, card.at(i)));
    const auto centre = node_at(weld ? 2 : 5), a = node_at(weld ? 4 : 6), b = node_at(weld ? 5 : 7);
    if (!a && !b && centre && !sides.empty())
      mesh_.ties.push_back({SurfaceTie::Kind::Weld, name, {*centre}, std::move(sides), 0});
    for (const auto& [end, side] : {std::pair(a, size_t{0}), std::pair(b, size_t{1})})
      if (end && !has_face(*end))
        deck_.add_tie(name, {*end}, side < sides.size() ? sides[side] : std::vector<int>());
  }

  bool has_face(int node) {
    if (has_face_.empty()) {
      has_face_.assign(static_cast<size_t>(mesh_.shells.node_count()), 0);
      for (int f = 0; f < mesh_.shells.face_count(); ++f)
        for (const int v : mesh_.shells.face(f)) has_face_[v] = 1;
    }
    return has_face_[node] != 0;
  }

  void set(const std::vector<std::string_view>& values) {
    std::vector<LabelRange> ranges;
    const std::string_view bad = read_ranges(std::span(values).subspan(1), ranges);
    if (!bad.empty()) {
      mesh_.warnings.push_back("SET1 " + std::string(values[0]) + " is not read: it has " +
                               quoted_excerpt(bad));
      return;
    }
    MeshSet set{std::string(values[0]), {}, deck_.nodes_of(ranges), {}};
    if (!set.nodes.empty()) mesh_.sets.push_back(std::move(set));
  }

  static constexpr long kDefault = -1;  // the system set by GRDSET
  TextMeshContent& mesh_;
  MeshSourceText& file_;
  NastranCards cards_;
  DeckMeshBuilder deck_;
  NastranSystems coordinates_;
  NastranDirections directions_;
  int face_count_ = 0;
  std::vector<BulkCard> fasteners_;
  std::vector<char> has_face_;  // of each node
  std::vector<long> systems_;   // of each node
  std::vector<std::vector<std::string_view>> sets_;
  long default_system_ = 0;
  bool begun_ = false;  // BEGIN BULK was found
};

}  // namespace

std::unique_ptr<MeshContent> read_nastran_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Nastran bulk data";
  mesh->extensions = {".bdf", ".nas", ".dat", ".fem"};
  NastranReader(*mesh).read();
  return mesh;
}

}  // namespace batten
