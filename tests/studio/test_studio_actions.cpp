// SPDX-License-Identifier: MPL-2.0
// Tests of the window: painted loads, constraints, simulation, mode shapes, the tour.
#include <QAction>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QSlider>
#include <QTableWidget>
#include <QTimer>

#include "batten/apps/documents/document.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/load_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/tests/studio/window_case.h"

using namespace batten;
using namespace batten::studio;
using namespace batten_test;

namespace {

/// A window with a flat rectangle, seen from above.
struct Rectangle : WindowCase {
  Rectangle() {
    window->post(
        line_command("rim", {{0, 0, 0}, {200, 0, 0}, {200, 100, 0}, {0, 100, 0}, {0, 0, 0}}));
    REQUIRE(window->wait());
    REQUIRE(document().surface);
    act(kTop);
    act(kZoomToFit);
  }
  double height_at(const Vec3& p) {
    return view().actors().point(view().actors().point_near(p)).z();
  }
};

}  // namespace

TEST_CASE("a pressure is painted, its slider lifts the painted area, the brush erases it",
          "[studio][actions]") {
  Rectangle hand;
  MainWindow& window = *hand.window;
  hand.act(kPaint);
  const auto at = [&](double x, double y) { return hand.view().pixel_of({x, y, 0}); };
  hand.stroke({at(40, 50), at(80, 50)});
  REQUIRE(window.wait());
  const SceneTable painted{"load", "painted 1"};
  REQUIRE(hand.document().table(painted));
  const size_t dabs = painted_dabs(SceneText(hand.document().text), painted).size();
  CHECK(dabs > 2);
  CHECK(window.tree().current().name == "painted 1");
  QSlider* slider = window.sliders().slider("painted 1");
  REQUIRE(slider);
  window.sliders().number("painted 1")->setValue(150);
  REQUIRE(window.wait());
  CHECK(hand.height_at({60, 50, 0}) > 2 * hand.height_at({150, 50, 0}));
  hand.act(kIsometric);
  hand.picture("brush");
  hand.act(kTop);
  // Further strokes extend the selected load, and the brush with Shift erases.
  hand.stroke({at(130, 50), at(150, 50)});
  REQUIRE(window.wait());
  const size_t more = painted_dabs(SceneText(hand.document().text), painted).size();
  CHECK(more > dabs);
  hand.stroke({at(130, 50), at(150, 50)}, Qt::ShiftModifier);
  REQUIRE(window.wait());
  CHECK(painted_dabs(SceneText(hand.document().text), painted).size() < more);
  // Another quantity creates a table of its own.
  window.paint().setCurrentIndex(1);
  hand.stroke({at(100, 20), at(110, 20)});
  REQUIRE(window.wait());
  REQUIRE(hand.document().table({"stiffness", "painted 2"}));
  CHECK(SceneText(hand.document().text).value({"stiffness", "painted 2"}, "type") == "\"beta\"");
  CHECK(window.messages().isEmpty());
}

TEST_CASE("a simulated surface oscillates, and is at rest when the simulation is stopped",
          "[studio][actions]") {
  Rectangle hand;
  MainWindow& window = *hand.window;
  window.tree().select_region(hand.document().regions.front());
  hand.press(kInflate);
  const Vec3 middle(100, 50, 0);
  window.action(kSimulate)->trigger();
  CHECK_FALSE(window.action(kPush)->isEnabled());
  window.sliders().slider("pressure 1")->setValue(1500);
  double lowest = 1e9, highest = 0;
  constexpr int patience = 30'000;  // ms
  CHECK(QTest::qWaitFor(
      [&] {
        const double z = hand.height_at(middle);
        lowest = std::min(lowest, z);
        highest = std::max(highest, z);
        return highest - lowest > 0.05;
      },
      patience));
  QTest::qWait(500);
  window.action(kSimulate)->trigger();
  REQUIRE(window.wait());
  CHECK(hand.height_at(middle) > 0.1);
  CHECK(window.action(kPush)->isEnabled());
  // The script of the session gives the same shape.
  const auto folder = scratch("studio_motion");
  window.post({.kind = DocumentCommand::CommandKind::Export, .file = folder / "a.stl"});
  REQUIRE(window.wait());
  std::vector<std::string> script = window.worker().script();
  CHECK(std::count(script.begin(), script.end(), "step 0.02") > 1);
  Document again;
  for (std::string& line : script)
    if (!line.starts_with("export")) again.apply(parse_command(line, ""));
  Frame frame;
  REQUIRE(again.draw(frame));
  for (int i = 0; i < hand.view().actors().point_count(); ++i) {
    const size_t k = 3 * static_cast<size_t>(i);
    CHECK(hand.view().actors().point(i) ==
          Vec3(frame.points[k], frame.points[k + 1], frame.points[k + 2]));
  }
}

