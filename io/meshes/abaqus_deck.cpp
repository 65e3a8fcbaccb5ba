// Abaqus and CalculiX input: nodes, elements and connections of one part; everything else stays
// text.
#include <algorithm>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/meshes/abaqus_connections.h"
#include "batten/io/meshes/abaqus_coordinates.h"
#include "batten/io/meshes/abaqus_elements.h"
#include "batten/io/meshes/abaqus_lines.h"
#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {
namespace {

/// A set as it is written: numbers and names of sets before it.
struct RawSet {
  std::string_view name;
  bool of_nodes;
  std::vector<LabelRange> ranges;
  std::vector<std::pair<std::string, std::string_view>> names;
};

class AbaqusReader {
 public:
  explicit AbaqusReader(TextMeshContent& mesh)
      : mesh_(mesh),
        file_(mesh.file),
        lines_(mesh.file),
        deck_(mesh),
        coordinate_systems_(mesh.file),
        connections_(mesh.file, deck_) {}

  void read() {
    while (const auto keyword = lines_.next_keyword()) {
      handle(*keyword);
      while (lines_.next_data()) {
      }
    }
    finish();
  }

 private:
  void handle(const Keyword& keyword) {
    const std::string& name = keyword.name;
    static const std::set<std::string> generators{"NGEN", "NFILL", "NCOPY",
                                                  "NMAP", "ELGEN", "ELCOPY"};
    if (generators.contains(name))
      file_.fail(keyword.line, "found *" + name + ", expected nodes and elements written out");
    // In an assembly, nodes and sets are those of the assembly, or say of which instance they are.
    const bool here = !in_assembly_ || parts_ == 0;
    if (name == "PART") {
      if (++parts_ > 1) file_.fail(keyword.line, "found a second *PART, expected one flat part");
    } else if (name == "INSTANCE") {
      if (++instances_ > 1)
        file_.fail(keyword.line,
                   "found a second *INSTANCE, expected one: nodes would be in two places");
      coordinate_systems_.read_instance(lines_);
    } else if (name == "ASSEMBLY" || name == "END ASSEMBLY") {
      in_assembly_ = name == "ASSEMBLY";
    } else if (name == "NODE" && here) {
      nodes(keyword);
    } else if (name == "ELEMENT" && here) {
      elements(keyword);
    } else if (name == "SYSTEM" && here) {
      coordinate_systems_.read_system(keyword, lines_);
    } else if (name == "PARAMETER") {
      coordinate_systems_.read_parameters(lines_);
    } else if ((name == "NSET" || name == "ELSET") && (here || keyword.has("INSTANCE"))) {
      set(keyword, name == "NSET");
    } else if (name == "SHELL SECTION" || name == "SHELL GENERAL SECTION" ||
               name == "MEMBRANE SECTION" || name == "SOLID SECTION") {
      sections_.push_back(keyword.value("ELSET"));
    } else if (name == "NODE" || name == "ELEMENT") {
      ++assembly_blocks_;
    } else {
      connections_.read(keyword, lines_);
    }
  }

  void nodes(const Keyword& keyword) {
    lines_.follow_input(keyword);
    const int system = coordinate_systems_.system_of(keyword);
    RawSet* const set = new_set(keyword.value("NSET"), true);
    while (lines_.next_data()) {
      const std::string_view data = lines_.line();
      std::array<Field, 3> fields;
      const DeckLine line(data);
      const std::string_view label = line.free() ? line.value(0, 0, 0) : trimmed(data);
      const long number = file_.integer(label, "a node number");
      line.fields(file_, 1, 0, FieldKind::Abaqus, FieldKind::Abaqus, fields);
      if (!line.free())  // nothing but the number
        for (int c = 0; c < 3; ++c)
          fields[c] = {file_.offset(data) + data.size(), 0, FieldKind::Abaqus, true, 1};
      std::array<double, 3> xyz{};
      for (int c = 0; c < 3 && line.free(); ++c) {
        bool parameter = false;
        xyz[c] = coordinate_systems_.real(line.value(c + 1, 0, 0), parameter);
        if (parameter)
          mesh_.fixed_nodes.push_back({isize(systems_), "has a coordinate that is the parameter " +
                                                            std::string(line.value(c + 1, 0, 0))});
      }
      deck_.add_node(number, label, xyz, fields);
      systems_.push_back(system);
      if (set) set->ranges.push_back({number, number});
    }
  }

