// SPDX-License-Identifier: MPL-2.0
// Reads Gmsh's text files (MSH 2.2 and 4.1). The program gmsh converts everything else: binary
// files, other versions, and universal files (UNV).
#include <algorithm>
#include <map>
#include <ostream>
#include <set>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/external_program.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/temporary_folder.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// An element type of Gmsh: the dimension, the number of nodes and, for shells, that of corners.
struct GmshType {
  int dimension, nodes, corners = 0;
  bool has_centre = false;
};

const std::map<long, GmshType>& gmsh_types() {
  static const std::map<long, GmshType> all{
      {1, {1, 2}},     {2, {2, 3, 3}}, {3, {2, 4, 4}}, {4, {3, 4}},    {5, {3, 8}},
      {6, {3, 6}},     {7, {3, 5}},    {8, {1, 3}},    {9, {2, 6, 3}}, {10, {2, 9, 4, true}},
      {11, {3, 10}},   {12, {3, 27}},  {13, {3, 18}},  {14, {3, 14}},  {15, {0, 1}},
      {16, {2, 8, 4}}, {17, {3, 20}},  {18, {3, 15}},  {19, {3, 13}}};
  return all;
}

/// Reads MSH 2.2 and 4.1 as text.
class GmshReader {
 public:
  explicit GmshReader(TextMeshContent& mesh) : mesh_(mesh), file_(mesh.file), deck_(mesh) {}

  void read() {
    while (next_line())
      if (const std::string_view name = trimmed(line_); name.starts_with('$')) {
        section_ = name.substr(1);
        read_section();
        skip_to_end_of_section();
      }
    deck_.finish();
    add_sets();
    add_elements_without_shells();
    deck_.warn_about_other_elements();
    if (is_partitioned_)
      mesh_.warnings.push_back("physical groups of partitioned entities are not read");
  }

 private:
  using Group = std::pair<int, long>;  // dimension and number of a physical group

  /// An element that is not a shell.
  struct Other {
    int dimension;
    long label;
    std::string_view where;
    std::vector<long> nodes;
  };

  bool next_line() {
    while (file_.next(line_))
      if (!trimmed(line_).empty()) {
        rest_ = line_;
        return true;
      }
    return false;
  }
  void require_line() {
    if (!next_line())
      file_.fail_at_end("found the end of the file in $" + std::string(section_) +
                        ", expected $End" + std::string(section_));
  }
  /// The next number; numbers may continue on the next line.
  std::string_view token() {
    std::string_view found = next_token(rest_);
    while (found.empty()) {
      require_line();
      found = next_token(rest_);
    }
    return found;
  }
  long integer(const char* expected = "an integer") { return file_.integer(token(), expected); }
  long count() {
    const std::string_view text = token();
    const long value = file_.integer(text, "a number of entries");
    if (value < 0) file_.fail(text, "found " + quoted_excerpt(text) + ", expected 0 or more");
    return value;
  }

  void skip_to_end_of_section() {
    while (trimmed(line_) != "$End" + section_)
      if (!next_line()) return;
  }

  void read_section() {
    if (section_ == "MeshFormat") {
      require_line();
      is_version_4_ = trimmed(line_).starts_with('4');
    } else if (section_ == "PhysicalNames") {
      names();
    } else if (section_ == "Entities") {
      entities();
    } else if (section_ == "PartitionedEntities") {
      is_partitioned_ = true;
    } else if (section_ == "Nodes") {
      is_version_4_ ? node_blocks() : node_list();
    } else if (section_ == "Elements") {
      is_version_4_ ? element_blocks() : element_list();
    }
  }

  void names() {
    require_line();
    for (long n = count(); n > 0; --n) {
      require_line();
      const int dimension = static_cast<int>(integer());
      const long number = integer();
      std::string_view name = trimmed(rest_);
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"')
        name = name.substr(1, name.size() - 2);
      names_[{dimension, number}] = name;
    }
  }

