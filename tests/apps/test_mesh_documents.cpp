// SPDX-License-Identifier: MPL-2.0
// Documents of meshes: successive edits, interactive, with undo, and equal to the results of
// `batten deform`.
#include "batten/apps/documents/document.h"
#include "batten/apps/documents/edited_mesh.h"
#include "batten/apps/documents/mesh_edits.h"
#include "batten/scenes/commands.h"
#include "batten/tests/apps/cli_case.h"

#include <algorithm>

using namespace batten;
using namespace batten_test;
using CommandKind = DocumentCommand::CommandKind;

namespace {

const fs::path kPanel = BATTEN_SOURCE_DIR "/examples/11-panel";

DocumentCommand slid(const std::string& name, double value) {
  return {.kind = CommandKind::SetSlider, .key = name, .value = value};
}
DocumentCommand added(const std::string& kind, const std::string& table) {
  return {.kind = CommandKind::Add, .table = {kind, ""}, .text = table};
}
void act(Document& document, const std::vector<DocumentCommand>& commands) {
  for (const DocumentCommand& command : commands) document.apply(command);
}

/// The panel with its holes kept, its left end fixed and its right end as a handle.
Document panel() {
  Document document;
  document.apply({.kind = CommandKind::Open, .file = kPanel / "panel.bdf"});
  act(document, {added("select", R"({ name = "left", box = [[-1, -1, -100], [1, 401, 100]] })"),
                 added("select", R"({ name = "right", box = [[599, -1, -100], [601, 401, 100]] })"),
                 added("features", R"({ of = ["hole-*"] })"),
                 {.kind = CommandKind::Set,
                  .table = {"edit", "edit 1"},
                  .key = "fixed",
                  .text = "[\"left\"]"},
                 added("edit.handle", R"({ name = "right" })")});
  return document;
}

/// Result of `batten deform` for a document's text.
std::string deformed(const Document& document, const CliCase& folder) {
  const DeformScene scene = parse_deform_scene(document.text().text(), folder / "s.toml");
  run_deform(scene, folder / "out");
  return contents(folder / "out" / scene.mesh_out);
}

std::string exported(Document& document, const CliCase& folder) {
  document.apply({.kind = CommandKind::Export, .file = folder / "shape.bdf"});
  return contents(folder / "shape.bdf");
}

}  // namespace

TEST_CASE("a mesh edited interactively is the same as that of batten deform for its scene",
          "[apps][documents]") {
  const CliCase folder("mesh_live");
  Document document = panel();
  REQUIRE(document.mesh());
  const Points rest = document.mesh()->shape();
  CHECK((rest - document.mesh()->source().prepared.mesh.points()).isZero(0));
  for (const double lift : {5.0, 20.0, 40.0}) {
    act(document, {slid("edit 1.right.z", lift), {.kind = CommandKind::SolvePreview}});
    CHECK(document.mesh()->shape().col(2).maxCoeff() > rest.col(2).maxCoeff());
  }
  act(document, {slid("edit 1.right.rotation.y", -30),
                 slid("edit 1.right.rotation.x", 4),
                 {.kind = CommandKind::SolvePreview},
                 {.kind = CommandKind::SolveToEquilibrium}});
  const std::string text = document.text().text();
  CHECK(text.find("translate = [0, 0, 40]") != std::string::npos);
  CHECK(text.find("angle = 30.26") != std::string::npos);
  const std::string deck = exported(document, folder);
  CHECK(deck == deformed(document, folder));
  CHECK(deck != contents(kPanel / "panel.bdf"));

  const Points shape = document.mesh()->shape();
  document.apply({.kind = CommandKind::Undo});
  CHECK((document.mesh()->shape() - rest).isZero(0));
  document.apply({.kind = CommandKind::Redo});
  CHECK((document.mesh()->shape() - shape).isZero(0));
  document.apply({.kind = CommandKind::Save, .file = folder / "panel.toml"});
  Document again;
  again.apply({.kind = CommandKind::Open, .file = folder / "panel.toml"});
  CHECK(again.content().problem().empty());
  CHECK((again.mesh()->shape() - shape).isZero(0));
}

