// SPDX-License-Identifier: MPL-2.0
// Documents: the text of a scene, its results, and commands that change both.
#include <chrono>
#include <thread>

#include "batten/apps/documents/document.h"
#include "batten/apps/documents/document_worker.h"
#include "batten/apps/documents/edited_mesh.h"
#include "batten/apps/documents/edited_shape.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/load_edits.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/apps/inflated_panel.h"

using namespace batten;
using namespace batten_test;
using CommandKind = DocumentCommand::CommandKind;

namespace {

const std::string kPush =
    R"({ name = "push", type = "point", at = [120, 100, 0], direction = [0, 0, 1], value = 5 })";

Document opened(const CliCase& folder, const std::string& text) {
  folder.file("s.toml", text);
  Document document;
  document.apply({.kind = CommandKind::Open, .file = folder / "s.toml"});
  return document;
}

DocumentCommand add(const std::string& kind, const std::string& table) {
  return {.kind = CommandKind::Add, .table = {kind, ""}, .text = table};
}
DocumentCommand slide(const std::string& name, double value) {
  return {.kind = CommandKind::SetSlider, .key = name, .value = value};
}

double apart(const Points& a, const Points& b) { return (a - b).cwiseAbs().maxCoeff() / 400; }

}  // namespace

TEST_CASE("items added interactively give the same shape as the saved scene", "[apps][documents]") {
  const CliCase folder("document_live");
  Document document = opened(folder, kInflatedPanel);
  REQUIRE(document.session());
  document.apply(add("load", kPush));
  document.apply(slide("push", 40));
  document.apply({.kind = CommandKind::SolvePreview});
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  document.apply(add(
      "load", R"({ name = "side", type = "pressure", value = 4, near = "rim.2", radius = 90 })"));
  document.apply(add(
      "constraint", R"({ name = "pin", type = "point", at = [300, 200, 0], to = [300, 200, 9] })"));
  document.apply({.kind = CommandKind::Remove, .table = {"load", "crown"}});
  fs::create_directory(folder / "other");
  document.apply({.kind = CommandKind::Save, .file = folder / "other/saved.toml"});
  CHECK_FALSE(document.changed());
  Document again;
  again.apply({.kind = CommandKind::Open, .file = folder / "other/saved.toml"});
  REQUIRE(again.session());
  CHECK(apart(document.session()->dofs(), again.session()->dofs()) < 1e-9);
  CHECK(again.session()->parameters().value("push") == 40);
  CHECK(document.text().text().starts_with("# A panel that swells.\n"));
}

TEST_CASE("undo goes back to the text and the shape, and redo forth", "[apps][documents]") {
  const CliCase folder("document_undo");
  Document document = opened(folder, kInflatedPanel);
  std::vector<std::string> texts = {document.text().text()};
  std::vector<Points> shapes = {document.session()->dofs()};
  const auto step = [&](const std::vector<DocumentCommand>& commands) {
    for (const DocumentCommand& command : commands) document.apply(command);
    texts.push_back(document.text().text());
    shapes.push_back(document.session()->dofs());
  };
  step({slide("crown", 5), slide("crown", 7), {.kind = CommandKind::SolveToEquilibrium}});
  step({add("load", kPush)});
  step({slide("push", -20), {.kind = CommandKind::SolveToEquilibrium}});
  step({{.kind = CommandKind::Set, .table = {"mesh", ""}, .key = "edge_length", .text = "60"}});
  step({slide("beta", 2), {.kind = CommandKind::SolveToEquilibrium}});
  step({{.kind = CommandKind::Remove, .table = {"load", "crown"}}});
  for (size_t i = texts.size() - 1; i-- > 0;) {
    document.apply({.kind = CommandKind::Undo});
    INFO("back at " << i);
    CHECK(document.text().text() == texts[i]);
    REQUIRE(document.session()->dofs().rows() == shapes[i].rows());
    CHECK(apart(document.session()->dofs(), shapes[i]) < 1e-9);
  }
  CHECK_FALSE(document.can_undo());
  CHECK_FALSE(document.changed());
  for (size_t i = 1; i < texts.size(); ++i) {
    document.apply({.kind = CommandKind::Redo});
    CHECK(document.text().text() == texts[i]);
    CHECK(apart(document.session()->dofs(), shapes[i]) < 1e-9);
  }
  CHECK_FALSE(document.can_redo());
}