  void elements(const Keyword& keyword) {
    lines_.follow_input(keyword);
    const std::string type = upper(keyword.value("TYPE"));
    if (type.empty()) file_.fail(keyword.line, "found *ELEMENT without TYPE=, expected one");
    RawSet* const set = new_set(keyword.value("ELSET"), false);
    const AbaqusElement element = abaqus_element(type);
    while (lines_.next_data()) {
      if (element.face) {
        const std::vector<std::string_view> values = record(type, element.count);
        face(element, values);
        if (set) set->ranges.push_back({face_label_, face_label_});
      } else if (element.count > 0) {
        other(element, type, record(type, element.count), keyword.value("ELSET"));
      } else {
        deck_.count_other_element(type);
        while (trimmed(lines_.line()).ends_with(',') && lines_.next_data()) {
        }
      }
    }
  }

  /// The number of an element and its nodes, `count` at least. A line goes on when it ends with a
  /// comma, whatever blanks follow.
  std::vector<std::string_view> record(const std::string& type, int count) {
    const std::string_view start = lines_.line();
    std::vector<std::string_view> values;
    for (;;) {
      for (const std::string_view value : comma_values(lines_.line())) values.push_back(value);
      if (isize(values) > count) return values;
      const bool goes_on = values.back().empty();
      if (goes_on) values.pop_back();
      if (!goes_on || !lines_.next_data())
        file_.fail(start, "found " + format_count(isize(values) - 1, "node") +
                              " of an element of type " + type + ", expected " +
                              std::to_string(count));
    }
  }

  void face(const AbaqusElement& element, const std::vector<std::string_view>& values) {
    face_label_ = file_.integer(values[0], "an element number");
    std::array<long, 8> nodes{};
    for (int i = 0; i < element.count; ++i)
      nodes[i] = file_.integer(values[i + 1], "a node number");
    const auto corners = static_cast<size_t>(element.corners);
    deck_.add_shell(face_label_, values[0], "", {nodes.data(), corners},
                    {nodes.data() + corners, static_cast<size_t>(element.middle)});
  }

  void other(const AbaqusElement& element, const std::string& type,
             const std::vector<std::string_view>& values, std::string_view elset) {
    DeckElement read{element.kind, type, file_.integer(values[0], "an element number"),
                     values[0],    {},   {}};
    const int count = element.count + (element.direction ? 1 : 0);
    for (int i = 1; i <= count && i < isize(values); ++i)
      if (!values[i].empty()) read.nodes.push_back(file_.integer(values[i], "a node number"));
    if (type == "DCOUP3D" && !read.nodes.empty())
      connections_.add_coupling_node(elset, read.nodes[0]);
    deck_.add_element(std::move(read));
  }

  RawSet* new_set(std::string_view name, bool of_nodes) {
    if (name.empty()) return nullptr;
    raw_sets_.push_back(std::make_unique<RawSet>(RawSet{name, of_nodes, {}, {}}));
    return raw_sets_.back().get();
  }

  void set(const Keyword& keyword, bool of_nodes) {
    const std::string_view name = keyword.value(of_nodes ? "NSET" : "ELSET");
    if (name.empty()) file_.fail(keyword.line, "found a set without a name, expected one");
    RawSet& set = *new_set(name, of_nodes);
    if (of_nodes && keyword.has("ELSET")) {
      // The nodes of a set of elements.
      set.names.push_back({"E" + upper(keyword.value("ELSET")), keyword.line});
    }
    while (lines_.next_data()) {
      std::vector<std::string_view> values = comma_values(lines_.line());
      std::erase_if(values, [](std::string_view value) { return value.empty(); });
      if (values.empty()) continue;
      if (keyword.has("GENERATE")) {
        LabelRange range{file_.integer(values[0], "a number"), 0};
        range.last = values.size() > 1 ? file_.integer(values[1], "a number") : range.first;
        if (values.size() > 2) range.step = file_.integer(values[2], "a step");
        if (range.step <= 0) file_.fail(values.back(), "found a step below 1");
        set.ranges.push_back(range);
        continue;
      }
      for (std::string_view value : values) {
        long label = 0;
        // "instance.5" and "instance.set" name what is in the only instance.
        const size_t dot = value.rfind('.');
        const std::string_view last = dot == value.npos ? value : value.substr(dot + 1);
        if (parse_integer(last, label))
          set.ranges.push_back({label, label});
        else
          set.names.push_back({(of_nodes ? "N" : "E") + upper(last), value});
      }
    }
  }

