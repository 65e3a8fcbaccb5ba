// SPDX-License-Identifier: MPL-2.0
// Reads OpenRadioss starter decks: nodes, elements and node groups. Everything else stays text.
#include <algorithm>
#include <map>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"

namespace batten {
namespace {

using Kind = NonShellElement::Kind;

constexpr int kWidth = 10;  // field width in columns, except for real numbers

/// Card layout of an element keyword: `nodes` after the number on its line, and `more` further
/// lines of nodes.
struct BlockLayout {
  Kind kind;
  int nodes, more = 0;
};
const std::map<std::string, BlockLayout>& block_layouts() {
  static const std::map<std::string, BlockLayout> all{
      {"BRICK", {Kind::Solid, 8}},     {"TETRA4", {Kind::Solid, 4}}, {"PENTA6", {Kind::Solid, 6}},
      {"BEAM", {Kind::Beam, 3}},       {"TRUSS", {Kind::Beam, 2}},   {"SPRING", {Kind::Bush, 3}},
      {"TETRA10", {Kind::Solid, 0, 1}}};
  return all;
}

class RadiossReader {
 public:
  explicit RadiossReader(TextMeshContent& mesh) : mesh_(mesh), file_(mesh.file), deck_(mesh) {}

  void read() {
    bool ended = false;
    while (!ended && next_block()) {
      const std::vector<std::string> parts = keyword_parts(line_);
      ended = parts[0] == "END" && file_.depth() == 0;
      const bool of_included = parts[0] == "END" && !ended;
      if (of_included) file_.leave_file();
      keyword_ = line_;
      line_ = {};
      if (!of_included) handle(parts);
    }
    finish();
    if (!ended) mesh_.warnings.push_back("the deck has no /END: the file may be truncated");
  }

 private:
  struct Group {
    std::string name, title;
    std::vector<LabelRange> nodes;
    std::vector<std::string> parts;
  };
  struct Tie {
    std::string name, group, surface;
  };
  struct Surface {
    std::vector<std::string> parts;
    std::vector<long> nodes;
  };
  struct Body {
    std::string name;
    long label, node, group;
  };

  /// Reads the next line that is not a comment, following include lines.
  bool next(std::string_view& line) {
    while (file_.next(line)) {
      if (line.starts_with("#include")) {
        file_.include(std::string(trimmed(line.substr(8))), line);
        continue;
      }
      if (!line.starts_with('#') && !line.starts_with('$')) return true;
    }
    line = {};
    return false;
  }
  bool next_block() {
    while (!line_.starts_with('/'))
      if (!next(line_)) return false;
    return true;
  }
  /// Advances line_ to the next data line of the current block; at the end of the block, line_ is
  /// the keyword that ended it.
  bool next_data() {
    if (line_.starts_with('/')) return false;
    while (next(line_)) {
      if (line_.starts_with('/')) return false;
      if (!trimmed(line_).empty()) return true;
    }
    return false;
  }

  /// Splits "/SHELL/7" into SHELL and 7.
  static std::vector<std::string> keyword_parts(std::string_view line) {
    std::vector<std::string> parts;
    for (std::string_view rest = trimmed(line).substr(1);;) {
      const size_t slash = rest.find('/');
      parts.push_back(upper(trimmed(rest.substr(0, slash))));
      if (slash == rest.npos) break;
      rest.remove_prefix(slash + 1);
    }
    parts.resize(std::max<size_t>(parts.size(), 3));
    return parts;
  }

  void handle(const std::vector<std::string>& parts) {
    const std::string& name = parts[0];
    if (name == "BEGIN") return begin();
    if (name == "NODE" || name == "CNODE") return nodes();
    if (name == "SHELL") return shells(parts[1], 4);
    if (name == "SH3N") return shells(parts[1], 3);
    if (name == "PART") return title_of(titles_[parts[1]]);
    if (name == "GRNOD" && (parts[1] == "NODE" || parts[1] == "NODENS" || parts[1] == "GENE"))
      return group(parts[2], parts[1] == "GENE");
    if (name == "RBODY" && parts[1] != "LAGMUL") return body("/RBODY", parts[1], 6);
    if (name == "RBE2") return body("/RBE2", parts[1], 3);
    if (name == "INTER" && parts[1] == "TYPE2") return tie(parts[2]);
    if (name == "SURF") return surface(parts[1], parts[2]);
    if (name == "RWALL") {
      ++mesh_.global_positions["/RWALL/" + parts[1]];
      return;
    }
    if (name == "GRNOD" && parts[1] == "PART") return group_of_parts(parts[2]);
    if ((name == "SKEW" || name == "FRAME") && parts[1] == "FIX")
      return system("/" + name + "/FIX/" + parts[2]);
    if (name == "PROP" && has_axes(parts[1]))
      return deck_.add_global_directions("/PROP/" + parts[1] + "/" + parts[2]);
    if (name == "TRANSFORM" || name.empty())
      file_.fail(keyword_, "found " + quoted_excerpt(keyword_) +
                               ", expected one model without transformed nodes");
    if (const auto layout = block_layouts().find(name); layout != block_layouts().end())
      return elements(name, layout->second, parts[1]);
    static const std::set<std::string> format_count{"BRIC20", "SHEL16", "QUAD",  "TRIA",
                                                    "XELEM",  "SPHCEL", "ADMAS", "RBE3"};
    if (format_count.contains(name)) deck_.count_other_element("/" + name, 0);
  }

