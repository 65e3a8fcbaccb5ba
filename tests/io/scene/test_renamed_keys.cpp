// SPDX-License-Identifier: MPL-2.0
// Keys of older versions and of other programs: each is rejected at its position, with its present
// name.
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/scene/deform_scene.h"
#include "batten/io/scene/fair_scene.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;

namespace {

const std::string kRenamedNote = " (renamed)";

/// The message that rejects a scene, or "".
std::string refusal(SceneKind kind, const std::string& text) {
  return batten_test::error_message([&] {
    if (kind == SceneKind::Deform)
      parse_deform_scene(text, "s.toml");
    else if (kind == SceneKind::Sequence)
      parse_sequence_scene(text, "s.toml");
    else
      parse_scene(text, "s.toml");
  });
}

/// A table, and keys in it: old name, present name, a value.
struct RenamedTable {
  SceneKind kind;
  std::string header, path;
  std::vector<std::array<std::string, 3>> keys;
};

const std::vector<RenamedTable> kRenamedTables = {
    {SceneKind::Surface,
     "[[curve]]",
     "curve",
     {{"turn", "rotate", "{ axis = [0, 0, 1], angle = 90 }"},
      {"move", "translate", "[1, 0, 0]"},
      {"treatment", "alignment", "\"embedded\""}}},
    {SceneKind::Surface, "[[face]]", "face", {{"ring", "annulus", "true"}}},
    {SceneKind::Surface,
     "[[join]]",
     "join",
     {{"lines", "curves", "[\"a\"]"}, {"kind", "continuity", "\"smooth\""}}},
    {SceneKind::Surface,
     "[skin]",
     "skin",
     {{"units", "load_units", "\"absolute\""},
      {"hold", "boundary", "\"corners\""},
      {"strength", "fair_strength", "0.5"},
      {"largest_move", "max_displacement", "1"},
      {"straight_angle", "tangent_angle", "5"},
      {"join_tolerance", "angle_tolerance", "0.1"},
      {"most_at_line", "max_faces_per_edge", "3"},
      {"trembling", "noisy_curves", "\"keep\""}}},
    {SceneKind::Surface,
     "[[fair]]",
     "fair",
     {{"lines", "curves", "\"a\""},
      {"minimum", "minimize", "\"variation\""},
      {"hold_ends", "fix_ends", "true"},
      {"stretch", "segment", "{ from = [0, 0, 0], to = [1, 0, 0] }"}}},
    {SceneKind::Surface,
     "[stress]",
     "stress",
     {{"along", "material_direction", "[1, 0, 0]"}, {"shear", "shear_modulus", "80000"}}},
    {SceneKind::Deform,
     "[[edit]]",
     "edit",
     {{"region", "region_of_interest", "\"a\""}, {"turn", "rotation_mode", "\"dual\""}}},
    {SceneKind::Deform,
     "[proposals]",
     "proposals",
     {{"crease_degrees", "crease_angle", "30"},
      {"rim_rings", "flange_rings", "2"},
      {"rim_width", "flange_width", "1"}}},
    {SceneKind::Deform, "[attached]", "attached", {{"means", "distributing", "\"stay\""}}},
    {SceneKind::Deform, "[output]", "output", {{"wide_nodes", "large_field", "true"}}},
    {SceneKind::Sequence,
     "[[operation]]",
     "operation",
     {{"kind", "type", "\"path\""},
      {"along", "direction", "[1, 0, 0]"},
      {"found", "contact_detection", "{ distance = 1 }"},
      {"upright", "unrotated", "\"a\""},
      {"shift", "translate", "[1, 0, 0]"},
      {"spans", "segments", "3"},
      {"rounds", "iterations", "9"},
      {"every", "keyframe_interval", "4"},
      {"ends", "extrapolation", "\"linear\""}}}};

}  // namespace