  void entities() {
    constexpr int dimensions = 4;
    std::array<long, dimensions> counts{};
    require_line();
    for (long& n : counts) n = count();
    for (int dimension = 0; dimension < dimensions; ++dimension)
      for (; counts[dimension] > 0; --counts[dimension]) {
        require_line();
        const long tag = integer();
        const int coordinates = dimension == 0 ? 3 : 6;  // of a point, or of a bounding box
        for (int i = 0; i < coordinates; ++i) token();
        for (long n = count(); n > 0; --n)  // negative: with reversed orientation
          groups_of_[{dimension, tag}].push_back(std::abs(integer("a physical group")));
      }
  }

  void node(std::string_view label, std::string_view where) {
    std::array<double, 3> xyz{};
    std::array<Field, 3> fields;
    for (int c = 0; c < 3; ++c) {
      const std::string_view text = next_token(rest_);
      xyz[c] = file_.real(text.empty() ? where.substr(where.size()) : text);
      fields[c].begin = file_.offset(text);
      fields[c].length = static_cast<std::uint32_t>(text.size());
    }
    deck_.add_node(file_.integer(label, "a node number"), label, xyz, fields);
  }

  void node_list() {
    require_line();
    for (long n = count(); n > 0; --n) {
      require_line();
      const std::string_view label = next_token(rest_);
      node(label, line_);
    }
  }

  void node_blocks() {
    require_line();
    const long blocks = count();
    for (long block = 0; block < blocks; ++block) {
      require_line();
      token(), token(), token();  // dimension, entity, parametric
      const long nodes = count();
      std::vector<std::string_view> labels;
      for (long i = 0; i < nodes; ++i) {
        require_line();
        labels.push_back(token());
      }
      for (const std::string_view label : labels) {
        require_line();
        node(label, line_);
      }
    }
  }

  const GmshType& type_of(std::string_view text) {
    const auto found = gmsh_types().find(file_.integer(text, "an element type"));
    if (found == gmsh_types().end())
      file_.fail(text, "found element type " + quoted_excerpt(text) +
                           ", expected an element of first or second order (types 1 to 19)");
    return found->second;
  }

  void element_list() {
    require_line();
    for (long n = count(); n > 0; --n) {
      require_line();
      const std::string_view label = token();
      const GmshType& type = type_of(token());
      std::vector<long> tags;
      for (long i = count(); i > 0; --i) tags.push_back(integer("a tag"));
      std::vector<long> groups;
      if (!tags.empty() && tags[0] != 0) groups.push_back(std::abs(tags[0]));
      element(label, type, tags.size() > 1 ? tags[1] : 0, groups);
    }
  }

  void element_blocks() {
    require_line();
    const long blocks = count();
    for (long block = 0; block < blocks; ++block) {
      require_line();
      const int dimension = static_cast<int>(integer());
      const long entity = integer();
      const GmshType& type = type_of(token());
      const std::vector<long>& groups = groups_of_[{dimension, entity}];
      for (long n = count(); n > 0; --n) {
        require_line();
        element(token(), type, entity, groups);
      }
    }
  }

  void element(std::string_view where, const GmshType& type, long entity,
               const std::vector<long>& groups) {
    const long label = file_.integer(where, "an element number");
    std::vector<long> nodes;
    for (int i = 0; i < type.nodes; ++i) {
      const std::string_view text = next_token(rest_);
      nodes.push_back(
          file_.integer(text.empty() ? line_.substr(line_.size()) : text, "a node number"));
    }
    long first = label;
    if (!is_version_4_)  // repeats an element for each further group
      first = element_of_nodes_.emplace(nodes, label).first->second;
    for (const long group : groups) {
      Members& members = members_[{type.dimension, group}];
      if (type.dimension == 2)
        members.shells.push_back(first);
      else
        members.nodes.insert(members.nodes.end(), nodes.begin(), nodes.end());
    }
    if (first != label) return;
    if (type.dimension == 2)
      shell(where, label, type, entity, nodes);
    else
      others_.push_back({type.dimension, label, where, std::move(nodes)});
  }

  void shell(std::string_view where, long label, const GmshType& type, long entity,
             const std::vector<long>& nodes) {
    const auto corners = static_cast<size_t>(type.corners);
    const size_t middle = type.nodes > type.corners ? corners : 0;
    deck_.add_shell(label, where, std::to_string(entity), {nodes.data(), corners},
                    {nodes.data() + corners, middle});
    if (!type.has_centre) return;
    // The centre moves like the nodes around it.
    DeckElement centre{NonShellElement::Kind::Interpolation,
                       "centre of nine-node shells",
                       label,
                       where,
                       {nodes.back()},
                       std::vector<double>(nodes.size() - 1, 1)};
    centre.nodes.insert(centre.nodes.end(), nodes.begin(), nodes.end() - 1);
    deck_.add_element(std::move(centre));
  }

