// SPDX-License-Identifier: MPL-2.0
// Checks the include directives against the table of components in docs/architecture.md.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "batten/tests/support/catch.h"

namespace fs = std::filesystem;

namespace {

const fs::path root = BATTEN_SOURCE_DIR;

/// What a component may use: components, and external libraries.
struct Component {
  std::set<std::string> components, foreign;
};

/// Rows "| `component` | holds | `component`, Library |". A component may also use everything that
/// the listed components may use; libraries only if they are listed. "all above": every component
/// before it.
std::map<std::string, Component> read_components() {
  std::ifstream in(root / "docs/architecture.md");
  const std::regex row("^\\| `([a-z_/]+)` \\|.*\\| ([^|]*) \\|$"), word("[^, ][^,]*");
  std::map<std::string, Component> components;
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    Component component;
    const std::string uses = match[2];
    for (std::sregex_iterator it(uses.begin(), uses.end(), word), end; it != end; ++it) {
      const std::string name = it->str();
      if (name == "all above")
        for (const auto& [above, other] : components) component.components.insert(above);
      else if (name.front() != '`')
        component.foreign.insert(name);
      else if (const std::string used = name.substr(1, name.size() - 2); components.count(used)) {
        component.components.insert(used);
        component.components.insert(components.at(used).components.begin(),
                                    components.at(used).components.end());
      } else {
        FAIL("the row of " << match[1] << " uses " << used << ", which has no row above it");
      }
    }
    components[match[1]] = component;
  }
  return components;
}

/// Beginnings of the include paths of external libraries.
const std::map<std::string, std::string> kForeign = {
    {"CHOLMOD", "cholmod"},
    {"CGAL", "CGAL/"},
    {"Ceres", "ceres/"},
    {"Boost.Graph", "boost/graph/"},
    {"Boost.Geometry", "boost/geometry"},
    {"PETSc", "petsc"},
    {"Spectra", "Spectra/"},
    {"VTK", "vtk"},
    {"toml++", "toml"},
    {"nlohmann-json", "nlohmann"},
    {"giflib", "gif_lib"},
    {"lib3mf", "Model/COM/NMR"},
    {"OpenCASCADE", "(BRep|Geom|Topo|STEP|IGES|Standard_|gp_|TCol|XS|Interface_|Shape)"},
};

/// The component of a file: the innermost folder that has a row.
std::string component_of(std::string path, const std::map<std::string, Component>& components) {
  while (path.find('/') != std::string::npos) {
    path.erase(path.rfind('/'));
    if (components.count(path)) return path;
  }
  return path;
}

struct File {
  std::string path;                   // relative to the root
  std::vector<std::string> includes;  // as written
};

std::vector<File> source_files() {
  const std::regex include_line("^\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  std::vector<File> files;
  for (const char* folder : {"core", "elements", "fem", "constraints", "analysis", "fairing",
                             "skinning", "sculpting", "mesh", "io", "scenes", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
      File file{fs::relative(entry.path(), root).string(), {}};
      std::ifstream in(entry.path());
      std::smatch match;
      for (std::string line; std::getline(in, line);)
        if (std::regex_search(line, match, include_line)) file.includes.push_back(match[1]);
      files.push_back(std::move(file));
    }
  return files;
}

/// A file's name without its extension: a header and its source count as one, and so does the header
/// of the private data of a class, NAME_data.h beside NAME.h.
std::string stem(const std::string& path) {
  const std::string name = path.substr(0, path.rfind('.')), data = "_data";
  if (!name.ends_with(data)) return name;
  const std::string owner = name.substr(0, name.size() - data.size());
  return fs::exists(root / (owner + ".h")) ? owner : name;
}

}  // namespace

TEST_CASE("include directives follow the table of modules", "[project][includes]") {
  const auto components = read_components();
  REQUIRE(components.size() > 20);
  for (const auto& [name, component] : components) REQUIRE(fs::is_directory(root / name));
  int lines = 0;
  for (const File& file : source_files()) {
    const std::string name = component_of(file.path, components);
    INFO(file.path << " is in the module " << name);
    REQUIRE(components.count(name) == 1);
    const Component& component = components.at(name);
    for (const std::string& include : file.includes) {
      INFO("it includes " << include);
      if (include.rfind("batten/", 0) == 0) {
        ++lines;
        const std::string used = component_of(include.substr(7), components);
        CHECK((used == name || component.components.count(used) == 1));
      } else {
        for (const auto& [library, pattern] : kForeign)
          if (std::regex_search(include, std::regex("^" + pattern)))
            CHECK(component.foreign.count(library) == 1);
      }
    }
  }
  CHECK(lines > 1000);
}

TEST_CASE("include directives form no cycle", "[project][includes]") {
  std::map<std::string, std::set<std::string>> uses;
  for (const File& file : source_files())
    for (const std::string& include : file.includes)
      if (include.rfind("batten/", 0) == 0) {
        const std::string used = stem(include.substr(7));
        if (used != stem(file.path)) uses[stem(file.path)].insert(used);
      }
  std::map<std::string, int> state;  // 1: in progress, 2: done
  std::vector<std::string> way;
  const std::function<void(const std::string&)> visit = [&](const std::string& file) {
    state[file] = 1;
    way.push_back(file);
    for (const std::string& used : uses[file]) {
      if (state[used] == 0) visit(used);
      if (state[used] == 1 && std::find(way.begin(), way.end(), used) != way.end()) {
        std::string circle;
        for (auto it = std::find(way.begin(), way.end(), used); it != way.end(); ++it)
          circle += *it + " → ";
        FAIL_CHECK(circle << used);
      }
    }
    way.pop_back();
    state[file] = 2;
  };
  const auto all = uses;
  for (const auto& [file, used] : all)
    if (state[file] == 0) visit(file);
}

TEST_CASE("names of test cases have no semicolon or bracket, or ctest would not run them",
          "[project][includes]") {
  const std::regex name("TEST_CASE\\(\"([^\"]*)\"");
  int cases = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream in(entry.path());
    std::string line;
    while (std::getline(in, line)) {
      std::smatch match;
      if (!std::regex_search(line, match, name)) continue;
      ++cases;
      INFO(entry.path().string() << ": " << match[1]);
      CHECK(match[1].str().find_first_of(";[") == std::string::npos);
    }
  }
  CHECK(cases > 200);
}