TEST_CASE("an old key is refused at its position, with its present name", "[io][scene]") {
  for (const RenamedTable& table : kRenamedTables)
    for (const auto& [old_name, now, value] : table.keys) {
      CAPTURE(table.header, old_name);
      CHECK(refusal(table.kind, table.header + "\n  " + old_name + " = " + value + "\n") ==
            "s.toml:2:3: found the key '" + old_name + "' in '" + table.path + "', expected '" +
                now + "'" + kRenamedNote);
      CHECK(refusal(table.kind, table.header + "\n" + now + " = " + value + "\n")
                .find(kRenamedNote) == std::string::npos);
    }
}

TEST_CASE("an old table is refused in each kind of scene", "[io][scene]") {
  const auto refused = [](SceneKind kind, const std::string& old_name, const std::string& now) {
    CAPTURE(old_name);
    CHECK(refusal(kind, "\n[[" + old_name + "]]\n") ==
          "s.toml:2:3: found the key '" + old_name + "', expected '" + now + "'" + kRenamedNote);
    CHECK(refusal(kind, "\n[[" + now + "]]\n").find(kRenamedNote) == std::string::npos);
  };
  for (const auto& [old_name, now] : {std::pair{"line", "curve"},
                                      {"lines", "curves"},
                                      {"region", "face"},
                                      {"weight", "stiffness"},
                                      {"move", "offset"}})
    refused(SceneKind::Surface, old_name, now);
  for (const auto& [old_name, now] :
       {std::pair{"guide", "constraint"}, {"line", "chain"}, {"pull", "position_constraint"}})
    refused(SceneKind::Deform, old_name, now);
  refused(SceneKind::Sequence, "step", "operation");
  CHECK(refusal(SceneKind::Deform, "[[edit]]\n[[edit.turn_feature]]\nfeature = \"a\"\n") ==
        "s.toml:2:8: found the key 'turn_feature' in 'edit', expected 'rotate_feature'" +
            kRenamedNote);
  // Scenes that only fair curves have the keys of surface scenes.
  CHECK(batten_test::error_message([] { parse_fair_scene("[[line]]\n", "s.toml"); }) ==
        "s.toml:1:3: found the key 'line', expected 'curve'" + kRenamedNote);
}

TEST_CASE("of several old keys the first in the file is named", "[io][scene]") {
  const std::string skin = "[skin]\nfair = \"loft\"\nhold = \"lines\"\n",
                    line = "[[line]]\nturn = {}\n";
  CHECK(refusal(SceneKind::Surface, skin + line).starts_with("s.toml:3:1: found the key 'hold'"));
  CHECK(refusal(SceneKind::Surface, line + skin).starts_with("s.toml:1:3: found the key 'line'"));
  // Also for two on one line, and for two tables of one name.
  CHECK(
      refusal(SceneKind::Surface, "[[curve]]\nscale = { point = [0, 0, 0] }\n[[curve]]\nmove = 1\n")
          .starts_with("s.toml:2:11: found the key 'point' in 'curve.scale'"));
  CHECK(refusal(SceneKind::Sequence, "[[operation]]\nspans = 1\nalong = 2\n")
            .starts_with("s.toml:2:1: found the key 'spans'"));
}

