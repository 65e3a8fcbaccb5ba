// SPDX-License-Identifier: MPL-2.0
// Tests of the window. Each one operates it, checks the resulting state and takes a picture.
#include <QAction>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QPushButton>
#include <QSlider>
#include <QTableWidget>
#include <QTreeWidgetItemIterator>
#include <QWheelEvent>
#include <fstream>
#include <sstream>

#include "batten/apps/documents/document.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/tests/studio/window_case.h"

using namespace batten;
using namespace batten::studio;
using namespace batten_test;

namespace {

std::string contents_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

Vec3 middle_of(const ShapeActors& actors) {
  REQUIRE(actors.has_surface());
  const auto [low, high] = actors.box();
  return actors.point(actors.point_near(0.5 * (low + high)));
}

}  // namespace

TEST_CASE("a loop that is drawn becomes a surface, is pushed, undone, exported and opened again",
          "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.act(kTop);
  hand.act(kDraw);
  const std::vector<Vec3> corners = {{-80, -60, 0}, {80, -60, 0}, {80, 60, 0}, {-80, 60, 0}};
  for (int side = 0; side < 4; ++side) {
    hand.click(corners[static_cast<size_t>(side)]);
    hand.click(corners[static_cast<size_t>((side + 1) % 4)]);
    if (hand.document().lines.size() < static_cast<size_t>(side + 1)) hand.key(Qt::Key_Return);
  }
  CHECK(hand.document().lines.size() == 4);
  CHECK(hand.document().can_undo);
  REQUIRE(hand.document().surface);
  CHECK(hand.document().regions.size() == 1);
  CHECK(hand.document().problem.empty());

  hand.act(kIsometric);
  hand.act(kPush);
  const Vec3 middle = middle_of(hand.view().actors());
  const int point = hand.view().actors().point_near(middle);
  hand.drag(middle, {0, -60});
  const Vec3 pushed = hand.view().actors().point(point);
  CHECK(pushed.z() - middle.z() > 5);
  REQUIRE(window.sliders().slider("push 1"));
  hand.picture("drawn");

  // The number field next to the slider shows the value in the scene.
  window.sliders().number("push 1")->setValue(0);
  REQUIRE(window.wait());
  CHECK((hand.view().actors().point(point) - middle).norm() < 1e-3);
  hand.act(kUndo);
  CHECK((hand.view().actors().point(point) - pushed).norm() < 1e-3);

  const auto folder = scratch("studio_drawn");
  window.post({.kind = DocumentCommand::CommandKind::Export, .file = folder / "shape.step"});
  window.post({.kind = DocumentCommand::CommandKind::Save, .file = folder / "shape.toml"});
  REQUIRE(window.wait(120));
  CHECK(std::filesystem::file_size(folder / "shape.step") > 1000);
  CHECK_FALSE(hand.document().changed);
  const std::string saved = hand.document().text;
  hand.open(folder / "shape.toml");
  CHECK(hand.document().text == saved);
  CHECK(hand.document().surface);
  CHECK(hand.document().title == "shape.toml");
  CHECK((hand.view().actors().point(hand.view().actors().point_near(pushed)) - pushed).norm() < 1);
  INFO(window.messages().join("; ").toStdString());
  CHECK(window.messages().isEmpty());
}

TEST_CASE(
    "a curve of the mouse is clicked and becomes a crease, a face is pushed, the scene is saved",
    "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "09-mouse/scene.toml");
  REQUIRE(hand.document().surface);
  REQUIRE(hand.document().network);
  const auto kind_of = [&](const std::string& line) {
    for (const auto& join : hand.document().network->joins)
      if (join.line == line) return join.kind;
    return std::string();
  };
  std::string spine;
  for (const auto& join : hand.document().network->joins)
    if (join.line.starts_with("spine") && join.kind == "smooth") spine = join.line;
  REQUIRE_FALSE(spine.empty());

  hand.act(kIsometric);
  // A visible point of the curve.
  std::vector<Vec3> points;
  const auto& shown = hand.document().shown_lines;
  for (const auto& line : hand.document().lines)
    if (line.line == "spine") points = line.points;
  REQUIRE_FALSE(points.empty());
  for (size_t i = 4; i + 4 < points.size() && window.tree().current().name != spine; i += 2)
    hand.click(points[i]);
  CHECK(std::find(shown.begin(), shown.end(), spine) != shown.end());
  REQUIRE(window.tree().current().name == spine);
  QPushButton* crease = window.properties().button(kCrease);
  REQUIRE(crease);
  QTest::mouseClick(crease, Qt::LeftButton);
  REQUIRE(window.wait(120));
  CHECK(kind_of(spine) == "G0");
  hand.picture("mouse_crease");

  hand.act(kPush);
  const Vec3 top = hand.view().actors().point(hand.view().actors().point_near({12, 20, 34}));
  hand.drag(top, {0, -25});
  const int point = hand.view().actors().point_near(top);
  CHECK((hand.view().actors().point(point) - top).norm() > 0.5);
  hand.picture("mouse_pushed");

  const auto folder = scratch("studio_mouse");
  window.post({.kind = DocumentCommand::CommandKind::Save, .file = folder / "mouse.toml"});
  REQUIRE(window.wait());
  const std::string saved = contents_of(folder / "mouse.toml"),
                    before = contents_of(kExamples / "09-mouse/scene.toml");
  CHECK(saved == hand.document().text);
  // The text before the join is unchanged, including comments.
  CHECK(saved.starts_with(before.substr(0, before.find("[[join]]"))));
  CHECK(saved.find("# where the mouse has an edge") != std::string::npos);
  hand.act(kUndo);
  hand.act(kUndo);
  hand.act(kUndo);
  CHECK(kind_of(spine) == "smooth");
  CHECK(hand.document().text == before);
}

