// SPDX-License-Identifier: MPL-2.0
// Tests of the window with mesh sequences.
#include <QAction>
#include <QSlider>

#include "batten/apps/documents/mesh_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/tests/studio/window_case.h"

using namespace batten;
using namespace batten::studio;
using namespace batten_test;

TEST_CASE("a sequence is scrubbed and played, and a handle is moved in one frame",
          "[studio][sequences]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "29-forming/forming.toml");
  REQUIRE(hand.document().timeline);
  const int frames = hand.document().timeline->frames;
  CHECK(window.timeline().isVisible());
  CHECK(hand.document().timeline->keyframes == std::vector<int>{20});
  const auto [low, high] = hand.view().actors().box();
  window.timeline().slider().setValue(frames);
  REQUIRE(window.wait());
  CHECK(hand.document().timeline->frame == frames - 1);
  CHECK(hand.view().actors().box()[1].z() - high.z() > 1);  // the sheet is formed
  window.timeline().play(true);
  const int before = window.timeline().slider().value();
  CHECK(QTest::qWaitFor([&] { return window.timeline().slider().value() != before; }, 30'000));
  window.timeline().play(false);
  REQUIRE(window.wait());

  window.timeline().slider().setValue(11);
  REQUIRE(window.wait());
  window.tree().select_region("left edge");
  REQUIRE(hand.view().gizmo().shown());
  hand.drag(hand.view().gizmo().point_on_part(2), {0, -40});
  REQUIRE(window.wait(120));
  CHECK(hand.document().timeline->keyframes == std::vector<int>{10, 20});
  const auto& handle = hand.document().handles[0];
  CHECK(handle.shift.z() > 5);
  INFO(window.messages().join("; ").toStdString());
  CHECK(window.messages().isEmpty());
  hand.picture("sequence");
  hand.act(kUndo);
  CHECK(hand.document().timeline->keyframes == std::vector<int>{20});
}

TEST_CASE("a walk follows a path that is drawn", "[studio][sequences]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "25-path/path.toml");
  REQUIRE(hand.document().timeline);
  // Without hills, which are below the old path only.
  window.post({.kind = DocumentCommand::CommandKind::Remove, .table = {"operation", "hills"}});
  REQUIRE(window.wait(120));
  hand.act(kTop);
  hand.act(kZoomToFit);
  hand.act(kDraw);
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(4, -0.6, 0), Vec3(5, -1.8, 0)})
    hand.click(p);
  hand.key(Qt::Key_Return);
  REQUIRE(window.wait(120));
  INFO(window.messages().join("; ").toStdString());
  CHECK(window.messages().isEmpty());
  const SceneText scene(hand.document().text);
  CHECK(path_of(scene).size() == 4);
  CHECK((path_of(scene)[3] - Vec3(5, -1.8, 0)).norm() < 0.1);
  hand.act(kSelect);
  hand.act(kIsometric);
  hand.act(kZoomToFit);
  window.timeline().slider().setValue(hand.document().timeline->frames);
  REQUIRE(window.wait());
  CHECK(hand.view().actors().box()[0].y() < -1);  // the last frame is at the end of the path
  hand.act(kZoomToFit);
  hand.picture("path");
}