TEST_CASE("undo and redo after saving in another folder: paths lead to the same files",
          "[apps][documents]") {
  const CliCase folder("document_undo_folder");
  fs::create_directory(folder / "other");
  folder.file("rim.csv", "0 0 0\n100 0 0\n100 80 0\n0 80 0\n0 0 0\n");
  Document document = opened(folder,
                             "unit = \"mm\"\n[[curve]]\nname = \"rim\"\nfile = \"rim.csv\"\n"
                             "[mesh]\nedge_length = 40\n");
  document.apply({.kind = CommandKind::Undo});  // stops at the opened scene
  CHECK_FALSE(document.can_undo());
  REQUIRE(document.session());
  document.apply(add("load", "{ name = \"push\", type = \"pressure\", value = 1 }"));
  document.apply(
      {.kind = CommandKind::Set, .table = {"mesh", ""}, .key = "edge_length", .text = "30"});
  document.apply({.kind = CommandKind::Undo});
  document.apply({.kind = CommandKind::Save, .file = folder / "other/saved.toml"});
  for (const CommandKind kind : {CommandKind::Undo, CommandKind::Redo, CommandKind::Redo}) {
    document.apply({.kind = kind});
    document.apply({.kind = CommandKind::Save, .file = folder / "other/again.toml"});
    Document again;
    again.apply({.kind = CommandKind::Open, .file = folder / "other/again.toml"});
    REQUIRE(again.session());
    CHECK(apart(document.session()->dofs(), again.session()->dofs()) < 1e-9);
  }
}

TEST_CASE("a command that is refused leaves text and shape as they were", "[apps][documents]") {
  const CliCase folder("document_refused");
  Document document = opened(folder, kInflatedPanel);
  document.apply(add("constraint",
                     R"({ name = "a", type = "point", at = [200, 150, 0], to = [200, 150, 9] })"));
  const std::string text = document.text().text();
  const Points shape = document.session()->dofs();
  const auto same = [&] {
    CHECK(document.text().text() == text);
    CHECK(apart(document.session()->dofs(), shape) < 1e-9);
  };
  CHECK_THROWS_AS(document.apply(add(
                      "constraint",
                      R"({ name = "b", type = "point", at = [200, 150, 0], to = [200, 150, 4] })")),
                  ConflictError);
  same();
  CHECK_THROWS_AS(document.apply(add("load", R"({ name = "crown", type = "gravity", value = 1 })")),
                  InputError);
  same();
  CHECK_THROWS_AS(
      document.apply(add(
          "load",
          R"({ name = "far", type = "point", at = [9000, 0, 0], direction = [0, 0, 1], value = 1 })")),
      InputError);
  same();
  CHECK_THROWS_AS(document.apply(slide("nothing", 1)), InputError);
  CHECK_THROWS_AS(document.apply(slide("crown", std::nan(""))), InputError);
  same();
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::Open, .file = folder / "missing.toml"}),
                  InputError);
  folder.file("bad.toml", "unit = 3");
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::Open, .file = folder / "bad.toml"}),
                  InputError);
  same();
  // Pressure beyond its limit: the last values with a solution remain.
  CHECK_THROWS_AS(
      [&] {
        document.apply(slide("crown", 1e7));
        document.apply({.kind = CommandKind::SolveToEquilibrium});
      }(),
      NoSolutionError);
  CHECK(document.session()->dofs().allFinite());
  CHECK(document.session()->parameters().value("crown") < 1e7);
}

