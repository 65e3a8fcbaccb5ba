// Decks as a run edits them: in several files, and where nothing moves.
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

/// A plate of 6 × 6 nodes in the plane xy, its second half in another file.
void plate(const Case& c) {
  std::string first = "BEGIN BULK\nCORD2C,1,,0.,-9.,0.,0.,-9.,1.\n,1.,-9.,0.\n", second, shells;
  for (int i = 0; i < 36; ++i)
    (i < 18 ? first : second) += "GRID," + std::to_string(i + 1) + ",," + std::to_string(i % 6) +
                                 ".," + std::to_string(i / 6) + ".,0.\n";
  for (int i = 0; i < 30; ++i)
    if (i % 6 < 5)
      shells += "CQUAD4," + std::to_string(i + 1) + ",1," + std::to_string(i + 1) + "," +
                std::to_string(i + 2) + "," + std::to_string(i + 8) + "," + std::to_string(i + 7) +
                "\n";
  c.file("plate.bdf", first + "INCLUDE 'parts/half.bdf'\n" + shells + "ENDDATA\n");
  c.file("parts/half.bdf", second + "INCLUDE 'more/last.bdf'\n");
  c.file("parts/more/last.bdf", "GRID    100     1       20.     90.     1.\n");
}

std::string edit(const std::string& move) {
  return "unit = \"mm\"\nmesh = \"plate.bdf\"\n"
         "[[select]]\nname = \"low\"\nbox = [[-1, -1, -1], [9, 0.5, 1]]\n"
         "[[select]]\nname = \"high\"\nbox = [[-1, 4.5, -1], [9, 9, 1]]\n"
         "[[edit]]\nfixed = \"low\"\n[[edit.handle]]\nname = \"high\"\ntranslate = [" +
         move + "]\n";
}

}  // namespace

TEST_CASE("a deck of several files is written beside itself, again and again", "[deform]") {
  const Case c("deform_includes");
  plate(c);
  c.file("edit.toml", edit("0, 1, 0.5"));
  for (int run = 0; run < 2; ++run) {
    const Result r = c.run({"deform", "edit.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto before = batten::MeshFile::read(c / "plate.bdf"),
               after = batten::MeshFile::read(c / "out/plate-deformed.bdf");
    REQUIRE(after.shells().node_count() == 37);
    const int moved = *after.node_of_label(36);
    CHECK((after.shells().points.row(moved) - before.shells().points.row(moved) -
           batten::Vec3(0, 1, 0.5).transpose())
              .norm() < 1e-12);
    CHECK(contents(c / "out/parts/half.bdf") != contents(c / "parts/half.bdf"));
    CHECK(contents(c / "out/parts/more/last.bdf") == contents(c / "parts/more/last.bdf"));
  }
}

TEST_CASE("an edit that moves nothing changes no byte of a deck", "[deform]") {
  const Case c("deform_null");
  plate(c);
  c.file("edit.toml", edit("0, 0, 0") + "[output]\nwide_nodes = true\n");
  REQUIRE(c.run({"deform", "edit.toml", "--out", "out"}).code == 0);
  CHECK(contents(c / "out/plate-deformed.bdf") == contents(c / "plate.bdf"));
  for (const char* name : {"parts/half.bdf", "parts/more/last.bdf"})
    CHECK(contents(c / ("out/" + std::string(name))) == contents(c / name));
}