TEST_CASE("the script of a session gives bit-identical results", "[studio]") {
  const auto folder = scratch("studio_script");
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  QSlider* slider = window.sliders().slider("swell");
  REQUIRE(slider);
  // A drag back and forth, faster than updates are computed.
  slider->setSliderDown(true);
  for (int i = 0; i < 60; ++i) {
    slider->setValue(1000 + 15 * (i % 40));
    QTest::qWait(i % 7);
  }
  slider->setSliderDown(false);
  REQUIRE(window.wait());
  hand.act(kPush);
  hand.drag(middle_of(hand.view().actors()), {0, -30});
  hand.act(kUndo);
  hand.act(kRedo);
  hand.picture("door_script");
  window.post({.kind = DocumentCommand::CommandKind::Export, .file = folder / "window.vtp"});
  REQUIRE(window.wait());
  {
    std::ofstream script(folder / "door.batten");
    for (const std::string& line : window.worker().script()) script << line << "\n";
    script << "export script.vtp\n";
  }
  CHECK(window.worker().script().size() > 20);
  const ScriptReport report = run_script(folder / "door.batten");
  CHECK(report.commands == static_cast<int>(window.worker().script().size()) + 1);
  const std::string by_hand = contents_of(folder / "window.vtp");
  CHECK(by_hand.size() > 1000);
  CHECK(by_hand == contents_of(folder / "script.vtp"));
}

TEST_CASE("contradictory constraints are reported, and the shape is unchanged", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  const std::string before = hand.document().text;
  const Vec3 middle = middle_of(hand.view().actors());
  const auto place = [&](double out) {
    return "[" + SceneText::toml_value(middle.x()) + ", " +
           SceneText::toml_value(middle.y() + out) + ", " + SceneText::toml_value(middle.z()) + "]";
  };
  const auto pin = [&](const char* name, double out) {
    window.post({.kind = DocumentCommand::CommandKind::Add,
                 .table = {"constraint", ""},
                 .text = std::string("{ name = \"") + name +
                         "\", type = \"point\", at = " + place(0) + ", to = " + place(out) + " }"});
    REQUIRE(window.wait());
  };
  pin("here", 20);
  CHECK(window.messages().isEmpty());
  pin("there", 40);
  REQUIRE(window.messages().size() == 1);
  CHECK(window.messages().front().contains("here"));
  CHECK(window.messages().front().contains("there"));
  CHECK(hand.document().text.find("\"there\"") == std::string::npos);
  CHECK(hand.document().surface);
  hand.picture("conflict");
  hand.act(kUndo);
  CHECK(hand.document().text == before);
  CHECK((middle_of(hand.view().actors()) - middle).norm() < 1e-3);
}

TEST_CASE("a double click ends a curve and starts no other", "[studio]") {
  WindowCase hand;
  hand.act(kTop);
  hand.act(kDraw);
  hand.click({-80, -60, 0});
  hand.click({0, 40, 0});
  const QPoint last = hand.view().pixel_of({80, -60, 0});
  QTest::mouseClick(&hand.view(), Qt::LeftButton, {}, last);
  QTest::mouseDClick(&hand.view(), Qt::LeftButton, {}, last);
  REQUIRE(hand.window->wait());
  REQUIRE(hand.document().lines.size() == 1);
  const auto* line = hand.document().table({"curve", "curve 1"});
  REQUIRE(line);
  const std::string points = line->values.back().second;
  CHECK(std::count(points.begin(), points.end(), '[') == 4);  // of the list, and three points
  CHECK_FALSE(hand.document().surface);
  CHECK(hand.window->messages().size() == 1);
  hand.key(Qt::Key_Return);
  CHECK(hand.document().lines.size() == 1);
  hand.picture("one_line");
}