TEST_CASE("the mode shapes of a door are animated, one at a time", "[studio][actions]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  window.shading().setCurrentText(text(kShadings[static_cast<int>(Shading::Modes)]));
  REQUIRE(window.wait(120));
  INFO(hand.view().overlay_text().toStdString());
  REQUIRE(window.modes().count() >= 3);
  CHECK(window.modes().itemData(0).toDouble() < window.modes().itemData(1).toDouble());
  const QString first = hand.view().overlay_text();
  window.modes().setCurrentIndex(1);
  CHECK(hand.view().overlay_text() != first);
  const int point = 200;
  const Vec3 before = hand.view().actors().point(point);
  CHECK(QTest::qWaitFor([&] { return hand.view().actors().point(point) != before; }, 30'000));
  hand.picture("modes");
  window.shading().setCurrentIndex(0);
  REQUIRE(window.wait());
  CHECK(window.messages().isEmpty());
}

TEST_CASE("a click with Shift fixes a normal, and a force acts at the clicked point",
          "[studio][actions]") {
  Rectangle hand;
  MainWindow& window = *hand.window;
  window.tree().select_region(hand.document().regions.front());
  hand.press(kInflate);
  window.sliders().number("pressure 1")->setValue(60);
  REQUIRE(window.wait());
  hand.act(kFixPoint);
  QTest::mouseClick(&hand.view(), Qt::LeftButton, Qt::ShiftModifier,
                    hand.view().pixel_of({60, 50, 0}));
  REQUIRE(window.wait());
  REQUIRE(hand.document().table({"constraint", "normal 1"}));
  hand.click(Vec3(140, 50, 0));
  REQUIRE(hand.document().table({"constraint", "point 1"}));
  hand.act(kSelect);
  window.tree().select_line("rim");
  hand.press(kClampEdge);
  hand.click(Vec3(100, 30, 0));
  hand.press(kAddPointForce);
  CHECK(hand.document().text.find("force = ") != std::string::npos);
  // After remeshing, the force is at the same point.
  const auto at_force = [&] {
    const auto places = hand.view().actors().mark_points();
    return std::any_of(places.begin(), places.end(),
                       [](const Vec3& p) { return (p - Vec3(100, 30, p.z())).norm() < 4; });
  };
  CHECK(at_force());
  window.post({.kind = DocumentCommand::CommandKind::Set,
               .table = {"mesh", ""},
               .key = "edge_length",
               .text = "9"});
  REQUIRE(window.wait());
  CHECK(at_force());
  hand.act(kUndo);
  CHECK(at_force());
  // A click on a fixed point selects it.
  hand.act(kFixPoint);
  const size_t held = hand.document().handles.size();
  hand.click(hand.document().handles.front().centre);
  CHECK(hand.document().handles.size() == held);
  CHECK(window.tree().current().name == "point 1");
  hand.act(kSelect);
  // Enumerated keys have a list of values.
  window.tree().select_region("normal 1");
  CHECK(window.messages().isEmpty());
  hand.act(kIsometric);
  hand.picture("held");
}

TEST_CASE("the tour continues when its steps are done", "[studio][actions]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  window.start_tour();
  REQUIRE(window.wait(60));
  REQUIRE(window.tour());
  REQUIRE(hand.document().surface);
  hand.picture("tour");
  const auto step = [&] { return window.tour() ? window.tour()->step() : -1; };
  QTest::mouseClick(&window.tour()->next(), Qt::LeftButton);
  CHECK(step() == 1);
  window.sliders().number("swell")->setValue(90);
  REQUIRE(window.wait());
  CHECK(step() == 2);
  hand.act(kPush);
  const auto [low, high] = hand.view().actors().box();
  hand.drag(hand.view().actors().point(hand.view().actors().point_near(0.5 * (low + high))),
            {0, -40});
  CHECK(step() == 3);
  window.shading().setCurrentIndex(static_cast<int>(Shading::Zebra));
  CHECK(step() == 4);  // immediately, without a solve
  window.shading().setCurrentIndex(static_cast<int>(Shading::Stress));
  REQUIRE(window.wait(60));
  CHECK(step() == 5);
  hand.act(kUndo);
  CHECK(step() == 6);
  hand.act(kSelect);
  window.tree().select_line("rib");
  REQUIRE(window.wait());
  CHECK(step() == 7);
  QTest::mouseClick(&window.tour()->next(), Qt::LeftButton);
  QTest::qWait(50);
  CHECK(step() == -1);
  // The example of the tour is not overwritten: Save asks for a name.
  QString asked;
  QTimer::singleShot(200, [&] {
    if (auto* dialog = qobject_cast<QFileDialog*>(QApplication::activeModalWidget())) {
      asked = dialog->selectedFiles().value(0);
      dialog->reject();
    }
  });
  hand.act(kSave);
  CHECK_FALSE(asked.isEmpty());
  CHECK(hand.document().changed);
}

TEST_CASE("the surface follows when the end tangents of a curve are dragged", "[studio][actions]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.draw_sides();
  hand.act(kIsometric);
  window.tree().select_line("side 1");
  hand.press(kEditTangents);
  hand.view().set_plane(DrawPlane::Xz);
  const auto control = [&](size_t i) {
    return defining_points(SceneText(hand.document().text), "side 1").at(i);
  };
  hand.drag(control(1), {0, -70});
  hand.drag(control(2), {0, -70});
  CHECK(control(1).z() > 10);
  CHECK(control(2).z() > 10);
  CHECK(hand.view().actors().box()[1].z() > 8);
  CHECK(window.messages().isEmpty());
  hand.picture("tangents");
}

TEST_CASE("a running simulation is interrupted by undo, another file, save and other shadings",
          "[studio][actions]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  const auto door = kExamples / "05-door/scene.toml";
  hand.open(door);
  QAction* motion = window.action(kSimulate);
  // Undo and other commands interrupt a simulation, which then continues until it is stopped.
  window.sliders().number("swell")->setValue(60);
  REQUIRE(window.wait());
  const std::string before = hand.document().text;
  motion->trigger();
  window.sliders().slider("swell")->setValue(window.sliders().slider("swell")->maximum());
  QTest::qWait(200);
  window.action(kUndo)->trigger();
  QTest::qWait(200);
  CHECK(motion->isChecked());
  hand.key(Qt::Key_Escape);
  motion->trigger();
  REQUIRE(window.wait());
  CHECK(hand.document().text == before);
  // Another file is opened during the simulation.
  motion->trigger();
  QTest::qWait(100);
  window.open(kExamples / "11-panel/panel.bdf");
  REQUIRE(window.wait(60));
  CHECK(hand.document().mesh);
  CHECK_FALSE(motion->isChecked());
  CHECK_FALSE(motion->isEnabled());
  CHECK(window.messages().isEmpty());
  // Shadings that need [stress] show a hint without it, and appear with the next scene.
  window.shading().setCurrentIndex(static_cast<int>(Shading::Modes));
  REQUIRE(window.wait());
  CHECK_FALSE(hand.view().overlay_text().isEmpty());
  hand.open(door);
  REQUIRE(window.wait(60));
  CHECK(window.modes().count() > 2);
  window.sliders().number("swell")->setValue(30);
  REQUIRE(window.wait(60));
  window.shading().setCurrentIndex(static_cast<int>(Shading::Stress));
  REQUIRE(window.wait(60));
  CHECK(hand.view().overlay_text().contains("MPa"));
  // They disappear for a scene without [stress], even with the same file name.
  hand.open(kExamples / "08-goblet/scene.toml");
  CHECK(hand.view().overlay_text() == text(kNoStress));
  CHECK(window.modes().count() == 0);
  const auto [low, high] = hand.view().actors().box();
  const QPoint left = hand.view().pixel_of(low), right = hand.view().pixel_of(high);
  CHECK(std::abs(left.y() - right.y()) > hand.view().height() / 3);  // zoomed to fit
  hand.open(door);
  window.sliders().number("swell")->setValue(30);
  REQUIRE(window.wait(60));
  // Saved during the simulation: the text of the shape at rest.
  const auto folder = scratch("studio_odd");
  motion->trigger();
  QTest::qWait(100);
  window.post({.kind = DocumentCommand::CommandKind::Save, .file = folder / "door.toml"});
  QTest::qWait(300);
  motion->trigger();
  REQUIRE(window.wait(60));
  CHECK(SceneText(hand.document().text).value({"load", "swell"}, "value") == "30");
  CHECK_FALSE(hand.document().changed);
  CHECK(window.messages().isEmpty());
}
