// SPDX-License-Identifier: MPL-2.0
// Documents of deforming meshes: results of batten sequence, with editing and undo.
#include "batten/apps/documents/document.h"
#include "batten/apps/documents/edited_sequence.h"
#include "batten/apps/documents/mesh_edits.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/scenes/commands.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten;
using namespace batten_test;
using CommandKind = DocumentCommand::CommandKind;

namespace {

const fs::path kForming = BATTEN_SOURCE_DIR "/examples/29-forming/forming.toml";

void act_all(Document& document, const std::vector<DocumentCommand>& commands) {
  for (const DocumentCommand& command : commands) document.apply(command);
}

double apart(const MeshSequence& a, const MeshSequence& b) {
  double most = a.frames.size() == b.frames.size() ? 0 : 1e300;
  for (size_t k = 0; k < a.frames.size() && k < b.frames.size(); ++k)
    most = std::max(most, (a.frames[k] - b.frames[k]).cwiseAbs().maxCoeff());
  return most;
}

}  // namespace

TEST_CASE("frames of a document are those of batten sequence", "[apps][documents]") {
  const CliCase folder("sequence_document");
  Document document;
  document.apply({.kind = CommandKind::Open, .file = kForming});
  REQUIRE(document.sequence());
  CHECK(document.content().problem().empty());
  SequenceScene scene = read_sequence_scene(kForming);
  scene.frames_out = "frames/all_*.obj";
  scene.pictures.clear();
  run_sequence(scene, folder / "out");
  const MeshSequence written = read_frames(folder / "out/frames/all_*.obj", {}, {});
  CHECK(apart(document.sequence()->frames(), written) < 1e-9);
}

TEST_CASE("keyframes of a sequence are added, changed and undone", "[apps][documents]") {
  Document document;
  document.apply({.kind = CommandKind::Open, .file = kForming});
  const MeshSequence opened = document.sequence()->frames();
  const std::string text = document.text().text();
  const auto keyed = [&](int frame, const Vec3& shift) {
    act_all(document, keyframe_edits(document.text(), frame, "left edge", shift, Vec3::Zero()));
  };
  keyed(21, {-20, 0, 0});  // the existing one
  CHECK(document.text().text().find("translate = [-20, 0, 0]") != std::string::npos);
  const MeshSequence wider = document.sequence()->frames();
  CHECK(apart(wider, opened) > 5);
  keyed(11, {0, 0, 5});  // a new one
  CHECK(apart(document.sequence()->frames(), wider) > 1);
  act_all(document, {{.kind = CommandKind::Undo}, {.kind = CommandKind::Undo}});
  CHECK(document.text().text() == text);
  CHECK(apart(document.sequence()->frames(), opened) == 0);

  // From frames without edits: a selection, a handle, a keyframe, and another one.
  Document bare;
  bare.apply({.kind = CommandKind::Open, .file = kForming.parent_path() / "plate.pc2"});
  bare.apply({.kind = CommandKind::Add,
              .table = {"select", ""},
              .text = "{ name = \"edge\", plane = { origin = [7, 0, 0], normal = [-1, 0, 0] } }"});
  act_all(bare, sequence_handle_edits(bare.text(), "edge"));
  for (const int frame : {4, 12, 12})
    act_all(bare, keyframe_edits(bare.text(), frame, "edge", {0, 0, 1.0 * frame}, {0, 10, 0}));
  CHECK(bare.content().problem().empty());
  bare.show_frame(11);
  const DocumentView view = view_of(bare);
  REQUIRE(view.timeline);
  CHECK(view.timeline->keyframes == std::vector<int>{3, 11});
  REQUIRE(view.handles.size() == 1);
  CHECK((view.handles[0].shift - Vec3(0, 0, 12)).norm() < 1e-12);
  CHECK((view.handles[0].rotation_vector - Vec3(0, 10, 0)).norm() < 1e-9);
  CHECK(static_cast<int>(view.handles[0].path.size()) == view.timeline->frames);
}

TEST_CASE("a sequence that cannot be edited so stays as it was", "[apps][documents]") {
  Document document;
  document.apply({.kind = CommandKind::Open, .file = kForming});
  const std::string text = document.text().text();
  const MeshSequence frames = document.sequence()->frames();
  CHECK_THROWS_AS(document.apply({.kind = CommandKind::Set,
                                  .table = {"operation", "wider"},
                                  .key = "fixed",
                                  .text = "\"nowhere\""}),
                  InputError);
  CHECK(document.text().text() == text);
  CHECK(apart(document.sequence()->frames(), frames) == 0);
}

TEST_CASE("a path that is drawn is followed, and drawn anew", "[apps][documents]") {
  Document document;
  document.apply(
      {.kind = CommandKind::Open, .file = BATTEN_SOURCE_DIR "/examples/25-path/path.toml"});
  const std::vector<Vec3> before = path_of(document.text());
  REQUIRE(before.size() == 5);
  std::vector<Vec3> through = before;
  through.back() += Vec3(0.5, 0.3, 0);
  document.apply(path_edit(document.text(), through));
  CHECK(path_of(document.text()) == through);
  CHECK(document.text().has({"operation", "bend"}));
  document.apply({.kind = CommandKind::Remove, .table = {"operation", "bend"}});
  CHECK(path_of(document.text()).empty());
  CHECK(path_edit(document.text(), through).kind == CommandKind::Add);
}