TEST_CASE(
    "points of a curve are moved, added and removed, and curves split, joined, mirrored and faired",
    "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  const auto points = [&](const std::string& line) {
    return defining_points(SceneText(hand.document().text), line);
  };
  hand.act(kTop);
  hand.act(kDraw);
  for (const Vec3& p : {Vec3(-80, -40, 0), Vec3(-40, 20, 0), Vec3(0, -20, 0), Vec3(40, 30, 0)})
    hand.click(p);
  hand.click({80, 0, 0});
  hand.key(Qt::Key_Return);
  REQUIRE(points("curve 1").size() == 5);
  hand.act(kSelect);
  window.action(kCombs)->setChecked(true);
  window.tree().select_line("curve 1");

  const std::vector<Vec3> drawn = points("curve 1");
  hand.drag(drawn[2], {0, -60});
  const std::vector<Vec3> moved = points("curve 1");
  CHECK(moved[2].y() > drawn[2].y() + 10);
  CHECK(moved[2].z() == drawn[2].z());
  for (const size_t i : {0U, 1U, 3U, 4U}) CHECK(moved[i] == drawn[i]);
  CHECK(hand.view().selected_point() == 2);
  hand.picture("line_points");

  hand.press(kSplit);
  CHECK(points("curve 1").size() == 3);
  CHECK(points("curve 2").size() == 3);
  hand.press(kJoinNext);
  CHECK(points("curve 1") == moved);
  CHECK(points("curve 2").empty());
  hand.press(kMirrors[1]);
  REQUIRE(points("curve 2").size() == 5);
  for (size_t i = 0; i < 5; ++i)
    CHECK(points("curve 2")[i] == Vec3(moved[i].x(), -moved[i].y(), moved[i].z()));

  // A double click between two points adds one there; Delete removes it again.
  Vec3 between = Vec3::Zero();
  for (const auto& line : hand.document().lines)
    if (line.line == "curve 1") between = line.points[10];
  const QPoint at = hand.view().pixel_of(between);
  QTest::mouseClick(&hand.view(), Qt::LeftButton, {}, at);
  CHECK(window.tree().current().name.starts_with("curve 1"));
  QTest::mouseDClick(&hand.view(), Qt::LeftButton, {}, at);
  REQUIRE(window.wait());
  REQUIRE(points("curve 1").size() == 6);
  CHECK((points("curve 1")[1] - between).norm() < 3);
  hand.act(kRemove);
  CHECK(points("curve 1") == moved);

  hand.press(kFair);
  CHECK(hand.document().text.find("[[fair]]") != std::string::npos);
  hand.picture("line_faired");
  CHECK(points("curve 1") == moved);  // the scene still defines these points
  CHECK(hand.document().lines.size() == 2);
  while (points("curve 1") != drawn && hand.document().can_undo) hand.act(kUndo);
  CHECK(points("curve 1") == drawn);
}

TEST_CASE("the surface follows a point of a curve while it is dragged", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  const std::vector<Vec3> corners = hand.draw_sides();
  hand.act(kTop);
  hand.act(kZoomToFit);
  const std::string before = hand.document().text;
  window.tree().select_line("side 1");
  const QPoint at = hand.view().pixel_of(corners[1]);
  QTest::mousePress(&hand.view(), Qt::LeftButton, {}, at);
  for (int i = 1; i <= 8; ++i) {
    hand.move(at + QPoint(6 * i, -3 * i));
    QTest::qWait(40);
  }
  REQUIRE(window.wait());
  CHECK(hand.view().actors().box()[1].x() > 203);  // before the release
  REQUIRE(hand.document().surface);
  QTest::mouseRelease(&hand.view(), Qt::LeftButton, {}, at + QPoint(48, -24));
  REQUIRE(window.wait());
  const std::vector<Vec3> moved = defining_points(SceneText(hand.document().text), "side 1");
  CHECK(moved[1].x() > 210);
  CHECK(defining_points(SceneText(hand.document().text), "side 2")[0] == moved[1]);
  hand.act(kUndo);
  CHECK(hand.document().text == before);
  // A release before the surface has followed: the next drag is followed again.
  QTest::mousePress(&hand.view(), Qt::LeftButton, {}, at);
  hand.move(at + QPoint(6, -6));
  QTest::mouseRelease(&hand.view(), Qt::LeftButton, {}, at + QPoint(6, -6));
  REQUIRE(window.wait());
  QTest::mousePress(&hand.view(), Qt::LeftButton, {}, at + QPoint(6, -6));
  hand.move(at + QPoint(60, -6));
  REQUIRE(window.wait());
  CHECK(hand.view().actors().box()[1].x() > 220);
  QTest::mouseRelease(&hand.view(), Qt::LeftButton, {}, at + QPoint(60, -6));
  REQUIRE(window.wait());
  CHECK(window.messages().isEmpty());
}