  void add_sets() {
    for (const auto& [group, members] : members_) {
      const auto name = names_.find(group);
      MeshSet set{name != names_.end() ? name->second : std::to_string(group.second), "", {}, {}};
      set.nodes = deck_.nodes_of(ranges_of(members.nodes));
      set.faces = deck_.faces_of(ranges_of(members.shells));
      if (!set.nodes.empty() || !set.faces.empty()) mesh_.sets.push_back(std::move(set));
    }
  }
  static std::vector<LabelRange> ranges_of(const std::vector<long>& labels) {
    std::vector<LabelRange> ranges;
    for (const long label : labels) ranges.push_back({label, label});
    return ranges;
  }

  /// Points, and lines between nodes of shells, only mark places of the mesh.
  void add_elements_without_shells() {
    std::vector<char> used(static_cast<size_t>(mesh_.shells.node_count()), 0);
    for (int f = 0; f < mesh_.shells.face_count(); ++f)
      for (const int node : mesh_.shells.face(f)) used[node] = 1;
    constexpr std::array<const char*, 4> kinds{"point", "line", "", "solid"};
    for (const Other& other : others_) {
      NonShellElement element{
          other.dimension == 3 ? NonShellElement::Kind::Solid : NonShellElement::Kind::Beam,
          kinds[other.dimension],
          other.label,
          {},
          {}};
      for (const long label : other.nodes) {
        const auto node = mesh_.node_labels.find(label);
        if (!node)
          file_.fail(other.where, "found node " + std::to_string(label) + " in element " +
                                      std::to_string(other.label) +
                                      ", expected the number of a node");
        element.nodes.push_back(*node);
      }
      const bool marks = std::all_of(element.nodes.begin(), element.nodes.end(),
                                     [&](int node) { return used[node] != 0; });
      if (other.dimension == 0 || (other.dimension == 1 && marks)) continue;
      deck_.count_other_element(element.name);
      mesh_.other_elements.push_back(std::move(element));
    }
  }

  struct Members {
    std::vector<long> nodes, shells;
  };

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  DeckMeshBuilder deck_;
  std::string_view line_, rest_;
  std::string section_;
  bool is_version_4_ = false, is_partitioned_ = false;
  std::map<Group, std::string> names_;
  std::map<std::pair<int, long>, std::vector<long>> groups_of_;  // of an entity
  std::map<Group, Members> members_;
  std::map<std::vector<long>, long> element_of_nodes_;  // MSH 2.2 only
  std::vector<Other> others_;
};