  std::string_view field(int i) const { return DeckLine(line_).value(i, i * kWidth, kWidth); }
  long number(int i, const char* expected = "a node number") const {
    return field(i).empty() ? 0 : file_.integer(field(i), expected);
  }

  /// Versions before 51 have narrower fields and are rejected.
  void begin() {
    std::string title;
    title_of(title);
    if (!next_data()) return;
    long version = 0;
    if (parse_integer(field(0), version) && version < 51)
      file_.fail(field(0), "found input of version " + std::to_string(version) +
                               ", expected 51 or later, whose fields have 10 columns");
  }

  /// Reads a title, which may be empty.
  void title_of(std::string& title) {
    if (!line_.starts_with('/') && next(line_) && !line_.starts_with('/')) title = trimmed(line_);
  }

  void nodes() {
    while (next_data()) {
      const DeckLine line(line_);
      const int real = width_of(FieldKind::Dyna20);
      const std::string_view label = line.value(0, 0, kWidth);
      std::array<double, 3> xyz;
      for (int c = 0; c < 3; ++c)
        xyz[c] = file_.real(line.value(c + 1, kWidth + c * real, real), true);
      std::array<Field, 3> fields;
      line.fields(file_, 1, kWidth, FieldKind::Dyna20, FieldKind::DynaFree20, fields);
      deck_.add_node(file_.integer(label, "a node number"), label, xyz, fields);
    }
  }

  void shells(const std::string& part, size_t corners) {
    while (next_data()) {
      const std::string_view label = field(0);
      const long element = file_.integer(label, "an element number");
      std::array<long, 4> n{};
      for (size_t i = 0; i < corners; ++i) n[i] = number(static_cast<int>(i) + 1);
      if (n[0] == 0 || n[1] == 0 || n[2] == 0)
        file_.fail(label, "found element " + std::string(label) + " of fewer than 3 nodes");
      const bool triangle = n[3] == 0 || n[3] == n[2];
      deck_.add_shell(element, label, part, {n.data(), triangle ? 3u : 4u});
    }
  }

  void elements(const std::string& name, const BlockLayout& layout, const std::string& part) {
    while (next_data()) {
      DeckElement element{layout.kind, "/" + name, 0, field(0), {}, {}};
      element.label = file_.integer(field(0), "an element number");
      const auto add = [&](int i) {
        // Solids with fewer corners repeat some nodes.
        const long node = number(i);
        auto& all = element.nodes;
        if (node != 0 && std::find(all.begin(), all.end(), node) == all.end()) all.push_back(node);
      };
      for (int i = 1; i <= layout.nodes; ++i) add(i);
      for (int more = 0; more < layout.more; ++more) {
        if (!next_data()) file_.fail(element.where, "found an element without its nodes");
        for (int i = 0; i < 10; ++i) add(i);
      }
      auto& all = part_nodes_[part];
      all.insert(all.end(), element.nodes.begin(), element.nodes.end());
      deck_.add_element(std::move(element));
    }
  }

  /// A tied interface: a group of nodes follows a surface.
  void tie(const std::string& label) {
    std::string title;
    title_of(title);
    if (next_data())
      ties_.push_back({"/INTER/TYPE2/" + label, std::to_string(number(0, "a group")),
                       std::to_string(number(1, "a surface"))});
  }

  /// A surface of parts, or of segments: the number of the segment and its nodes.
  void surface(const std::string& type, const std::string& label) {
    std::string title;
    title_of(title);
    Surface& surface = surfaces_[label];
    while (next_data())
      for (int i = type == "SEG" ? 1 : 0; i < (type == "SEG" ? 5 : 10); ++i) {
        long value = 0;
        if (!parse_integer(field(i), value) || value <= 0) continue;
        if (type == "SEG") surface.nodes.push_back(value);
        if (type == "PART") surface.parts.push_back(std::to_string(value));
      }
  }

  void group_of_parts(const std::string& label) {
    Group group{label, "", {}, {}};
    title_of(group.title);
    while (next_data())
      for (int i = 0; i < 10; ++i)
        if (const long part = number(i, "a part"); part > 0)
          group.parts.push_back(std::to_string(part));
    groups_.push_back(std::move(group));
  }