TEST_CASE("a new scene shows the ground plane, and clicks on the axes widget draw no points",
          "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  hand.act(kFront);  // the ground from its edge
  hand.act(kNew);
  const QPoint o = hand.view().pixel_of(Vec3::Zero()), x = hand.view().pixel_of({50, 0, 0}) - o,
               y = hand.view().pixel_of({0, 50, 0}) - o;
  CHECK(hand.view().rect().contains(o));
  CHECK(std::abs(x.x() * y.y() - x.y() * y.x()) > 2000);  // square pixels
  hand.act(kDraw);
  const QPoint axes(hand.view().width() - 70, 70);
  for (const QPoint& by : {QPoint(0, 0), QPoint(3, 2)}) hand.click(axes + by);
  hand.key(Qt::Key_Return);
  CHECK(hand.document().lines.empty());
  CHECK_FALSE(window.document().changed);
}

TEST_CASE("the wheel does not change numbers, and undo in a number field undoes in the scene",
          "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  QDoubleSpinBox* number = window.sliders().number("swell");
  const double before = number->value();
  for (QWidget* over : {static_cast<QWidget*>(number), static_cast<QWidget*>(&window.shading())}) {
    QWheelEvent wheel(QPointF(5, 5), over->mapToGlobal(QPoint(5, 5)), {}, {0, -120}, Qt::NoButton,
                      {}, Qt::NoScrollPhase, false);
    QApplication::sendEvent(over, &wheel);
  }
  REQUIRE(window.wait());
  CHECK(number->value() == before);
  CHECK(window.shading().currentIndex() == 0);
  number->setFocus();
  number->selectAll();
  QTest::keyClicks(number, "77");
  QTest::keyClick(number, Qt::Key_Return);
  REQUIRE(window.wait());
  CHECK(SceneText(hand.document().text).value({"load", "swell"}, "value") == "77");
  QApplication::setActiveWindow(&window);
  QTest::keyClick(number, Qt::Key_Z, Qt::ControlModifier);
  REQUIRE(window.wait());
  CHECK(number->value() == before);
  CHECK_FALSE(hand.document().changed);
}

TEST_CASE("a key that the scene does not have yet is added in the table", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "05-door/scene.toml");
  const SceneTable mesh{"mesh", ""};
  for (QTreeWidgetItemIterator it(&window.tree()); *it; ++it)
    if ((*it)->text(0) == "mesh") window.tree().setCurrentItem(*it);
  QTableWidget& keys = window.properties().keys();
  const int last = keys.rowCount() - 1;
  REQUIRE(last > 0);
  keys.item(last, 0)->setText("element");
  keys.item(last, 1)->setText("z12");
  REQUIRE(window.wait());
  CHECK(SceneText(hand.document().text).value(mesh, "element") == "\"z12\"");
  REQUIRE(keys.rowCount() == last + 2);
  // An unknown key is rejected, with the nearest one as a suggestion.
  keys.item(last + 1, 0)->setText("edge_lenght");
  keys.item(last + 1, 1)->setText("20");
  REQUIRE(window.wait());
  REQUIRE(window.messages().size() == 1);
  CHECK(window.messages().front().contains("edge_length"));
  hand.act(kUndo);
  CHECK_FALSE(hand.document().changed);
}

TEST_CASE("a distance is measured, and a section plane cuts the shape", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "14-car-body/scene.toml");
  REQUIRE(hand.document().surface);
  hand.act(kMeasure);
  const auto& lines = hand.document().lines;
  const Vec3 a = lines.front().points.front(), b = lines.front().points.back();
  hand.click(a);
  hand.click(b);
  CHECK(hand.view().overlay_text().contains(QString::number((b - a).norm(), 'g', 6)));
  hand.key(Qt::Key_Escape);
  CHECK(hand.view().overlay_text().isEmpty());
  hand.act(kSelect);
  const QImage whole = hand.picture("car");
  window.action(kSection)->setChecked(true);
  const QImage cut = hand.picture("section");
  CHECK(cut != whole);
  window.shading().setCurrentText(text(kShadings[static_cast<int>(Shading::Curvature)]));
  window.action(kSection)->setChecked(false);
  hand.picture("curvature");
}