TEST_CASE("curves become a surface as soon as they close, and missing ones are reported before",
          "[apps][documents]") {
  Document document;
  CHECK(document.session() == nullptr);
  CHECK(document.content().problem().empty());
  const char* const sides[] = {"[[0, 0, 0], [100, 0, 0]]", "[[100, 0, 0], [100, 80, 0]]",
                               "[[100, 80, 0], [0, 80, 0]]", "[[0, 80, 0], [0, 0, 0]]"};
  for (int i = 0; i < 4; ++i) {
    CHECK(document.session() == nullptr);
    document.apply(
        add("curve", "{ name = \"side " + std::to_string(i) + "\", points = " + sides[i] + " }"));
    CHECK(document.shape()->lines().size() == static_cast<size_t>(i + 1));
    CHECK(document.content().problem().empty() == (i == 3));
  }
  REQUIRE(document.session());
  document.apply({.kind = CommandKind::Undo});
  CHECK(document.session() == nullptr);
  CHECK(document.content().problem().find("is not connected to any other curve") !=
        std::string::npos);
  document.apply({.kind = CommandKind::Redo});
  CHECK(document.session() != nullptr);
}

TEST_CASE("changes of a killed window are taken up from any folder", "[apps][documents]") {
  const CliCase folder("document_recovery");
  folder.file("line.csv", "0,0,0\n400,0,0\n400,300,0\n0,300,0\n0,0,0\n");
  Document document =
      opened(folder, "unit = \"mm\"\n[[curve]]\nname = \"rim\"\nfile = \"line.csv\"\n");
  document.apply(add("load", kPush));
  folder.file("a/folder/far/below/changes.toml",
              document.recovery_text(folder / "a/folder/far/below"));
  Document again;
  again.apply({.kind = CommandKind::Recover, .file = folder / "a/folder/far/below/changes.toml"});
  CHECK(again.text().text() == document.text().text());
  CHECK(again.file() == document.file());
  CHECK(again.changed());
  CHECK(apart(again.session()->dofs(), document.session()->dofs()) < 1e-9);
  Document untitled;
  untitled.apply(add("curve", "{ name = \"a\", points = [[0, 0, 0], [1, 0, 0]] }"));
  folder.file("a/folder/far/below/changes.toml",
              untitled.recovery_text(folder / "a/folder/far/below"));
  again.apply({.kind = CommandKind::Recover, .file = folder / "a/folder/far/below/changes.toml"});
  CHECK(again.text().text() == untitled.text().text());
  CHECK(again.file().empty());
  CHECK_THROWS_AS(again.apply({.kind = CommandKind::Recover, .file = folder / "s.toml"}),
                  InputError);
}

TEST_CASE("a command and its line in a script are equivalent", "[apps][documents]") {
  const std::vector<DocumentCommand> commands = {
      {.kind = CommandKind::Open, .file = "a folder/b\"c.toml"},
      {.kind = CommandKind::New, .key = "in"},
      add("load", kPush),
      {.kind = CommandKind::Set,
       .table = {"join", "#2"},
       .key = "curves",
       .text = "[\"a b\", \"c\"]"},
      {.kind = CommandKind::Set, .table = {}, .key = "name", .text = "\"x # y\""},
      {.kind = CommandKind::Erase, .table = {"skin", ""}, .key = "alpha"},
      {.kind = CommandKind::Remove, .table = {"load", "the \"big\" one"}},
      slide("rib height", -1.0 / 3),
      {.kind = CommandKind::Save},
      {.kind = CommandKind::Undo}};
  for (const DocumentCommand& command : commands) {
    const std::string line = script_line(command);
    INFO(line);
    const DocumentCommand read = parse_command(line, "");
    CHECK(script_line(read) == line);
    CHECK(read.kind == command.kind);
    CHECK(read.table == command.table);
    CHECK(read.key == command.key);
    CHECK(read.text == command.text);
    CHECK(read.value == command.value);
    CHECK(read.file == command.file);
  }
  for (const char* const wrong :
       {"slidee a 1", "slide a", "slide a b", "undo now", "set skin -", "add load", "open \"a"}) {
    INFO(wrong);
    CHECK_THROWS_AS(parse_command(wrong, "x:1:1: "), InputError);
  }
  CHECK_THROWS_WITH(parse_command("settle", "x:1:1: "),
                    "x:1:1: found the old command 'settle', expected 'solve'");
  CHECK_THROWS_WITH(parse_command("answer", "x:1:1: "),
                    "x:1:1: found the old command 'answer', expected 'update'");
}

