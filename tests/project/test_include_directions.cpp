// The dependency table of docs/architecture.md, checked on the include lines themselves.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "batten/tests/catch.h"

namespace fs = std::filesystem;

namespace {

// Which folders a folder may include from, besides itself.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"core", {}},
    {"elements", {"core"}},
    {"fem", {"core", "elements"}},
    {"constraints", {"core"}},
    {"constraints/shape", {"core", "elements", "fem", "constraints"}},
    {"fairing", {"core", "elements", "fem", "constraints", "constraints/shape"}},
    {"skinning", {"core", "elements", "fem", "constraints", "constraints/shape", "fairing"}},
    {"skinning/model",
     {"core", "elements", "fem", "constraints", "constraints/shape", "fairing", "skinning"}},
    {"skinning/network",
     {"core", "elements", "fem", "constraints", "constraints/shape", "fairing", "skinning",
      "skinning/model"}},
    {"sculpting",
     {"core", "elements", "fem", "constraints", "constraints/shape", "fairing", "skinning",
      "skinning/model"}},
    {"mesh", {"core", "constraints"}},
    {"mesh/features", {"core", "mesh"}},
    {"mesh/deform", {"core", "constraints", "mesh"}},
    {"io",
     {"core", "elements", "fem", "constraints", "constraints/shape", "fairing", "skinning",
      "skinning/model", "skinning/network", "sculpting", "mesh", "mesh/features", "mesh/deform"}},
    {"apps",
     {"core", "elements", "fem", "constraints", "constraints/shape", "fairing", "skinning",
      "skinning/model", "skinning/network", "sculpting", "mesh", "mesh/features", "mesh/deform",
      "io"}},
};

// Libraries that only some folders may touch.
const std::map<std::string, std::set<std::string>> kForeign = {
    {"(vtk|BRep|Geom_|TopoDS|STEPControl|IGES|Standard_|gp_|toml|nlohmann)", {"io", "apps"}},
    {"CGAL/", {"skinning", "skinning/network"}},
    {"boost/", {"mesh/features"}},
    {"ceres/", {"fairing"}},
    {"cholmod", {"core"}},
};

std::string folder_of(const std::string& path) {
  for (const char* inner :
       {"constraints/shape", "mesh/deform", "mesh/features", "skinning/model", "skinning/network"})
    if (path.rfind(std::string(inner) + "/", 0) == 0) return inner;
  return path.substr(0, path.find('/'));
}

}  // namespace

TEST_CASE("include lines follow the dependency table") {
  const fs::path root = BATTEN_SOURCE_DIR;
  const std::regex include_line("^\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  int lines = 0;
  for (const auto& [folder, allowed] : kAllowed) {
    REQUIRE(fs::exists(root / folder));
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const fs::path& file = entry.path();
      if (file.extension() != ".h" && file.extension() != ".cpp") continue;
      const std::string relative = fs::relative(file, root).string();
      if (folder_of(relative) != folder) continue;
      std::ifstream in(file);
      std::string line;
      while (std::getline(in, line)) {
        std::smatch match;
        if (!std::regex_search(line, match, include_line)) continue;
        const std::string name = match[1];
        INFO(relative << " includes " << name);
        if (name.rfind("batten/", 0) == 0) {
          ++lines;
          const std::string target = folder_of(name.substr(7));
          CHECK((target == folder || allowed.count(target) == 1));
        } else {
          for (const auto& [pattern, folders] : kForeign)
            if (std::regex_search(name, std::regex("^" + pattern)))
              CHECK(folders.count(folder) == 1);
        }
      }
    }
  }
  CHECK(lines > 50);
}

TEST_CASE("names of test cases have no semicolon, or ctest would not run them") {
  const std::regex name("TEST_CASE\\(\"([^\"]*)\"");
  int cases = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(BATTEN_SOURCE_DIR) / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream in(entry.path());
    std::string line;
    while (std::getline(in, line)) {
      std::smatch match;
      if (!std::regex_search(line, match, name)) continue;
      ++cases;
      INFO(entry.path().string() << ": " << match[1]);
      CHECK(match[1].str().find(';') == std::string::npos);
    }
  }
  CHECK(cases > 200);
}
