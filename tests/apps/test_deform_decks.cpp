// SPDX-License-Identifier: MPL-2.0
// Decks edited by a run: split over several files, and without any motion.
#include <cmath>
#include <optional>

#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/nastran_check.h"

using namespace batten_test;

namespace {

/// A plate of 6 × 6 nodes in the plane xy, its second half in another file.
void plate(const CliCase& c) {
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

/// A public deck, edited: its nodes before and after, both read by our reader.
struct PublicDeck {
  /// None, with a warning, if these decks are not available.
  static std::optional<PublicDeck> edited(const CliCase& c, const std::string& name,
                                          const std::string& scene) {
    const auto folder = optional_data("decks-public");
    if (folder.empty()) {
      WARN("skipped: no decks-public beside the project (BATTEN_TEST_DATA)");
      return {};
    }
    const fs::path from = folder / (name + ".bdf"), to = c / ("out/" + name + "-deformed.bdf");
    c.file("edit.toml", "unit = \"mm\"\nmesh = \"" + from.string() + "\"\n" + scene +
                            "[output]\nlarge_field = true\n");
    const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto json = report(c, "out");
    CHECK(json["failed_checks"].empty());
    CHECK(json["quality"]["inverted"].empty());
    for (const auto& f : json["features"]) CHECK(f["max_rigid_error"].get<double>() < 1e-13);
    check_deck_changes(from, to, 0);
    return PublicDeck{batten::MeshFile::read(from).shells(), batten::MeshFile::read(to).shells(),
                      json["features"].size()};
  }
  batten::Vec3 place(int v) const { return before.points.row(v); }
  batten::Vec3 moved(int v) const { return after.points.row(v) - before.points.row(v); }

  batten::ShellMesh before, after;
  size_t features;
};

}  // namespace

TEST_CASE("a deck of several files is written beside itself, again and again", "[apps][deform]") {
  const CliCase c("deform_includes");
  plate(c);
  c.file("edit.toml", edit("0, 1, 0.5"));
  for (int run = 0; run < 2; ++run) {
    const CliResult r = c.run({"deform", "edit.toml", "--out", "out"});
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

TEST_CASE("an edit that moves nothing changes no byte of a deck", "[apps][deform]") {
  const CliCase c("deform_null");
  plate(c);
  c.file("edit.toml", edit("0, 0, 0") + "[output]\nlarge_field = true\n");
  REQUIRE(c.run({"deform", "edit.toml", "--out", "out"}).code == 0);
  CHECK(contents(c / "out/plate-deformed.bdf") == contents(c / "plate.bdf"));
  for (const char* name : {"parts/half.bdf", "parts/more/last.bdf"})
    CHECK(contents(c / ("out/" + std::string(name))) == contents(c / name));
}

TEST_CASE("one bay of a box becomes a tenth wider, its rib and the other bay stay",
          "[apps][deform][data]") {
  // A box along y with a rib in its middle: property 2, at y = 20.
  const double width = 20, wider = 2;
  for (const bool first : {true, false}) {
    const CliCase c("bay");
    const std::string from = first ? "0.1" : "20.1", to = first ? "19.9" : "39.9";
    const auto deck = PublicDeck::edited(
        c, "Box",
        "[[select]]\nname = \"rib\"\nproperty = \"2\"\n[[feature]]\nname = \"rib\"\n"
        "[[select]]\nname = \"below\"\nplane = { origin = [0, " +
            from +
            ", 0], normal = [0, -1, 0] }\n"
            "[[select]]\nname = \"above\"\nplane = { origin = [0, " +
            to +
            ", 0], normal = [0, 1, 0] }\n"
            "[[edit]]\nfixed = \"below\"\n[[edit.handle]]\nname = \"above\"\n"
            "translate = [0, 2, 0]\n");
    if (!deck) return;
    CHECK(deck->features == 1);
    double beside = 0, other_bay = 0, from_cubic = 0;
    for (int v = 0; v < deck->before.node_count(); ++v) {
      const batten::Vec3 move = deck->moved(v);
      beside = std::max(beside, std::hypot(move.x(), move.z()));
      // The bay is clamped at both ends: the minimum bending energy gives a cubic.
      const double s = (deck->place(v).y() - (first ? 0 : width)) / width;
      if (s < 1e-6 || s > 1 - 1e-6)
        other_bay = std::max(other_bay, std::abs(move.y() - (s < 0.5 ? 0 : wider)));
      else
        from_cubic = std::max(from_cubic, std::abs(move.y() - wider * s * s * (3 - 2 * s)));
    }
    CHECK(beside < 1e-12);
    CHECK(other_bay < 1e-12);  // the rib is the end of both bays
    CHECK(from_cubic < 0.02 * wider);
  }
}

TEST_CASE("the webs of a panel become a tenth higher, bends and skin stay",
          "[apps][deform][data]") {
  // Property 1 is a skin in the plane z = 0, property 2 four webs 50 high below it, in a coordinate
  // system rotated about z; the section bends only where they meet.
  std::string scene =
      "[[select]]\nname = \"skin\"\nproperty = \"1\"\n"
      "[[select]]\nname = \"edges\"\nplane = { origin = [0, 0, -49.9], normal = [0, 0, -1] }\n";
  for (const int y : {1200, 1400, 1600, 1800})
    scene += "[[select]]\nname = \"bend-" + std::to_string(y) +
             "\"\nany = \"skin\"\nproperty = \"2\"\nplane = { origin = [0, " +
             std::to_string(y - 1) + ", 0], normal = [1, 4, 0], within = 2 }\ngrow = 1\n";
  const CliCase c("webs");
  const auto deck =
      PublicDeck::edited(c, "bend_A1_105",
                         scene +
                             "[[features]]\nof = \"bend-*\"\n[[edit]]\nfixed = \"skin\"\n"
                             "[[edit.handle]]\nname = \"edges\"\ntranslate = [0, 0, -5]\n");
  if (!deck) return;
  CHECK(deck->features == 4);
  int edge_nodes = 0;
  for (int v = 0; v < deck->before.node_count(); ++v) {
    const double z = deck->place(v).z();
    const batten::Vec3 move = deck->moved(v);
    CHECK(std::hypot(move.x(), move.y()) < 1e-9);
    // Three rows of elements: the first one is part of the bend.
    if (z > -17) CHECK(move.z() == 0);
    if (z < -17 && z > -49) CHECK(move.z() == Approx(-2.5).margin(0.5));
    if (z < -49) CHECK(move.z() == Approx(-5).epsilon(1e-9));
    edge_nodes += z < -49;
  }
  CHECK(edge_nodes == 4 * 56);
}