TEST_CASE("a scene that is saved beside its mesh names it as a person does", "[apps][documents]") {
  const CliCase folder("mesh_beside");
  std::filesystem::copy_file(kPanel / "panel.bdf", folder / "panel.bdf");
  std::filesystem::create_directories(folder / "else");
  Document document;
  document.apply({.kind = CommandKind::Open, .file = folder / "panel.bdf"});
  document.apply({.kind = CommandKind::Export, .file = folder / "first.bdf"});
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::Export, .file = folder / "panel.bdf"}),
                  InputError);
  document.apply({.kind = CommandKind::Save, .file = folder / "else/far.toml"});
  CHECK(document.text().value({}, "mesh") ==
        SceneText::toml_value((folder / "panel.bdf").string()));
  document.apply({.kind = CommandKind::Open, .file = folder / "panel.bdf"});
  document.apply({.kind = CommandKind::Save, .file = folder / "panel.toml"});
  CHECK(document.text().value({}, "mesh") == "\"panel.bdf\"");
  Document again;
  again.apply({.kind = CommandKind::Open, .file = folder / "panel.toml"});
  CHECK(again.mesh());
  // Its mesh is not overwritten: the scene would move it twice.
  const std::string deck = contents(folder / "panel.bdf");
  std::filesystem::create_symlink("panel.bdf", folder / "linked.bdf");
  for (const char* file : {"panel.bdf", "else/../panel.bdf", "linked.bdf"})
    CHECK_THROWS_AS(again.apply({.kind = CommandKind::Export, .file = folder / file}), InputError);
  CHECK(contents(folder / "panel.bdf") == deck);
  again.apply({.kind = CommandKind::Export, .file = folder / "other.bdf"});
}

TEST_CASE("numbers of a handle have the units that they are moved in", "[apps][documents]") {
  Document document = panel();
  act(document, {{.kind = CommandKind::Set,
                  .table = {"edit.handle", "edit 1.right"},
                  .key = "rotate",
                  .text = "{ axis = [0, 1, 0], angle = 5 }"}});
  for (const auto& slider : view_of(document).sliders) {
    INFO(slider.name);
    const bool turns =
        slider.name.ends_with(".angle") || slider.name.find(".rotation.") != std::string::npos;
    CHECK(slider.unit == (turns ? "°" : slider.name.ends_with(".scale") ? "" : "mm"));
  }
}

TEST_CASE("numbers of an edit change the edits behind it", "[apps][documents]") {
  const CliCase folder("mesh_edits");
  Document document = panel();
  act(document, {slid("edit 1.right.z", 25),
                 {.kind = CommandKind::SolveToEquilibrium},
                 added("edit", R"({ name = "edit 2", fixed = ["left"] })"),
                 added("edit.handle", R"({ name = "hole-3" })"),
                 slid("edit 2.hole-3.z", 4),
                 {.kind = CommandKind::SolveToEquilibrium}});
  CHECK_FALSE(document.content().moves("edit 1.right.z"));
  CHECK(document.content().moves("edit 2.hole-3.z"));
  CHECK(exported(document, folder) == deformed(document, folder));
  const Points before = document.mesh()->shape();
  for (const double lift : {27.0, 28.0, 30.0}) document.apply(slid("edit 1.right.z", lift));
  document.apply({.kind = CommandKind::SolveToEquilibrium});  // one undo step
  CHECK((document.mesh()->shape() - before).col(2).maxCoeff() > 4);
  CHECK(exported(document, folder) == deformed(document, folder));
  document.apply({.kind = CommandKind::Undo});
  CHECK((document.mesh()->shape() - before).isZero(0));

  // A value that is invalid for the first edit does not change the second one.
  Document both = panel();
  act(both, {added("edit.handle", R"({ name = "left" })"),
             added("edit", R"({ name = "edit 2", fixed = ["left"] })"),
             added("edit.handle", R"({ name = "hole-3" })"),
             slid("edit 2.hole-3.z", 4),
             {.kind = CommandKind::SolveToEquilibrium}});
  const Points shape = both.mesh()->shape();
  CHECK_THROWS_AS(both.apply(slid("edit 1.left.z", 1)), ConflictError);
  CHECK((both.mesh()->shape() - shape).isZero(0));
  CHECK(both.content().moves("edit 2.hole-3.z"));
}

