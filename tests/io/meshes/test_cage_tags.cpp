// SPDX-License-Identifier: MPL-2.0
// Tags of control cages in OBJ files: creases, and messages with the position of unsupported tags.
#include <fstream>

#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A cage of two quads followed by some tags, from line 9 on.
MeshFile cage(const std::string& tags) {
  const fs::path file = scratch("cage_tags") / "cage.obj";
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
                         "f 1 2 5 4\nf 2 3 6 5\n"
                      << tags;
  return MeshFile::read(file);
}

}  // namespace

TEST_CASE("creases and corners count their nodes from 0", "[io][meshes][cage]") {
  const MeshFile file = cage(
      "t crease 2/1/0 1 4 2.5\nt corner 2/1/0 0 3 10\nt corner 2/2/0 1 2 0.5 1\n"
      "t interpolateboundary 1/0/0 1\nt facevaryinginterpolateboundary 1/0/0 1\n"
      "t creasemethod 0/0/1 normal\n");
  const CageTags& tags = file.cage_tags();
  REQUIRE(tags.creases.size() == 1);
  CHECK(tags.creases[0].a == 1);
  CHECK(tags.creases[0].b == 4);
  CHECK(tags.creases[0].sharpness == 2.5);
  REQUIRE(tags.corners.size() == 4);
  CHECK(tags.corners[1].node == 3);
  CHECK(tags.corners[1].sharpness == 10);
  CHECK(tags.corners[2].sharpness == 0.5);
  CHECK(tags.corners[3].sharpness == 1);
  CHECK(cage("").cage_tags().creases.empty());
}

TEST_CASE("the creases of OpenSubdiv's car are edges of its cage, and its limit keeps them",
          "[io][meshes][cage]") {
  const fs::path data = optional_data("cage-opensubdiv-car");
  if (data.empty()) {
    WARN("no cage-opensubdiv-car beside the project: skipped");
    return;
  }
  const MeshFile file = MeshFile::read(data / "catmark_car.obj");
  const CageTags& tags = file.cage_tags();  // all are edges: counted from 1, few would be
  CHECK(tags.creases.size() == 314);
  const ShellMesh once = catmull_clark(file.shells(), {1, tags}),
                  twice = catmull_clark(file.shells(), {2, tags}),
                  smooth = catmull_clark(file.shells(), {1});
  const double size = (once.points.colwise().maxCoeff() - once.points.colwise().minCoeff()).norm();
  CHECK((once.points - twice.points.topRows(once.node_count())).cwiseAbs().maxCoeff() <
        1e-13 * size);
  CHECK((once.points - smooth.points).cwiseAbs().maxCoeff() > 1e-3 * size);
}

TEST_CASE("unsupported tags are named with file and line, only for cages", "[io][meshes][cage]") {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"t crease 2/1/0 1 5 2", "expected an edge of a face"},
      {"t crease 2/1/0 1 9 2", "expected 0 to 5"},
      {"t crease 3/2/0 0 1 2 2 2", "two nodes and a sharpness"},
      {"t crease 2/1/0 1 4", "found 2 words behind '2/1/0'"},
      {"t crease 2/1/0 1 4 -1", "expected 0 or more"},
      {"t crease 2/1/0 1 4 sharp", "sharp"},
      {"t crease 2/1 1 4 1", "counts as 2/1/0"},
      {"t crease", "counts"},
      {"t crease 2/1/9223372036854775807 1 4 1", "counts as 2/1/0"},
      {"t corner 0/1/0 1", "a sharpness for each or for all"},
      {"t hole 1/0/0 1", "the tag 'hole'"},
      {"t creasemethod 0/0/1 chaikin", "chaikin"},
      {"t interpolateboundary 1/0/0 2", "boundary edges of a cage and their corners are sharp"},
      {"t interpolateboundary 1/0/0 0", "boundary edges of a cage and their corners are sharp"}};
  for (const auto& [tag, why] : wrong) {
    INFO(tag);
    const MeshFile file = cage("t corner 1/1/0 0 1\n" + tag + "\n");
    CHECK(file.shells().face_count() == 2);
    const std::string message = error_message([&] { file.cage_tags(); });
    CHECK_THAT(message, Contains("cage.obj:10:") && Contains(why));
  }
}
