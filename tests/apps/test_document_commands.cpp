// SPDX-License-Identifier: MPL-2.0
// Commands on a document's surface: brushes, motions, and mode shapes of its shell.
#include <chrono>
#include <numbers>
#include <thread>

#include "batten/apps/documents/document.h"
#include "batten/apps/documents/document_worker.h"
#include "batten/apps/documents/edited_shape.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/load_edits.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/apps/inflated_panel.h"

using namespace batten;
using namespace batten_test;
using CommandKind = DocumentCommand::CommandKind;

namespace {

const std::string kMovingPanel = kInflatedPanel + R"(
[motion]
density = 0.2
damping = 2
)";

Document panel(const CliCase& folder, const std::string& more = "") {
  folder.file("s.toml", kMovingPanel + more);
  Document document;
  document.apply({.kind = CommandKind::Open, .file = folder / "s.toml"});
  REQUIRE(document.session());
  return document;
}

void apply_all(Document& document, const std::vector<DocumentCommand>& commands) {
  for (const DocumentCommand& command : commands) document.apply(command);
}

double height_at(const Document& document, const Vec3& p) {
  return document.content().nearest_point(p).present.z();
}

}  // namespace

TEST_CASE("a painted area takes effect, and is removed by the eraser", "[apps][documents]") {
  const CliCase folder("document_paint");
  Document document = panel(folder);
  document.apply({.kind = CommandKind::SetSlider, .key = "crown", .value = 0});
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  const std::vector<BrushDab> left = {{{100, 150, 0}, 60}, {{130, 150, 0}, 60}},
                              right = {{{320, 150, 0}, 50}};
  document.apply(new_paint("bulge", "pressure", left));
  const SceneTable bulge{"load", "bulge"};
  REQUIRE(is_painted(document.text(), bulge));
  CHECK(painted_dabs(document.text(), bulge).size() == 2);
  apply_all(document, {{.kind = CommandKind::SetSlider, .key = "bulge", .value = 40},
                       {.kind = CommandKind::SolveToEquilibrium}});
  const double low = height_at(document, {320, 150, 0});
  CHECK(height_at(document, {110, 150, 0}) > 1.5 * low);
  apply_all(document, paint_edits(document.text(), bulge, right, false));
  CHECK(height_at(document, {320, 150, 0}) > 1.5 * low);
  apply_all(document, paint_edits(document.text(), bulge, left, true));
  REQUIRE(painted_dabs(document.text(), bulge).size() == 1);
  CHECK(height_at(document, {320, 150, 0}) > height_at(document, {110, 150, 0}));
  CHECK(paint_edits(document.text(), bulge, left, true).empty());  // nothing left there
  apply_all(document, paint_edits(document.text(), bulge, right, true));
  CHECK_FALSE(document.text().has(bulge));
  // A stiffness is painted in the same way; loads close to a curve are not.
  document.apply(new_paint("stiff", "beta", left));
  CHECK(is_painted(document.text(), {"stiffness", "stiff"}));
  document.apply(
      {.kind = CommandKind::Add,
       .table = {"load", ""},
       .text = R"({ name = "edge", type = "pressure", value = 1, near = "rim.2", radius = 90 })"});
  CHECK_FALSE(is_painted(document.text(), {"load", "edge"}));
}