TEST_CASE("old keys in inline tables are refused, below tables with old and present names",
          "[io][scene]") {
  const auto refused = [](SceneKind kind, const std::string& text, const std::string& message) {
    CAPTURE(text);
    CHECK(refusal(kind, text) == message + kRenamedNote);
  };
  refused(SceneKind::Surface, "[[curve]]\nturn = { axis = [0, 0, 1], point = [0, 0, 0] }\n",
          "s.toml:2:1: found the key 'turn' in 'curve', expected 'rotate'");
  refused(SceneKind::Surface, "[[curve]]\nrotate = { axis = [0, 0, 1], point = [0, 0, 0] }\n",
          "s.toml:2:30: found the key 'point' in 'curve.rotate', expected 'about'");
  refused(SceneKind::Surface, "[[curve]]\nmirror = { normal = [0, 0, 1], point = [0, 0, 0] }\n",
          "s.toml:2:32: found the key 'point' in 'curve.mirror', expected 'origin'");
  refused(SceneKind::Surface, "[[load]]\nplane = { through = [0, 0, 0] }\n",
          "s.toml:2:11: found the key 'through' in 'load.plane', expected 'origin'");
  refused(SceneKind::Surface, "[stress]\nsupports = [{ curve = \"a\" }, { line = \"b\" }]\n",
          "s.toml:2:32: found the key 'line' in 'stress.supports', expected 'curve'");
  refused(SceneKind::Surface, "[stress]\nloads = [{ area_force = [0, 0, 1] }]\n",
          "s.toml:2:12: found the key 'area_force' in 'stress.loads', expected 'traction'");
  refused(SceneKind::Deform, "[[edit]]\n[[edit.handle]]\nrotate = { degrees = 5 }\n",
          "s.toml:3:12: found the key 'degrees' in 'edit.handle.rotate', expected 'angle'");
  refused(SceneKind::Deform, "[[constraint]]\naxis = { through = [0, 0, 0] }\n",
          "s.toml:2:10: found the key 'through' in 'constraint.axis', expected 'origin'");
  refused(SceneKind::Sequence,
          "[[operation]]\nkeyframe = [{ frame = 1, handle = [{ turn = \"free\" }] }]\n",
          "s.toml:2:38: found the key 'turn' in 'operation.keyframe.handle', expected 'rotation'");
  refused(SceneKind::Sequence, "[[operation]]\ncontact_detection = { within = 1 }\n",
          "s.toml:2:23: found the key 'within' in 'operation.contact_detection', expected "
          "'distance'");
}

TEST_CASE("old values are refused, too", "[io][scene]") {
  struct OldValue {
    SceneKind kind;
    std::string header, key, old_value, now;
  };
  const std::vector<OldValue> values = {
      {SceneKind::Surface, "[[load]]", "type", "scan", "point_cloud"},
      {SceneKind::Surface, "[[load]]", "type", "pulls", "attractors"},
      {SceneKind::Surface, "[[constraint]]", "type", "line_normal", "curve_normal"},
      {SceneKind::Surface, "[[join]]", "continuity", "crease", "G0"},
      {SceneKind::Surface, "[[join]]", "continuity", "tangent", "G1"},
      {SceneKind::Surface, "[[join]]", "continuity", "curvature", "G2"},
      {SceneKind::Surface, "[skin]", "boundary", "lines", "curves"},
      {SceneKind::Surface, "[mesh]", "domain", "sheet", "developable"},
      {SceneKind::Surface, "[[face]]", "domain", "plane", "projected"},
      {SceneKind::Surface, "[[picture]]", "show", "regions", "faces"},
      {SceneKind::Deform, "[[curve]]", "ends", "held", "pinned"},
      {SceneKind::Deform, "[[feature]]", "keep", "direction", "orientation"},
      {SceneKind::Deform, "[[edit]]", "rotation_mode", "found", "estimated"},
      {SceneKind::Sequence, "[[operation]]", "type", "travel", "root_motion"},
      {SceneKind::Sequence, "[[operation]]", "type", "footprints", "foot_plants"},
      {SceneKind::Sequence, "[[operation]]", "trajectories", "paper", "piecewise_linear"}};
  for (const OldValue& v : values) {
    const auto text = [&](const std::string& value) {
      return v.header + "\n" + v.key + " = \"" + value + "\"\n";
    };
    CAPTURE(text(v.old_value));
    CHECK(refusal(v.kind, text(v.old_value)) ==
          "s.toml:2:" + std::to_string(v.key.size() + 4) + ": found " + v.key + " = \"" +
              v.old_value + "\", expected \"" + v.now + "\"" + kRenamedNote);
    CHECK(refusal(v.kind, text(v.now)).find(kRenamedNote) == std::string::npos);
  }
  // An old key with an old value: the key is reported.
  CHECK(refusal(SceneKind::Surface, "[[join]]\nkind = \"crease\"\n")
            .starts_with("s.toml:2:1: found the key 'kind' in 'join', expected 'continuity'"));
}

