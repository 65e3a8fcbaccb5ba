// Abaqus and CalculiX input: nodes and shells of one flat part; everything else stays text.
#include <algorithm>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh.h"

namespace batten {
namespace {

/// Corners and middle nodes of an element type; nothing for those that are not faces.
struct FaceType {
  int corners, middle;
};
std::optional<FaceType> face_type(const std::string& type) {
  static const std::map<std::string, FaceType> types{
      {"S3", {3, 0}},    {"S3R", {3, 0}},   {"S3RS", {3, 0}},   {"STRI3", {3, 0}},
      {"S4", {4, 0}},    {"S4R", {4, 0}},   {"S4RS", {4, 0}},   {"S4RSW", {4, 0}},
      {"S4R5", {4, 0}},  {"S6", {3, 3}},    {"STRI65", {3, 3}}, {"S8", {4, 4}},
      {"S8R", {4, 4}},   {"S8R5", {4, 4}},  {"M3D3", {3, 0}},   {"M3D4", {4, 0}},
      {"M3D4R", {4, 0}}, {"M3D6", {3, 3}},  {"M3D8", {4, 4}},   {"M3D8R", {4, 4}},
      {"CPS3", {3, 0}},  {"CPS4", {4, 0}},  {"CPS4R", {4, 0}},  {"CPS4I", {4, 0}},
      {"CPS6", {3, 3}},  {"CPS6M", {3, 3}}, {"CPS8", {4, 4}},   {"CPS8R", {4, 4}}};
  const auto found = types.find(type);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

std::string_view unquoted(std::string_view text) {
  const bool quotes = text.size() > 1 && text.front() == '"' && text.back() == '"';
  return quotes ? text.substr(1, text.size() - 2) : text;
}

/// A keyword line, which goes on in the next one after a comma.
struct Keyword {
  std::string name;
  std::map<std::string, std::string_view> parameters;
  std::string_view line;
  bool has(const std::string& key) const { return parameters.contains(key); }
  std::string_view value(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? std::string_view() : found->second;
  }
};

/// A set as it is written: numbers and names of sets before it.
struct RawSet {
  std::string_view name;
  bool of_nodes;
  std::vector<LabelRange> ranges;
  std::vector<std::pair<std::string, std::string_view>> names;
};

class AbaqusReader {
 public:
  explicit AbaqusReader(TextMesh& mesh) : mesh_(mesh), file_(mesh.file), deck_(mesh) {}

  void read() {
    while (next(line_)) {
      if (!line_.starts_with('*')) continue;
      while (const auto keyword = read_keyword()) handle(*keyword);
    }
    finish();
  }

 private:
  /// The next line that is not a comment.
  bool next(std::string_view& line) {
    while (file_.next(line))
      if (!line.starts_with("**")) return true;
    line = {};
    return false;
  }
  /// The next line of data; line_ is the keyword that ends them.
  bool next_data() {
    while (next(line_)) {
      if (line_.starts_with('*')) return false;
      if (!trimmed(line_).empty()) return true;
    }
    return false;
  }

  /// Reads the keyword in line_, if it is one.
  std::optional<Keyword> read_keyword() {
    if (!line_.starts_with('*')) return {};
    Keyword keyword;
    keyword.line = line_;
    std::string_view rest = line_.substr(1);
    bool first = true;
    for (;;) {
      const size_t comma = rest.find(',');
      const std::string_view part = trimmed(rest.substr(0, comma));
      const size_t equals = part.find('=');
      if (first) {
        std::string_view words = part;
        for (auto word = next_word(words); !word.empty(); word = next_word(words))
          keyword.name += (keyword.name.empty() ? "" : " ") + upper(word);
      } else if (!part.empty()) {
        const std::string_view value = equals == part.npos ? "" : trimmed(part.substr(equals + 1));
        keyword.parameters[upper(trimmed(part.substr(0, equals)))] = unquoted(value);
      }
      first = false;
      if (comma == rest.npos) break;
      rest.remove_prefix(comma + 1);
      if (!trimmed(rest).empty()) continue;
      if (!next(line_)) break;
      rest = line_;
    }
    line_ = {};
    return keyword;
  }

  void handle(const Keyword& keyword) {
    const std::string& name = keyword.name;
    static const std::set<std::string> generators{"NGEN",  "NFILL",  "NCOPY",  "NMAP",
                                                  "ELGEN", "ELCOPY", "SYSTEM", "INCLUDE"};
    if (generators.contains(name))
      file_.fail(keyword.line, "found *" + name + ", expected " +
                                   (name == "INCLUDE"  ? "everything in one file"
                                    : name == "SYSTEM" ? "nodes in global coordinates"
                                                       : "nodes and elements written out"));
    if (name == "PART" && ++parts_ > 1)
      file_.fail(keyword.line, "found a second *PART, expected one flat part");
    if (name == "INSTANCE") {
      if (++instances_ > 1)
        file_.fail(keyword.line, "found a second *INSTANCE, expected one flat part");
      if (next_data())
        file_.fail(line_, "found an instance that is moved, expected it in its place");
    } else if (name == "ASSEMBLY") {
      in_assembly_ = true;
      next_data();
    } else if (name == "END ASSEMBLY") {
      in_assembly_ = false;
      next_data();
    } else if (name == "NODE" && (!in_assembly_ || parts_ == 0)) {
      nodes(keyword);
    } else if (name == "ELEMENT" && (!in_assembly_ || parts_ == 0)) {
      elements(keyword);
    } else if ((name == "NSET" || name == "ELSET") &&
               (!in_assembly_ || parts_ == 0 || keyword.has("INSTANCE"))) {
      set(keyword, name == "NSET");
    } else {
      if (name == "SHELL SECTION" || name == "SHELL GENERAL SECTION" ||
          name == "MEMBRANE SECTION" || name == "SOLID SECTION")
        sections_.push_back(keyword.value("ELSET"));
      if (name == "NODE" || name == "ELEMENT") ++assembly_blocks_;
      while (next_data()) {
      }
    }
  }

  void refuse_other_file(const Keyword& keyword) const {
    if (keyword.has("INPUT"))
      file_.fail(keyword.line, "found INPUT=, expected everything in one file");
  }

  void nodes(const Keyword& keyword) {
    refuse_other_file(keyword);
    const std::string system = upper(keyword.value("SYSTEM"));
    if (!system.empty() && system != "R")
      file_.fail(keyword.line,
                 "found SYSTEM=" + system + ", expected nodes in rectangular coordinates");
    RawSet* const set = new_set(keyword.value("NSET"), true);
    while (next_data()) {
      std::array<Field, 3> fields;
      const DeckLine line(line_);
      const std::string_view label = line.free() ? line.value(0, 0, 0) : trimmed(line_);
      const long number = file_.integer(label, "a node number");
      line.fields(file_, 1, 0, FieldKind::Abaqus, FieldKind::Abaqus, fields);
      if (!line.free())  // nothing but the number
        for (int c = 0; c < 3; ++c)
          fields[c] = {file_.offset(line_) + line_.size(), 0, FieldKind::Abaqus, true, 1};
      std::array<double, 3> xyz{};
      for (int c = 0; c < 3; ++c)
        xyz[c] = line.free() ? file_.real(line.value(c + 1, 0, 0), true) : 0;
      deck_.add_node(number, label, xyz, fields);
      if (set) set->ranges.push_back({number, number});
    }
  }

  void elements(const Keyword& keyword) {
    refuse_other_file(keyword);
    const std::string type = upper(keyword.value("TYPE"));
    if (type.empty()) file_.fail(keyword.line, "found *ELEMENT without TYPE=, expected one");
    RawSet* const set = new_set(keyword.value("ELSET"), false);
    const auto face = face_type(type);
    bool more = false;
    while (next_data()) {
      const std::string_view start = line_;
      if (!face) {
        if (!more) deck_.add_other(type);
        more = trimmed(line_).ends_with(',');
        continue;
      }
      const auto count = static_cast<size_t>(1 + face->corners + face->middle);
      std::array<long, 9> numbers{};
      std::string_view label;
      size_t found = 0;
      for (std::string_view rest = line_; found < count;) {
        const size_t comma = rest.find(',');
        const std::string_view value = trimmed(rest.substr(0, comma));
        if (!value.empty() || comma != rest.npos) {
          if (found == 0) label = value;
          numbers[found] = file_.integer(value, found == 0 ? "an element number" : "a node number");
          ++found;
        }
        if (found == count) break;
        if (comma != rest.npos) {
          rest.remove_prefix(comma + 1);
          continue;
        }
        // A line goes on when it ends with a comma, whatever blanks follow.
        if (!value.empty() || !next_data())
          file_.fail(start, "found " + counted(static_cast<long>(found) - 1, "node") +
                                " of an element of type " + type + ", expected " +
                                std::to_string(count - 1));
        rest = line_;
      }
      const auto corners = static_cast<size_t>(face->corners);
      deck_.add_shell(numbers[0], label, "", {numbers.data() + 1, corners},
                      {numbers.data() + 1 + corners, static_cast<size_t>(face->middle)});
      if (set) set->ranges.push_back({numbers[0], numbers[0]});
    }
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
    while (next_data()) {
      std::vector<std::string_view> values;
      for (std::string_view rest = line_;;) {
        const size_t comma = rest.find(',');
        const std::string_view value = unquoted(trimmed(rest.substr(0, comma)));
        if (!value.empty()) values.push_back(value);
        if (comma == rest.npos) break;
        rest.remove_prefix(comma + 1);
      }
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
    std::map<std::string, std::vector<int>> known;
    std::map<std::string, size_t> position;
    std::vector<MeshSet> sets;
    for (const auto& raw : raw_sets_) {
      std::vector<int> members =
          raw->of_nodes ? deck_.nodes_of(raw->ranges) : deck_.faces_of(raw->ranges);
      for (const auto& [name, where] : raw->names) {
        const auto found = known.find(name);
        if (found == known.end())
          file_.fail(where, "found " + in_quotes(name.substr(1)) +
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
    deck_.warn_of_others();
    if (file_.ends_in_mid_line())
      mesh_.warnings.push_back("the file ends in mid-line: it may be cut short");
    if (assembly_blocks_ > 0)
      mesh_.warnings.push_back(
          "nodes and elements of the assembly itself are carried along as text");
  }

  TextMesh& mesh_;
  MeshText& file_;
  DeckMesh deck_;
  std::string_view line_;
  std::vector<std::unique_ptr<RawSet>> raw_sets_;
  std::vector<std::string_view> sections_;
  int parts_ = 0, instances_ = 0, assembly_blocks_ = 0;
  bool in_assembly_ = false;
};

}  // namespace

std::unique_ptr<MeshContent> read_abaqus_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMesh>(MeshText(path));
  mesh->format = "Abaqus input";
  mesh->extensions = {".inp"};
  AbaqusReader(*mesh).read();
  return mesh;
}

}  // namespace batten