TEST_CASE("tangents of a straight line are edited, and the curve stays in one piece",
          "[apps][documents]") {
  const CliCase folder("document_tangents");
  folder.file("s.toml", R"(unit = "mm"

[[curve]]
name = "front"
points = [[0, 0, 0], [90, 0, 0]]
[[curve]]
name = "back"
points = [[0, 60, 0], [90, 60, 0]]
[[curve]]
name = "left"
points = [[0, 0, 0], [0, 60, 0]]
[[curve]]
name = "right"
points = [[90, 0, 0], [90, 60, 0]]
[skin]
)");
  Document document;
  document.apply({.kind = CommandKind::Open, .file = folder / "s.toml"});
  apply_all(document, tangent_edits(document.text(), "front"));
  CHECK(line_key(document.text(), "front") == LineKey::Bezier);
  CHECK(document.text().value({"curve", "front"}, "points").empty());
  CHECK(defining_points(document.text(), "front")[1] == Vec3(30, 0, 0));
  CHECK(height_at(document, {45, 1, 0}) == Approx(0).margin(1e-9));
  document.apply(move_point_command({30, 0, 0}, {30, 0, 40}));
  document.apply(move_point_command({60, 0, 0}, {60, 0, 40}));
  CHECK(height_at(document, {45, 1, 29}) == Approx(30).epsilon(0.05));  // 3/4 of 40 at the boundary
  CHECK(tangent_edits(document.text(), "front").empty());
  // Curves with a common end still move together, and another shape replaces the tangents.
  document.apply(move_point_command({0, 0, 0}, {-10, 0, 0}));
  CHECK(defining_points(document.text(), "left").front() == Vec3(-10, 0, 0));
  CHECK(defining_points(document.text(), "front").front() == Vec3(-10, 0, 0));
  document.apply(points_edit("front", {{-10, 0, 0}, {45, 0, 20}, {90, 0, 0}}, LineKey::Arc));
  CHECK(line_key(document.text(), "front") == LineKey::Arc);
  CHECK(document.content().problem().empty());
  CHECK(split_edits(view_of(document), "front", 1).empty());  // no given points
}

TEST_CASE("a motion oscillates, follows sliders, and ends in the shape at rest",
          "[apps][documents]") {
  const CliCase folder("document_motion");
  Document document = panel(folder);
  const Points rest = document.session()->dofs();
  const Vec3 middle(200, 150, 0);
  const double height = height_at(document, middle);
  document.apply({.kind = CommandKind::SetSlider, .key = "crown", .value = 12});
  double highest = 0;
  for (int i = 0; i < 400; ++i) {
    document.apply({.kind = CommandKind::Step, .value = 0.02});
    if (i == 0) CHECK(document.content().in_motion());
    highest = std::max(highest, height_at(document, middle));
  }
  const double swung = height_at(document, middle);
  CHECK(highest > 2 * height);
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  CHECK_FALSE(document.content().in_motion());
  CHECK(std::abs(swung - height_at(document, middle)) < 0.02 * height);  // it had come to rest
  CHECK(document.text().value({"load", "crown"}, "value") == "12");
  document.apply({.kind = CommandKind::Undo});
  CHECK((document.session()->dofs() - rest).cwiseAbs().maxCoeff() < 1e-9 * 400);

  // Another command ends a motion first; a script of operations gives the same bits.
  folder.file("s.batten",
              "open s.toml\nslide crown 9\nstep 0.02\nstep 0.02\nstep 0.02\n"
              "add load { name = \"p\", type = \"point\", at = [100, 100, 0], direction = [0, 0, "
              "1], value = 2 }\n"
              "step 0.05\nslide p 8\nstep 0.05\n");
  Document first, second;
  for (Document* one : {&first, &second})
    for (const LocatedCommand& line : read_script(folder / "s.batten")) one->apply(line.command);
  REQUIRE(first.content().in_motion());
  CHECK(first.session()->dofs() == second.session()->dofs());
  CHECK_THROWS_AS(first.apply({.kind = CommandKind::Step, .value = 0}), InputError);
  CHECK_THROWS_AS(Document().apply({.kind = CommandKind::Step, .value = 0.1}), InputError);
}