TEST_CASE("a point of the surface is fixed, and moved by its arrows", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  window.post(line_command("rim", {{0, 0, 0}, {200, 0, 0}, {200, 100, 0}, {0, 100, 0}, {0, 0, 0}}));
  REQUIRE(window.wait());
  hand.act(kFixPoint);
  hand.click({100, 50, 0});
  CHECK(window.tree().current().name == "point 1");
  REQUIRE(hand.view().gizmo().shown());
  const int point = hand.view().actors().point_near({100, 50, 0});
  const double before = hand.view().actors().point(point).z();
  hand.drag(hand.view().gizmo().point_on_part(2), {0, -50});
  const double lifted = hand.view().actors().point(point).z() - before;
  CHECK(lifted > 5);
  const auto& pin = hand.document().handles.front();
  CHECK(std::abs(pin.centre.z() - lifted) < 0.05 * lifted);
  INFO(window.messages().join("; ").toStdString());
  CHECK(window.messages().isEmpty());
  hand.picture("held");
  hand.act(kRemove);
  CHECK(std::abs(hand.view().actors().point(point).z() - before) < 1e-3);
}

TEST_CASE("undo cancels an unfinished action before it undoes finished ones", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  window.post(line_command("rim", {{0, 0, 0}, {200, 0, 0}, {200, 100, 0}, {0, 100, 0}, {0, 0, 0}}));
  REQUIRE(window.wait());
  const std::string before = hand.document().text;
  hand.act(kTop);
  hand.act(kDraw);
  hand.click({20, 20, 0});
  hand.click({60, 40, 0});
  hand.act(kUndo);  // a point of the curve, not the outline
  hand.act(kUndo);
  CHECK(hand.document().text == before);
  hand.act(kUndo);
  CHECK(hand.document().lines.empty());
  hand.act(kRedo);
  CHECK(hand.document().text == before);

  // Escape ends a push, and removes the load.
  hand.act(kIsometric);
  hand.act(kPush);
  const int point = hand.view().actors().point_near({100, 50, 0});
  const QPoint at = hand.view().pixel_of({100, 50, 0});
  QTest::mousePress(&hand.view(), Qt::LeftButton, {}, at);
  REQUIRE(window.wait());
  for (int i = 1; i < 10; ++i) hand.move(at - QPoint(0, 4 * i));
  REQUIRE(window.wait());
  CHECK(hand.view().actors().point(point).z() > 1);
  hand.key(Qt::Key_Escape);
  QTest::mouseRelease(&hand.view(), Qt::LeftButton, {}, at);
  REQUIRE(window.wait());
  CHECK(hand.document().text == before);
  CHECK(std::abs(hand.view().actors().point(point).z()) < 1e-3);

  // A file without curves changes nothing.
  const auto folder = scratch("studio_note");
  std::ofstream(folder / "note.txt") << "hello world\n";
  window.open(folder / "note.txt");
  REQUIRE(window.wait());
  CHECK(window.messages().join("").contains("note.txt"));
  CHECK(hand.document().text == before);
}

TEST_CASE("curves that meet at a point are moved together, with Shift one alone", "[studio]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  const std::vector<Vec3> corners = {{0, 0, 0}, {200, 0, 0}, {200, 100, 0}, {0, 100, 0}};
  for (int side = 0; side < 4; ++side)
    window.post(line_command(
        "side " + std::to_string(side + 1),
        {corners[static_cast<size_t>(side)], corners[static_cast<size_t>((side + 1) % 4)]}));
  REQUIRE(window.wait());
  REQUIRE(hand.document().surface);
  const std::string before = hand.document().text;
  hand.act(kTop);
  window.tree().select_line("side 1");
  hand.drag(corners[1], {40, 30});
  CHECK(hand.document().surface);
  const SceneText scene(hand.document().text);
  CHECK(defining_points(scene, "side 1").back() == defining_points(scene, "side 2").front());
  CHECK((defining_points(scene, "side 1").back() - corners[1]).norm() > 10);
  CHECK(defining_points(scene, "side 1").back().z() == 0);
  hand.act(kUndo);
  CHECK(hand.document().text == before);
  CHECK(window.messages().isEmpty());
  // Delete removes the curve if it was selected after the point.
  window.tree().select_line("side 1");
  hand.act(kRemove);
  CHECK(hand.document().lines.size() == 3);
  REQUIRE(window.messages().size() == 1);
  CHECK(window.messages().front().contains("2 open curve ends"));
}
