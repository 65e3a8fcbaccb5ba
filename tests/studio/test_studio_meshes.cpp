// SPDX-License-Identifier: MPL-2.0
// Tests of the window with meshes.
#include <QAction>
#include <QPushButton>

#include "batten/apps/documents/mesh_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/strings.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/studio/window_case.h"

using namespace batten;
using namespace batten::studio;
using namespace batten_test;

namespace {

/// Draws a lasso around a rectangle of the ground plane, seen from above.
void lasso(WindowCase& hand, const Vec3& low, const Vec3& high) {
  const auto pixel = [&](double x, double y) { return hand.view().pixel_of({x, y, 0}); };
  const std::vector<QPoint> corners = {pixel(low.x(), low.y()), pixel(high.x(), low.y()),
                                       pixel(high.x(), high.y()), pixel(low.x(), high.y())};
  hand.stroke(corners);
}

}  // namespace

TEST_CASE("holes of a deck keep their shape while its end is moved, and the deck is exported",
          "[studio][meshes]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "11-panel/panel.bdf");
  REQUIRE(hand.document().mesh);
  CHECK_FALSE(window.action(kPush)->isEnabled());

  window.tree().setCurrentItem(window.tree().topLevelItem(0));
  hand.press(kKeepAll);
  CHECK(hand.document().text.find("hole-*") != std::string::npos);

  hand.act(kTop);
  hand.act(kLasso);
  lasso(hand, {-20, -20, 0}, {12, 420, 0});
  CHECK(window.tree().current().name == "painted 1");
  hand.press(kPartUses[static_cast<int>(PartUse::Fixed)]);
  hand.act(kSelect);
  hand.act(kLasso);
  lasso(hand, {588, -20, 0}, {620, 420, 0});
  CHECK(window.tree().current().name == "painted 2");
  hand.press(kPartUses[static_cast<int>(PartUse::Handle)]);
  REQUIRE(hand.document().handles.size() == 1);

  hand.act(kSelect);
  hand.act(kIsometric);
  REQUIRE(hand.view().gizmo().shown());
  const Vec3 centre = hand.view().gizmo().centre();
  hand.drag(hand.view().gizmo().point_on_part(2), {0, -70});
  CHECK(hand.document().handles[0].shift.z() > 20);
  CHECK(hand.document().handles[0].shift.head<2>().isZero(0));
  CHECK((hand.view().gizmo().centre() - centre - hand.document().handles[0].shift).norm() < 1e-6);
  const Vec3 ring = hand.view().gizmo().point_on_part(4);
  hand.drag(ring, {0, 30});
  const Vec3 rotation_vector = hand.document().handles[0].rotation_vector;
  CHECK(std::abs(rotation_vector.y()) > 3);
  CHECK(rotation_vector.cross(Vec3::UnitY()).norm() < 1e-9);
  INFO(window.messages().join("; ").toStdString());
  CHECK(window.messages().isEmpty());
  hand.picture("panel");

  const auto folder = scratch("studio_panel");
  window.post({.kind = DocumentCommand::CommandKind::Export, .file = folder / "panel.bdf"});
  window.post({.kind = DocumentCommand::CommandKind::Save, .file = folder / "panel.toml"});
  REQUIRE(window.wait(120));
  const MeshFile before = MeshFile::read(kExamples / "11-panel/panel.bdf");
  const MeshFile after = MeshFile::read(folder / "panel.bdf");
  REQUIRE(after.shells().node_count() == before.shells().node_count());
  const PreparedMesh mesh = prepare(before.shells());
  int round = 0;
  for (const auto& loop : mesh.mesh.topology().boundary_loops()) {
    const HoleMeasure was = measure_hole(before.shells().points, loop);
    const HoleMeasure is = measure_hole(after.shells().points, loop);
    if (!was.circular) continue;
    ++round;
    CHECK(std::abs(is.radius - was.radius) < 1e-4);  // rounding to the field width of the deck
    CHECK(is.flatness < 1e-4);
  }
  CHECK(round == 4);
  hand.act(kUndo);
  CHECK(hand.document().handles[0].rotation_vector.isZero(0));
  hand.open(folder / "panel.toml");
  CHECK(hand.document().handles[0].rotation_vector == rotation_vector);
  CHECK(hand.document().problem.empty());
}

TEST_CASE("nodes are painted with a brush, and erased with Shift", "[studio][meshes]") {
  WindowCase hand;
  MainWindow& window = *hand.window;
  hand.open(kExamples / "10-plate-with-holes/plate.obj");
  REQUIRE(hand.document().mesh);
  hand.act(kTop);
  hand.act(kPaint);
  const auto painted = [&] {
    for (const auto& part : hand.document().mesh->parts)
      if (part.name == "painted 1") return part.points.size();
    return size_t{0};
  };
  const auto pixel = [&](double x, double y) { return hand.view().pixel_of({x, y, 0}); };
  hand.stroke({pixel(10, 40), pixel(10, 140), pixel(10, 260)});
  const size_t first = painted();
  CHECK(first > 20);
  hand.stroke({pixel(290, 40), pixel(290, 260)});
  const size_t both = painted();
  CHECK(both > 1.5 * static_cast<double>(first));
  CHECK(window.tree().current().name == "painted 1");
  hand.picture("painted");
  hand.stroke({pixel(290, 40), pixel(290, 260)}, Qt::ShiftModifier);
  CHECK(painted() < both);
  hand.act(kUndo);
  CHECK(painted() == both);
}