/// The first words of a file: "$MeshFormat", the version, and 1 if it is binary.
std::array<std::string, 3> header_of(std::string_view content) {
  std::string start(content.substr(0, 200));
  std::replace_if(
      start.begin(), start.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::string_view rest = start;
  std::array<std::string, 3> words;
  for (std::string& word : words) word = next_token(rest);
  return words;
}

/// True for the text formats that GmshReader reads.
bool is_plain_text(std::string_view content) {
  const auto [first, version, binary] = header_of(content);
  return first == "$MeshFormat" && binary == "0" && (version == "4.1" || version.starts_with("2"));
}

/// Converts a file by the program gmsh.
void convert_by_gmsh(const fs::path& from, const std::string& format, const fs::path& to,
                     const fs::path& shown, bool is_binary = false) {
  const fs::path log = to.parent_path() / "gmsh.log";
  std::vector<std::string> arguments{from.string(), "-0", "-save_all", "-format",
                                     format,        "-o", to.string()};
  if (is_binary) arguments.emplace_back("-bin");
  int status = 0;
  try {
    status = run_external_program({"gmsh", "GMSH", "Gmsh (package gmsh), to convert this file,"},
                                  arguments, to.parent_path(), log);
  } catch (const InputError& error) {
    throw InputError(shown.string() + ": " + error.what());
  }
  std::error_code none;
  if (status == 0 && fs::exists(to, none)) return;
  std::string reason = "it ended with status " + std::to_string(status);
  if (fs::exists(log, none) && input_file_size(log) > 0) {
    const std::string text = read_input_file(log, "a log");
    if (const auto error = text.find("Error"); error != text.npos)
      reason = trimmed(std::string_view(text).substr(error, text.find('\n', error) - error));
  }
  throw InputError(shown.string() + ": Gmsh cannot convert this file: " + reason);
}

/// A mesh that gmsh has converted to MSH 4.1, and converts back after an edit.
struct ConvertedGmshMesh : TextMeshContent {
  using TextMeshContent::TextMeshContent;
  MeshRounding write(const fs::path& path, const Points& points,
                     const MeshWriteOptions& options) const override {
    const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
    const TemporaryFolder folder(parent, "batten-gmsh");
    const fs::path edited = folder.path() / "edited.msh",
                   result = folder.path() / ("result" + path.extension().string());
    MeshRounding rounding = TextMeshContent::write(edited, points, options);
    const std::string text = read_input_file(edited, "a mesh");
    const auto write = [&](const std::string& content) {
      write_file_atomically(path, [&](std::ostream& out) { out << content; });
    };
    if (text == converted) {  // no coordinate has changed
      write(original);
      return rounding;
    }
    if (gmsh_format.empty()) {
      write(text);
      rounding.notes.push_back(path.filename().string() +
                               " is MSH 4.1 as text: gmsh cannot write the older version of the "
                               "input without losing physical groups");
      return rounding;
    }
    convert_by_gmsh(edited, gmsh_format, result, path, is_binary);
    write(read_input_file(result, "a mesh"));
    return rounding;
  }
  std::string original, converted;  ///< bytes of the file, and the text that gmsh made of it
  std::string gmsh_format;  ///< argument of gmsh's option -format; empty: the text is written
  bool is_binary = false;
};

/// The format in which gmsh writes a file back, and whether it is binary. Versions before 4 get an
/// empty name, because gmsh writes their physical groups only without the other elements.
std::pair<std::string, bool> gmsh_format_of(std::string_view content, const fs::path& path) {
  if (lower_extension(path) == ".unv") return {"unv", false};
  const auto [first, version, binary] = header_of(content);
  // Gmsh executes any other text as a script.
  if (first != "$MeshFormat" && first != "$NOD")
    throw InputError(path.string() + ": found " + quoted_excerpt(first) +
                     ", expected a Gmsh mesh, which begins with $MeshFormat");
  if (first == "$NOD" || !version.starts_with('4')) return {"", false};
  return {version == "4.1" ? "msh41" : "msh40", binary == "1"};
}

std::unique_ptr<TextMeshContent> read_converted(const fs::path& path, std::string_view content) {
  const auto [format, is_binary] = gmsh_format_of(content, path);
  // A copy: gmsh also executes a file beside its input that has the same name and the ending .opt.
  const TemporaryFolder folder(fs::temp_directory_path(), "batten-gmsh");
  const fs::path text = folder.path() / "converted.msh",
                 copy = folder.path() / ("original" + lower_extension(path));
  write_file_atomically(copy, [&](std::ostream& out) { out << content; });
  convert_by_gmsh(copy, "msh41", text, path);
  std::string converted = read_input_file(text, "a mesh");
  auto mesh = std::make_unique<ConvertedGmshMesh>(MeshSourceText(path, converted, false));
  mesh->original = content;
  mesh->converted = std::move(converted);
  mesh->gmsh_format = format;
  mesh->is_binary = is_binary;
  return mesh;
}

}  // namespace

std::unique_ptr<MeshContent> read_gmsh_mesh(const fs::path& path) {
  std::string content = read_input_file(path, "a mesh");
  std::unique_ptr<TextMeshContent> mesh;
  if (is_plain_text(content))
    mesh = std::make_unique<TextMeshContent>(MeshSourceText(path, std::move(content), false));
  else
    mesh = read_converted(path, content);
  const bool is_universal = lower_extension(path) == ".unv";
  mesh->format = is_universal ? "universal file" : "Gmsh mesh";
  mesh->extensions = {is_universal ? ".unv" : ".msh"};
  GmshReader(*mesh).read();
  return mesh;
}

}  // namespace batten