TEST_CASE("a script gives the same bits each time, and says where it stopped",
          "[apps][documents]") {
  const CliCase folder("document_script");
  folder.file("s.toml", kInflatedPanel);
  folder.file("a.batten",
              "# as recorded\nopen s.toml\nslide crown 2\nupdate\nslide crown "
              "9\nupdate\nsolve\n\nadd load " +
                  kPush + "\nundo\nredo\nexport one.vtp\n");
  const CliResult one = folder.run({"run-script", "a.batten"});
  CHECK(one.code == 0);
  CHECK(one.out.find("push = 5") != std::string::npos);
  const std::string bits = contents(folder / "one.vtp");
  CHECK(bits.size() > 1000);
  CHECK(folder.run({"run-script", "a.batten", "--threads", "1"}).code == 0);
  CHECK(contents(folder / "one.vtp") == bits);
  folder.file("b.batten", "open s.toml\nslide crwn 2\n");
  const CliResult two = folder.run({"run-script", "b.batten"});
  CHECK(two.code == 1);
  CHECK(two.err.find("b.batten:2:1: ") != std::string::npos);
  CHECK(two.err.find("did you mean 'crown'") != std::string::npos);
}

TEST_CASE("settings of a curve's join are changed in their place", "[apps][documents]") {
  const SceneText scene(
      "unit = \"mm\"\n\n[[join]]\ncurves = [\"a\", \"b\"]\ncontinuity = "
      "\"G0\"\n[[join]]\ncurves = [\"c\"]\ncontinuity = \"smooth\"\n");
  const auto after = [&](const char* line, const std::optional<std::string>& kind) {
    SceneText text = scene;
    for (const DocumentCommand& edit : join_edits(scene, line, kind)) {
      if (edit.kind == CommandKind::Set) text.set(edit.table, edit.key, edit.text);
      if (edit.kind == CommandKind::Add) text.add(edit.table.kind, edit.text);
      if (edit.kind == CommandKind::Remove) text.remove(edit.table);
    }
    return text;
  };
  CHECK(join_edits(scene, "a", "G0").empty());
  CHECK(join_edits(scene, "d", {}).empty());
  CHECK(after("a", "smooth").strings({"join", "#1"}, "curves") == std::vector<std::string>{"b"});
  CHECK(after("a", "smooth").strings({"join", "#3"}, "continuity") ==
        std::vector<std::string>{"smooth"});
  CHECK(after("c", "G1").strings({"join", "#2"}, "continuity") == std::vector<std::string>{"G1"});
  CHECK_FALSE(after("c", {}).has({"join", "#2"}));
  CHECK(after("d", "G0").strings({"join", "#3"}, "curves") == std::vector<std::string>{"d"});
}