TEST_CASE("invalid edits of a mesh are refused and leave everything unchanged",
          "[apps][documents]") {
  Document document = panel();
  act(document, {slid("edit 1.right.z", 10), {.kind = CommandKind::SolveToEquilibrium}});
  const std::string text = document.text().text();
  const Points shape = document.mesh()->shape();
  CHECK_THROWS_AS(document.apply(added("feature", R"({ name = "no such thing" })")), InputError);
  CHECK_THROWS_AS(document.apply(slid("edit 1.right.scale", 0)), InputError);
  CHECK_THROWS_AS(document.apply(slid("edit 1.left.z", 1)), InputError);
  // A handle on fixed nodes contradicts them as soon as it moves.
  document.apply(added("edit.handle", R"({ name = "left" })"));
  document.apply(slid("edit 1.left.z", 1));
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::SolveToEquilibrium}), ConflictError);
  document.apply({.kind = CommandKind::Undo});
  CHECK(document.text().text() == text);
  CHECK((document.mesh()->shape() - shape).isZero(0));
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::Open, .file = kPanel / "README.md"}),
                  InputError);
  CHECK(document.mesh());
}

TEST_CASE("parts of a mesh are made features, handles, fixed, and let go again",
          "[apps][documents]") {
  Document document;
  document.apply({.kind = CommandKind::Open, .file = kPanel / "panel.bdf"});
  const std::string opened = document.text().text();
  document.apply(added("features", R"({ of = ["hole-*"] })"));
  const auto mesh = [&] { return *view_of(document).mesh; };
  const auto use = [&](const std::string& part, PartUse what) {
    act(document, use_edits(document.text(), mesh(), part, what));
    CHECK(use_of(document.text(), part) == what);
  };
  CHECK(use_of(document.text(), "hole-2") == PartUse::Rigid);
  use("hole-2", PartUse::Free);
  CHECK(use_of(document.text(), "hole-3") == PartUse::Rigid);
  use("hole-2", PartUse::TranslationOnly);
  use("hole-1", PartUse::Fixed);
  use("hole-2", PartUse::Handle);
  const auto roles = mesh().roles;
  for (const auto role : {MeshView::Role::Fixed, MeshView::Role::Handle, MeshView::Role::Feature})
    CHECK(std::count(roles.begin(), roles.end(), role) > 100);
  use("hole-3", PartUse::Interest);
  use("hole-4", PartUse::Interest);
  CHECK(document.text().strings({"edit", "edit 1"}, "region_of_interest") ==
        std::vector<std::string>{"hole-3", "hole-4"});
  for (int hole = 1; hole <= 6; ++hole) use("hole-" + std::to_string(hole), PartUse::Free);
  CHECK(document.text().text() == opened);
  // A property of the deck becomes a selection.
  use("3", PartUse::Rigid);
  CHECK(document.text().has({"select", "3"}));
  CHECK(document.content().problem().empty());
}

TEST_CASE("a scene whose edit cannot be done shows its mesh and says why", "[apps][documents]") {
  const CliCase folder("mesh_problem");
  folder.file("s.toml", "unit = \"mm\"\nmesh = \"" + (kPanel / "panel.bdf").string() +
                            "\"\n[[edit]]\nname = \"e\"\nfixed = \"nowhere\"\n");
  Document document;
  document.apply({.kind = CommandKind::Open, .file = folder / "s.toml"});
  CHECK(document.content().problem().find("nowhere") != std::string::npos);
  CHECK(view_of(document).surface);
  document.apply(
      {.kind = CommandKind::Set, .table = {"edit", "e"}, .key = "fixed", .text = "\"hole-1\""});
  CHECK(document.content().problem().empty());
}

TEST_CASE("a script of a mesh gives the bits of the document that it came from",
          "[apps][documents]") {
  const CliCase folder("mesh_script");
  std::ofstream(folder / "s.batten") << "open " << (kPanel / "panel.bdf").string() << "\n"
                                     << R"(add features { of = ["hole-*"] }
add select { name = "left", box = [[-1, -1, -100], [1, 401, 100]] }
add select { name = "right", box = [[599, -1, -100], [601, 401, 100]] }
set edit "edit 1" fixed ["left"]
add edit.handle { name = "right" }
slide "edit 1.right.z" 12
slide "edit 1.right.rotation.y" -10
update
solve
export shape.bdf
)";
  run_script(folder / "s.batten");
  Document document = panel();
  act(document, {slid("edit 1.right.z", 12),
                 slid("edit 1.right.rotation.y", -10),
                 {.kind = CommandKind::SolvePreview},
                 {.kind = CommandKind::SolveToEquilibrium}});
  const std::string from_script = contents(folder / "shape.bdf");
  CHECK(from_script == exported(document, folder));
}
