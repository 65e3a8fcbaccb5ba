// SPDX-License-Identifier: MPL-2.0
// Tests of the window with stresses.
#include <QAction>
#include <QComboBox>
#include <QLabel>
#include <QSlider>
#include <QTableWidget>
#include <QTreeWidgetItemIterator>

#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/load_edits.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/tests/studio/window_case.h"

using namespace batten;
using namespace batten::studio;
using namespace batten_test;

TEST_CASE("stresses of the door follow the slider that shapes it", "[studio][stress]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "18-lean/scene.toml");
  REQUIRE(hand.document().has_stress);
  window.shading().setCurrentText(text(kShadings[static_cast<int>(Shading::Stress)]));
  REQUIRE(window.wait(120));
  INFO(hand.view().overlay_text().toStdString());
  const auto largest = [&] { return hand.view().actors().range()[0]; };
  const double before = largest();
  CHECK(before > 0);
  CHECK(hand.view().overlay_text().contains("MPa"));
  hand.picture("stress");
  QSlider* slider = window.sliders().slider("swell");
  REQUIRE(slider);
  slider->setValue(slider->maximum());
  REQUIRE(window.wait(120));
  CHECK(std::abs(largest() - before) > 1e-3 * before);
  hand.act(kUndo);
  CHECK(std::abs(largest() - before) < 1e-6 * before);
  CHECK(window.messages().isEmpty());
}

TEST_CASE("a drawn surface is clamped and loaded, and its stress is shown", "[studio][stress]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  window.post(line_command("rim", {{0, 0, 0}, {200, 0, 0}, {200, 100, 0}, {0, 100, 0}, {0, 0, 0}}));
  REQUIRE(window.wait());
  REQUIRE(hand.document().surface);
  window.shading().setCurrentText(text(kShadings[static_cast<int>(Shading::Stress)]));
  CHECK(hand.view().overlay_text() == text(kNoStress));
  window.tree().select_line("rim");
  const std::string line = window.tree().current().name;
  hand.press(kClampEdge);
  CHECK(support_of(SceneText(hand.document().text), line) == "clamped");
  window.tree().select_region(hand.document().regions.front());
  hand.press(kAddPressure);
  REQUIRE(window.wait(60));
  INFO(window.messages().join("; ").toStdString() << hand.document().text);
  CHECK(hand.view().overlay_text().contains("MPa"));
  CHECK(hand.view().actors().range()[0] > 0);
  hand.picture("stress_drawn");
  // The model tree lists its support and its load, each with its keys; Delete removes one.
  const auto row = [&](const char* detail) {
    for (QTreeWidgetItemIterator it(&window.tree()); *it; ++it)
      if ((*it)->text(1) == detail) return *it;
    return static_cast<QTreeWidgetItem*>(nullptr);
  };
  REQUIRE(row("clamped"));
  REQUIRE(row("pressure"));
  window.tree().setCurrentItem(row("pressure"));
  REQUIRE(window.properties().keys().rowCount() == 3);
  const double pressed = hand.view().actors().range()[0];
  for (int i = 0; i < 2; ++i)
    if (window.properties().keys().item(i, 0)->text() == "pressure")
      window.properties().keys().item(i, 1)->setText("0.002");
  REQUIRE(window.wait(60));
  CHECK(std::abs(hand.view().actors().range()[0] / pressed - 2) < 1e-3);
  window.tree().setCurrentItem(row("pressure"));
  hand.act(kRemove);
  CHECK_FALSE(row("pressure"));
  hand.act(kUndo);
  REQUIRE(row("pressure"));
  window.tree().select_line("rim");
  hand.press(kPinEdge);
  CHECK(support_of(SceneText(hand.document().text), line) == "pinned");
  hand.press(kRemoveSupport);  // rejected: it would leave rigid-body modes
  CHECK(window.messages().join("").contains("supports"));
  CHECK(support_of(SceneText(hand.document().text), line) == "pinned");
}