  std::vector<int> nodes_of_group(const Group& group) {
    std::vector<int> nodes = deck_.nodes_of(group.nodes);
    for (const std::string& part : group.parts) {
      const std::vector<int> own = deck_.nodes_of_faces(deck_.faces_of_property(part));
      nodes.insert(nodes.end(), own.begin(), own.end());
      for (const long label : part_nodes_[part])
        if (const auto node = mesh_.node_labels.find(label)) nodes.push_back(*node);
    }
    return sorted_unique(std::move(nodes));
  }

  void finish_ties() {
    for (const Tie& tie : ties_) {
      std::vector<int> nodes, faces;
      for (const Group& group : groups_)
        if (group.name == tie.group) nodes = nodes_of_group(group);
      const Surface& surface = surfaces_[tie.surface];
      for (const std::string& part : surface.parts) {
        const std::vector<int> own = deck_.faces_of_property(part);
        faces.insert(faces.end(), own.begin(), own.end());
      }
      std::vector<int> segments;
      for (const long label : surface.nodes)
        if (const auto node = mesh_.node_labels.find(label)) segments.push_back(*node);
      if (!segments.empty()) faces = deck_.faces_among(segments);
      if (nodes.empty())
        mesh_.warnings.push_back(tie.name + " is not followed: its nodes are not known");
      deck_.add_tie(tie.name, std::move(nodes), std::move(faces));
    }
  }

  /// Properties with a reference vector in the global system.
  static bool has_axes(const std::string& type) {
    static const std::set<std::string> types{
        "TYPE6",    "SOL_ORTH", "TYPE9",   "SH_ORTH", "TYPE10", "SH_COMP", "TYPE11",
        "SH_SANDW", "TYPE16",   "SH_FABR", "TYPE17",  "STACK",  "TYPE51",  "PCOMPP"};
    return types.contains(type);
  }

  /// A fixed system: its origin, and its y and z axes.
  void system(const std::string& name) {
    std::string title;
    title_of(title);
    if (!next_data()) return;
    RotatingCard card;
    card.name = name;
    while (card.numbers.size() < 2 && next_data()) {
      RotatingCard::Numbers numbers;
      const DeckLine line(line_);
      const int real = width_of(FieldKind::Dyna20);
      for (int c = 0; c < 3; ++c)
        numbers.value[c] = file_.real(line.value(c, c * real, real), true);
      line.fields(file_, 0, 0, FieldKind::Dyna20, FieldKind::DynaFree20, numbers.fields);
      card.numbers.push_back(numbers);
    }
    if (!card.numbers.empty()) deck_.add_rotating(std::move(card));
  }

  void group(const std::string& name, bool ranges) {
    Group group{name, "", {}, {}};
    title_of(group.title);
    std::vector<long> numbers;
    while (next_data())
      for (int i = 0; i < 10; ++i)
        if (const long n = number(i); n > 0) numbers.push_back(n);
    const size_t step = ranges ? 2 : 1;
    for (size_t i = 0; i + step <= numbers.size(); i += step)
      group.nodes.push_back({numbers[i], numbers[i + step - 1]});
    groups_.push_back(std::move(group));
  }

  void body(const std::string& name, const std::string& label, int group_field) {
    Body body{name, 0, 0, 0};
    parse_integer(label, body.label);
    std::string title;
    title_of(title);
    if (!next_data()) return;
    body.node = number(0);
    body.group = number(group_field, "the number of a group");
    deck_.count_other_element(name);
    bodies_.push_back(body);
  }

  void finish() {
    deck_.finish();
    for (MeshSet& property : mesh_.properties)
      if (const auto title = titles_.find(property.name); title != titles_.end())
        property.title = title->second;
    for (const Body& body : bodies_) {
      NonShellElement element{Kind::Rigid, body.name, body.label, {}, {}};
      const auto main = mesh_.node_labels.find(body.node);
      if (main) element.nodes.push_back(*main);
      for (const Group& group : groups_)
        if (group.name == std::to_string(body.group))
          for (const int node : nodes_of_group(group))
            if (!main || node != *main) element.nodes.push_back(node);
      if (!element.nodes.empty()) mesh_.other_elements.push_back(std::move(element));
    }
    finish_ties();
    for (const Group& group : groups_) {
      MeshSet set{group.name, group.title, nodes_of_group(group), {}};
      if (!set.nodes.empty()) mesh_.sets.push_back(std::move(set));
    }
    deck_.warn_about_other_elements();
    mesh_.warn_about_unwritten_includes();
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  DeckMeshBuilder deck_;
  std::string_view line_, keyword_;
  std::map<std::string, std::string> titles_;
  std::vector<Group> groups_;
  std::vector<Body> bodies_;
  std::vector<Tie> ties_;
  std::map<std::string, Surface> surfaces_;
  std::map<std::string, std::vector<long>> part_nodes_;
};

}  // namespace

std::unique_ptr<MeshContent> read_radioss_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Radioss starter";
  mesh->extensions = {".rad"};
  RadiossReader(*mesh).read();
  return mesh;
}

}  // namespace batten