  void finish() {
    deck_.finish();
    coordinate_systems_.transform_nodes(mesh_, systems_);
    std::map<std::string, std::vector<int>> known;
    std::map<std::string, size_t> position;
    std::vector<MeshSet> sets;
    for (const auto& raw : raw_sets_) {
      std::vector<int> members =
          raw->of_nodes ? deck_.nodes_of(raw->ranges) : deck_.faces_of(raw->ranges);
      for (const auto& [name, where] : raw->names) {
        const auto found = known.find(name);
        if (found == known.end())
          file_.fail(where, "found " + quoted_excerpt(name.substr(1)) +
                                ", expected a number or the name of a set before it");
        if (raw->of_nodes && name[0] == 'E') {
          for (const int f : found->second)
            members.insert(members.end(), mesh_.shells.face(f).begin(), mesh_.shells.face(f).end());
        } else {
          members.insert(members.end(), found->second.begin(), found->second.end());
        }
      }
      // Several blocks may add to one set.
      const std::string key = (raw->of_nodes ? "N" : "E") + upper(raw->name);
      std::vector<int>& all = known[key];
      all.insert(all.end(), members.begin(), members.end());
      std::sort(all.begin(), all.end());
      all.erase(std::unique(all.begin(), all.end()), all.end());
      if (position.try_emplace(key, sets.size()).second)
        sets.push_back({std::string(raw->name), {}, {}, {}});
    }
    for (const auto& [key, index] : position)
      (key[0] == 'N' ? sets[index].nodes : sets[index].faces) = known[key];
    for (MeshSet& set : sets)
      if (!set.nodes.empty() || !set.faces.empty()) mesh_.sets.push_back(std::move(set));
    properties(known);
    connections_.finish(
        mesh_,
        [&](const std::string& name, bool faces) -> std::optional<std::vector<int>> {
          const auto found = known.find((faces ? "E" : "N") + name);
          return found == known.end() ? std::nullopt : std::optional(found->second);
        },
        parts_ == 0);
    warn();
  }

  void properties(const std::map<std::string, std::vector<int>>& known) {
    std::set<std::string> taken;
    for (const std::string_view name : sections_) {
      const auto found = known.find("E" + upper(name));
      if (found == known.end() || found->second.empty() || !taken.insert(found->first).second)
        continue;
      mesh_.properties.push_back({std::string(name), {}, {}, found->second});
    }
  }

  void warn() {
    deck_.warn_about_other_elements();
    mesh_.warn_about_unwritten_includes();
    if (file_.ends_in_mid_line())
      mesh_.warnings.push_back("the file ends in mid-line: it may be cut short");
    if (assembly_blocks_ > 0)
      mesh_.warnings.push_back("nodes and elements of the assembly itself are not read");
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  AbaqusLines lines_;
  DeckMeshBuilder deck_;
  AbaqusCoordinates coordinate_systems_;
  AbaqusConnections connections_;
  std::vector<int> systems_;  // of each node
  std::vector<std::unique_ptr<RawSet>> raw_sets_;
  std::vector<std::string_view> sections_;
  long face_label_ = 0;
  int parts_ = 0, instances_ = 0, assembly_blocks_ = 0;
  bool in_assembly_ = false;
};

}  // namespace

std::unique_ptr<MeshContent> read_abaqus_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Abaqus input";
  mesh->extensions = {".inp"};
  AbaqusReader(*mesh).read();
  return mesh;
}

}  // namespace batten