TEST_CASE("a worker skips outdated slides, and stops when asked", "[apps][documents]") {
  const CliCase folder("document_worker");
  folder.file("s.toml", kInflatedPanel);
  DocumentWorker worker([] {}, folder / "changes.toml");
  const auto until_idle = [&] {
    std::vector<DocumentWorker::Message> messages;
    std::shared_ptr<const DocumentView> view;
    for (bool busy = true; busy;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      DocumentWorker::Update news = worker.take_update();
      if (news.view) view = news.view;
      messages.insert(messages.end(), news.messages.begin(), news.messages.end());
      busy = news.busy;
    }
    for (const auto& message : messages) UNSCOPED_INFO(message.text);
    return std::pair(view, messages);
  };
  worker.post({.kind = CommandKind::Open, .file = folder / "s.toml"});
  CHECK(until_idle().first->surface);
  constexpr int moves = 500;
  for (int i = 1; i <= moves; ++i) worker.post(slide("crown", 3 + 0.01 * i));
  worker.post({.kind = CommandKind::SolveToEquilibrium});
  const auto [view, messages] = until_idle();
  CHECK(messages.empty());
  REQUIRE(view);
  CHECK(view->sliders.front().value == 3 + 0.01 * moves);
  CHECK(worker.script().size() < 2 * moves);
  CHECK(view->changed);
  CHECK(contents(folder / "changes.toml").find("value = 8") != std::string::npos);

  // 60,000 elements take some seconds.
  worker.post({.kind = CommandKind::Set, .table = {"mesh", ""}, .key = "edge_length", .text = "2"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  worker.cancel();
  const auto [after, cancellation] = until_idle();
  REQUIRE(cancellation.size() == 1);
  CHECK(cancellation.front().text == "cancelled");
  REQUIRE(after);
  CHECK(after->text.find("edge_length = 40") != std::string::npos);
  worker.discard_changes();
  CHECK_FALSE(fs::exists(folder / "changes.toml"));
}

TEST_CASE("supports and loads of a shell are changed and taken away one by one",
          "[apps][documents]") {
  SceneText scene(kInflatedPanel + R"([stress]
thickness = 1
material = "steel"
supports = [{ curve = "rim" }, { point = [0, 0, 0], type = "pinned" }]
loads = [{ pressure = 0.001, face = "rim" }, { point = [1, 2, 0], force = [0, 0, -3] }]
)");
  const auto parts = stress_parts(scene);
  REQUIRE(parts.size() == 4);
  const char* const kinds[] = {"clamped", "pinned", "pressure", "force"};
  const char* const of[] = {"rim", "", "rim", ""};
  for (size_t i = 0; i < 4; ++i) {
    CHECK(parts[i].kind == kinds[i]);
    CHECK(parts[i].of == of[i]);
  }
  const auto apply = [&](const std::vector<DocumentCommand>& edits) {
    REQUIRE(edits.size() == 1);
    scene.set(edits[0].table, edits[0].key, edits[0].text);
  };
  apply(stress_part_edits(scene, parts[3], "force", "[0, 0, -5]"));
  apply(stress_part_edits(scene, parts[1], "type", "\"clamped\""));
  apply(remove_stress_part(scene, parts[0]));
  const auto after = stress_parts(scene);
  REQUIRE(after.size() == 3);
  CHECK(after[0].kind == "clamped");
  CHECK(after[0].of.empty());
  CHECK(std::count(after[2].values.begin(), after[2].values.end(),
                   SceneText::Value("force", "[0, 0, -5]")) == 1);
  CHECK(remove_stress_part(scene, parts[1]).empty());  // the second support no longer exists
}

TEST_CASE("a support that is the name of a curve is clamped, and changed like others",
          "[apps][documents]") {
  const SceneText scene("[stress]\nthickness = 1\nsupports = [\"left\", { curve = \"top\" }]\n");
  CHECK(support_of(scene, "left") == "clamped");
  REQUIRE(stress_parts(scene).size() == 2);
  const auto edits = support_edits(scene, "left", "pinned");
  REQUIRE(edits.size() == 1);
  CHECK(edits[0].text.find("top") != std::string::npos);
  CHECK(edits[0].text.find("pinned") != std::string::npos);
  CHECK(edits[0].text.find("left, {") == std::string::npos);
}

TEST_CASE("stresses of a document are those of batten stress", "[apps][documents]") {
  const fs::path scene = BATTEN_SOURCE_DIR "/examples/18-lean/scene.toml";
  Document document;
  document.apply({.kind = CommandKind::Open, .file = scene});
  CHECK(document.stress(Analysis::Stress) == nullptr);  // nothing is displayed yet
  Frame frame;
  REQUIRE(document.draw(frame));
  const auto stress = document.stress(Analysis::Stress);
  REQUIRE(stress);
  INFO(stress->problem);
  REQUIRE(stress->values.size() == frame.points.size() / 3);
  CHECK(stress->moved.size() == frame.points.size());
  const CliCase folder("document_stress");
  const Report report = run_stress(read_scene(scene), folder / "out", {.accuracy = 0});
  double largest = 0, moved = 0;
  for (const auto& c : report.stress->cases) {
    largest = std::max(largest, c.stress);
    moved = std::max(moved, c.displacement);
  }
  CHECK(std::abs(stress->von_mises - largest) < 1e-6 * largest);
  CHECK(std::abs(stress->displacement - moved) < 1e-6 * moved);
  const float most = *std::max_element(stress->values.begin(), stress->values.end());
  CHECK(most <= 1.05F * static_cast<float>(largest));
  CHECK(most > 0.5F * static_cast<float>(largest));
}