TEST_CASE("keys that moved to another table name that table", "[io][scene]") {
  for (const char* key : {"element", "domain", "mesher", "edge_length", "refine"}) {
    CAPTURE(key);
    const std::string name = key;
    CHECK(refusal(SceneKind::Surface, "[skin]\n" + name + " = 1\n") ==
          "s.toml:2:1: found the key '" + name + "' in 'skin', expected " + name + " in [mesh]" +
              kRenamedNote);
  }
  CHECK(refusal(SceneKind::Surface, "[skin]\nsettle = true\n")
            .starts_with("s.toml:2:1: found the key 'settle' in 'skin', expected "
                         "minimize_distortion in [mesh]"));
  CHECK(
      refusal(SceneKind::Surface, "edge_length = 3\n")
          .starts_with("s.toml:1:1: found the key 'edge_length', expected edge_length in [mesh]"));
  CHECK(refusal(SceneKind::Surface, "[[curve]]\nhold = false\n")
            .starts_with("s.toml:2:1: found the key 'hold' in 'curve', expected trim_only = true"));
}

TEST_CASE("the removed network table is refused with the keys that replace it", "[io][scene]") {
  const std::string message =
      refusal(SceneKind::Surface, "unit = \"mm\"\n[network]\ntolerance = 0.5\n");
  CAPTURE(message);
  CHECK(message.starts_with("s.toml:2:"));
  for (const char* part :
       {"found the key 'network'", "expected its keys in [skin]", "gap_tolerance (was tolerance)",
        "crease_angle (was smooth_below)", "symmetry", "max_faces_per_edge"})
    CHECK(message.find(part) != std::string::npos);
}

TEST_CASE("names of other programs lead to those of Batten", "[io][scene]") {
  const auto refused = [](const std::string& text, const std::string& message) {
    CAPTURE(text);
    CHECK(refusal(SceneKind::Surface, text).starts_with(message));
  };
  refused("[stress]\nE = 210000\n", "s.toml:2:1: found the key 'E' in 'stress', expected 'young'");
  refused("[stress]\nnu = 0.3\n", "s.toml:2:1: found the key 'nu' in 'stress', expected 'poisson'");
  refused("[stress]\nrho = 1\n", "s.toml:2:1: found the key 'rho' in 'stress', expected 'density'");
  refused("[mesh]\nmesh_size = 1\n",
          "s.toml:2:1: found the key 'mesh_size' in 'mesh', expected 'edge_length'");
}

TEST_CASE("names that are old in one kind of scene are kept in others", "[io][scene]") {
  // A chain of a mesh was a line, a curve remains one; a helix has turns; a line load acts on a
  // curve.
  const std::string surface = R"(unit = "mm"
[[curve]]
name = "a"
points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]]
[[curve]]
name = "coil"
helix = { centre = [0, 0, 0], radius = 1, pitch = 1, turns = 2 }
role = "inner"
[[load]]
name = "edge"
type = "line"
curve = "a"
value = 1
direction = [0, 0, 1]
[stress]
thickness = 1
young = 1
supports = [{ curve = "a", spring = [1, 1, 1] }]
)";
  CHECK(refusal(SceneKind::Surface, surface) == "");
  const std::string deform = R"(unit = "mm"
mesh = "a.obj"
[[select]]
name = "left"
plane = { origin = [0, 0, 0], normal = [1, 0, 0], within = 1 }
[[curve]]
name = "rib"
nodes = [1, 2]
[[edit]]
fixed = "left"
)";
  CHECK(refusal(SceneKind::Deform, deform) == "");
  const std::string sequence = R"(unit = "mm"
[sequence]
file = "a.pc2"
mesh = "a.obj"
[[operation]]
type = "path"
through = [[0, 0, 0], [1, 0, 0]]
)";
  CHECK(refusal(SceneKind::Sequence, sequence) == "");
}
