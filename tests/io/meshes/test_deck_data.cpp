// SPDX-License-Identifier: MPL-2.0
// Whole decks from practice, if they are available.
#include <algorithm>

#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> public_decks() {
  std::vector<fs::path> files;
  const auto folder = optional_data("decks-public");
  if (folder.empty()) {
    WARN("skipped: no decks-public beside the project (BATTEN_TEST_DATA)");
    return files;
  }
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".bdf" || entry.path().extension() == ".dat")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Number of lines of a text that begin with this card name.
long cards(const std::string& text, const std::string& name) {
  long count = 0;
  for (const std::string& line : lines_of(text))
    count += line.starts_with(name) &&
             (line.size() == name.size() || std::isalnum(line[name.size()]) == 0);
  return count;
}

}  // namespace

TEST_CASE("public decks: nothing moves and no byte changes, what moves is read again",
          "[io][decks][data]") {
  for (const fs::path& path : public_decks()) {
    INFO(path.string());
    check_identity(path);
    const MeshFile file = MeshFile::read(path);
    check_round_trip(path, moved(file, 1e-3, 3), 1e-2);
    MeshWriteOptions wide;
    wide.large_field_nodes = true;
    check_round_trip(path, moved(file, 1e-3, 3), 1e-9, wide);
    // Remaining difference after an edit without motion: rounding of sums.
    const auto target = mesh_scratch() / ("noise_" + path.filename().string());
    Points noise = file.shells().points;
    std::mt19937 random(5);
    const double size = noise.cwiseAbs().maxCoeff();
    for (double& x : noise.reshaped()) x += 5e-14 * size * (random() % 2 ? 1 : -1);
    file.write(target, noise, wide);
    long changed = 0;
    const auto before = lines_of(bytes_of(path)), after = lines_of(bytes_of(target));
    REQUIRE(before.size() == after.size());
    for (size_t i = 0; i < before.size(); ++i) changed += before[i] != after[i];
    CHECK(changed == 0);
  }
}

TEST_CASE("public decks: every card of an element is there with its nodes", "[io][decks][data]") {
  for (const fs::path& path : public_decks()) {
    INFO(path.string());
    const MeshFile file = MeshFile::read(path);
    const std::string text = bytes_of(path);
    std::map<std::string, long> found;
    for (const NonShellElement& element : file.other_elements()) {
      ++found[element.name];
      CHECK(!element.nodes.empty());
      if (element.kind == NonShellElement::Kind::Interpolation)
        CHECK(element.weights.size() + 1 == element.nodes.size());
      if (element.name == "CHEXA") CHECK(element.nodes.size() == 8);
      if (element.name == "CBUSH") CHECK(element.nodes.size() == 2);
    }
    for (const char* name : {"CHEXA", "CBAR", "CBUSH", "CELAS2", "CONM2", "RBE2", "RBE3", "CONROD"})
      CHECK(found[name] == cards(text, name));
  }
}