TEST_CASE("a worker runs the motion until it is stopped", "[apps][documents]") {
  const CliCase folder("document_moves");
  folder.file("s.toml", kMovingPanel);
  DocumentWorker worker([] {}, folder / "changes.toml");
  worker.post({.kind = CommandKind::Open, .file = folder / "s.toml"});
  const auto wait_for = [&](const auto& done) {
    for (int i = 0; i < 2000; ++i) {
      const DocumentWorker::Update news = worker.take_update();
      if (done(news)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  };
  REQUIRE(wait_for([](const auto& news) { return !news.busy && news.view && news.view->surface; }));
  worker.set_simulating(true);
  worker.post({.kind = CommandKind::SetSlider, .key = "crown", .value = 12});
  worker.post(
      {.kind = CommandKind::SolveToEquilibrium});  // after release of the slider it oscillates
  int frames = 0;
  REQUIRE(wait_for([&](const auto& news) {
    CHECK(news.simulating);
    frames += news.frame ? 1 : 0;
    return frames > 8;
  }));
  // Values set by the user stay during the motion.
  CHECK(contents(folder / "changes.toml").find("value = 12") != std::string::npos);
  worker.set_simulating(false);
  REQUIRE(wait_for([](const auto& news) { return !news.busy && news.view && !news.simulating; }));
  const std::vector<std::string> script = worker.script();
  CHECK(script.back() == "solve");
  CHECK(std::count(script.begin(), script.end(), "step 0.02") >= 8);
  CHECK(std::count(script.begin(), script.end(), "solve") == 1);
  worker.discard_changes();
}

TEST_CASE("one gesture of the user is one undo step", "[apps][documents]") {
  const CliCase folder("document_gestures");
  Document document = panel(folder);
  const std::string before = document.text().text();
  const DocumentCommand push = {
      .kind = CommandKind::Add,
      .table = {"load", ""},
      .text =
          R"({ name = "push 1", type = "point", at = [200, 150, 0], direction = [0, 0, 1], value = 0 })"};
  const auto slide = [](double value) {
    return DocumentCommand{.kind = CommandKind::SetSlider, .key = "push 1", .value = value};
  };
  // A push: its load is created and grows.
  apply_all(document, {push,
                       slide(1),
                       {.kind = CommandKind::SolvePreview},
                       slide(30),
                       {.kind = CommandKind::SolveToEquilibrium}});
  const std::string pushed = document.text().text();
  CHECK(document.text().value({"load", "push 1"}, "value") == "30");
  document.apply({.kind = CommandKind::Undo});
  CHECK(document.text().text() == before);
  CHECK_FALSE(document.can_undo());
  document.apply({.kind = CommandKind::Redo});
  CHECK(document.text().text() == pushed);
  // A later change of the slider is a separate step; likewise if a step ended in between.
  apply_all(document,
            {slide(40), {.kind = CommandKind::SolveToEquilibrium}, {.kind = CommandKind::Undo}});
  CHECK(document.text().text() == pushed);
  apply_all(document,
            {{.kind = CommandKind::Undo}, push, {.kind = CommandKind::SolveToEquilibrium}});
  const std::string at_rest = document.text().text();
  apply_all(document,
            {slide(40), {.kind = CommandKind::SolveToEquilibrium}, {.kind = CommandKind::Undo}});
  CHECK(document.text().text() == at_rest);
}

TEST_CASE("a point that is dragged passes others, and is one step", "[apps][documents]") {
  Document document;
  const std::vector<Vec3> corners = {{0, 0, 0}, {200, 0, 0}, {200, 120, 0}, {0, 120, 0}};
  for (size_t i = 0; i < 4; ++i)
    document.apply(
        line_command("side " + std::to_string(i + 1), {corners[i], corners[(i + 1) % 4]}));
  document.apply(line_command("other", {{300, 0, 0}, {400, 0, 0}}));
  const std::string before = document.text().text();
  // Over the end of another curve, which does not move.
  const auto go = [&](const Vec3& to) { document.apply(move_point_command({200, 0, 0}, to)); };
  go({250, 0, 0});
  CHECK(document.session());
  go({300, 0, 0});
  go({220, -30, 10});
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  const auto end = [&](const char* line, size_t i) {
    return defining_points(document.text(), line)[i];
  };
  CHECK(end("side 1", 1) == Vec3(220, -30, 10));
  CHECK(end("side 2", 0) == Vec3(220, -30, 10));
  CHECK(end("other", 0) == Vec3(300, 0, 0));
  document.apply({.kind = CommandKind::Undo});
  CHECK(document.text().text() == before);
  // A slider changed between two moves keeps its value.
  go({210, 0, 0});
  document.apply({.kind = CommandKind::SetSlider, .key = "beta", .value = 2});
  CHECK_THROWS_AS(go({220, 0, 0}), InputError);  // the point no longer exists
  CHECK(document.text().value({"skin", ""}, "beta") == "2");
  apply_all(document, {{.kind = CommandKind::Undo}, {.kind = CommandKind::Undo}});
  CHECK(document.text().text() == before);
  // Another drag from the same position is a separate step.
  go({210, 0, 0});
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  document.apply(move_point_command({210, 0, 0}, {230, 0, 0}));
  document.apply({.kind = CommandKind::SolveToEquilibrium});
  document.apply({.kind = CommandKind::Undo});
  CHECK(end("side 1", 1) == Vec3(210, 0, 0));
}

TEST_CASE("a skin that is asked for in vain is refused, and the surface stays",
          "[apps][documents]") {
  const CliCase folder("document_skin_refused");
  Document document = panel(folder);
  const std::string before = document.text().text();
  const Points shape = document.session()->dofs();
  CHECK_THROWS_AS(
      document.apply(
          {.kind = CommandKind::Set, .table = {"mesh", ""}, .key = "edge_length", .text = "0.001"}),
      InputError);
  CHECK(document.text().text() == before);
  REQUIRE(document.session());
  CHECK((document.session()->dofs() - shape).isZero(0));
  document.apply(
      {.kind = CommandKind::Set, .table = {"mesh", ""}, .key = "edge_length", .text = "50"});
  CHECK(document.session()->dofs().rows() != shape.rows());
}

TEST_CASE("numbers that lists of the scene keep are written as they were", "[apps][documents]") {
  const CliCase folder("document_numbers");
  Document document = panel(folder, R"([[load]]
name = "spot"
type = "pressure"
value = 0
paint = [{ at = [55.56, 50.05, 0.1], radius = 40.31 }, { at = [300, 150, 0], radius = 35.2 }]
)");
  apply_all(document, paint_edits(document.text(), {"load", "spot"}, {{{300, 150, 0}, 10}}, true));
  CHECK(document.text().value({"load", "spot"}, "paint") ==
        "[{ at = [55.56, 50.05, 0.1], radius = 40.31 }]");
}

TEST_CASE("the natural frequencies of a plate are those of Navier", "[apps][documents]") {
  const CliCase folder("document_modes");
  Document document = panel(folder, R"([stress]
thickness = 2
young = 210000
poisson = 0.3
density = 7.85e-9
supports = [{ curve = "rim.1", type = "pinned" }, { curve = "rim.2", type = "pinned" },
            { curve = "rim.3", type = "pinned" }, { curve = "rim.4", type = "pinned" }]
)");
  apply_all(document, {{.kind = CommandKind::SetSlider, .key = "crown", .value = 0},
                       {.kind = CommandKind::SolveToEquilibrium}});
  Frame frame;
  REQUIRE(document.draw(frame));
  const auto view = document.stress(Analysis::Modes);
  REQUIRE(view);
  INFO(view->problem);
  REQUIRE(view->frequencies.size() == 6);
  const double D = 210000 * 8 / (12 * (1 - 0.09)), mass = 7.85e-9 * 2;
  const auto navier = [&](int m, int n) {
    const double k = m * m / (400.0 * 400) + n * n / (300.0 * 300);
    return 0.5 * std::numbers::pi * k * std::sqrt(D / mass);
  };
  CHECK(std::abs(view->frequencies[0] / navier(1, 1) - 1) < 0.01);
  CHECK(std::abs(view->frequencies[1] / navier(2, 1) - 1) < 0.01);
  for (const auto& swing : view->mode_shapes) {
    REQUIRE(swing.size() == frame.points.size());
    double largest = 0;
    for (size_t i = 0; i < swing.size(); i += 3)
      largest =
          std::max(largest, static_cast<double>(Vec3(swing[i], swing[i + 1], swing[i + 2]).norm()));
    CHECK(std::abs(largest - 1) < 1e-5);
  }
}
