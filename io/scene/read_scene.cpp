// SPDX-License-Identifier: MPL-2.0
// Reads scenes of surfaces.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include "batten/io/files/input_file.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {

// Reads everything that acts on a scene's surface: [[constraint]], [[load]], [[stiffness]], [[offset]],
// [[parameter]] and [motion].

/// Reads all these tables into the scene. The curves and [skin] must have been read before. `folder`:
/// base of relative paths. Throws InputError.
void read_sculpting(const TomlTable& root, const std::filesystem::path& folder, Scene& scene);

namespace {

LocatedString placed(const TomlTable& table, const std::string& key) {
  return {table.text(key), table.location(key)};
}

/// Reads the keys name, value (a number, or a function of time), min and max.
void read_named_value(const TomlTable& table, ScalarParameter& p) {
  p.name = table.text("name");
  p.min = table.number("min", -kInfinity);
  p.max = table.number("max", kInfinity);
  if (p.min > p.max)
    table.fail("max", format_number(p.max), "not less than min = " + format_number(p.min));
  const auto expect_in_range = [&](double value) {
    if (value < p.min || value > p.max)
      table.fail("value", format_number(value),
                 "a value " + format_range(p.min, p.max) + ", as 'min' and 'max' say");
  };
  if (!table.is_array("value")) {
    p.value = table.number("value");
    return expect_in_range(p.value);
  }
  const auto rows = table.rows("value", "t, value");
  if (rows.empty()) table.fail("value", "an empty list", "a number, or [[t, value], …]");
  for (const VecX& row : rows) {
    if (!p.keyframes.empty() && row[0] <= p.keyframes.back().time)
      table.fail("value",
                 "a moment at " + format_number(row[0]) + " after one at " +
                     format_number(p.keyframes.back().time),
                 "moments that ascend");
    expect_in_range(row[1]);
    p.keyframes.push_back({row[0], row[1]});
  }
  Parameters at_0;
  at_0.add(p);
  p.value = at_0.value(0);
}

/// Rejects keys that do not apply to this type, each with its own remedy.
void refuse_for(const TomlTable& table, const std::string& what,
                std::initializer_list<std::pair<const char*, const char*>> keys) {
  for (const auto& [key, remedy] : keys)
    if (table.has(key)) table.fail(key, "'" + std::string(key) + "' for " + what, remedy);
}

SceneConstraint read_constraint(const TomlTable& table) {
  using Type = SceneConstraint::Type;
  SceneConstraint c;
  c.name = table.text("name");
  c.location = table.location("name");
  c.type = table.choice<Type>("type", {{"point", Type::Point},
                                       {"normal", Type::Normal},
                                       {"tangent", Type::Tangent},
                                       {"curve_normal", Type::LineNormal}});
  const std::string what = "the constraint '" + c.name + "'";
  const bool point = c.type == Type::Point, along_line = c.type == Type::LineNormal;
  const char* only_point = "it only with type = \"point\"";
  if (!point) refuse_for(table, what, {{"to", only_point}, {"range", only_point}});
  if (point || along_line)
    refuse_for(table, what, {{"direction", "it only with type = \"normal\" or \"tangent\""}});
  if (c.type != Type::Tangent)
    refuse_for(table, what, {{"parametric_direction", "it only with type = \"tangent\""}});
  if (along_line) {
    refuse_for(table, what, {{"at", "'curve': the constraint acts along the whole curve"}});
    c.line = placed(table, "curve");
    c.keep_tangent_planes = !table.has("normal");
    if (!c.keep_tangent_planes) c.goal = c.middle = table.direction("normal");
    return c;
  }
  const char* only_line = "it only with type = \"curve_normal\"";
  refuse_for(table, what, {{"curve", only_line}, {"normal", only_line}});
  c.at = table.vector("at");
  c.goal = point ? table.vector("to") : table.direction("direction");
  c.middle = c.goal;
  if (table.has("range")) c.range = table.positive("range");
  if (c.type == Type::Tangent) {
    c.along = table.numbers("parametric_direction", "su, sv");
    if (c.along.norm() == 0)
      table.fail("parametric_direction", "[0, 0]", "a direction [su, sv] in the parametric domain");
    c.along.normalize();
  }
  return c;
}

/// Reads attractor springs: their points, targets, lengths and ranges.
void read_pulls(const TomlTable& table, const std::filesystem::path& folder, SceneLoad& load) {
  Load::AttractorSprings& pulls = load.pulls;
  pulls.at = table.points("at");
  if (pulls.at.empty()) table.fail("at", "an empty list", "at least one point");
  const int targets = table.has("to") + table.has("curve") + table.has("plane");
  if (targets != 1)
    table.fail(
        "at", targets == 0 ? "attractors without a target" : "attractors with more than one target",
        "one of: to, curve, plane");
  if (table.has("to")) {
    const auto to = table.points("to");
    if (to.size() != pulls.at.size())
      table.fail("to", std::to_string(to.size()) + " points",
                 std::to_string(pulls.at.size()) + ", one for each point of 'at'");
    pulls.target = Load::AttractorSprings::TargetPoints{to};
  }
  if (table.has("curve")) {
    load.curve = placed(table, "curve");
    load.file = folder / load.curve.text;
    load.location = load.curve.location;
  }
  for (const TomlTable& t : table.table("plane", {"origin", "normal"}))
    pulls.target = Load::AttractorSprings::Plane{t.vector("origin"), t.direction("normal")};
  for (const auto& [key, slot] :
       {std::pair<const char*, double*>{"rest_length", &pulls.rest_length},
        {"falloff", &pulls.falloff}}) {
    *slot = table.number(key, 0);
    if (*slot < 0) table.fail(key, format_number(*slot), "a length, not below 0");
  }
}

/// Reads the direction, for load types that have one.
void read_direction(const TomlTable& table, const std::string& what, SceneLoad& load) {
  using Type = SceneLoad::Type;
  if (load.type == Type::Pressure)
    refuse_for(table, what, {{"direction", "none: pressure acts along the surface's normal"}});
  else if (load.type == Type::PointCloudSprings || load.type == Type::AttractorSprings)
    refuse_for(table, what, {{"direction", "none: the springs act towards their targets"}});
  else
    load.direction = table.direction("direction");
}

/// Rejects keys of other load types.
void refuse_keys_of_other_types(const TomlTable& table, const std::string& what,
                                SceneLoad::Type type) {
  using Type = SceneLoad::Type;
  const auto refuse_unless = [&](std::initializer_list<Type> types, const std::string& type_names,
                                 std::initializer_list<const char*> keys) {
    if (std::find(types.begin(), types.end(), type) != types.end()) return;
    const std::string expected = "it only with type = " + type_names;
    for (const char* key : keys) refuse_for(table, what, {{key, expected.c_str()}});
  };
  refuse_unless({Type::PointCloudSprings}, "\"point_cloud\"", {"file", "unit"});
  refuse_unless({Type::AttractorSprings}, "\"attractors\"",
                {"to", "plane", "rest_length", "falloff"});
  refuse_unless({Type::Line, Type::AttractorSprings}, "\"line\" or \"attractors\"", {"curve"});
  refuse_unless({Type::Point, Type::AttractorSprings}, "\"point\" or \"attractors\"", {"at"});
  refuse_unless({Type::Pressure, Type::Uniform}, "\"pressure\" or \"uniform\"",
                {"near", "radius", "paint", "faces"});
}

/// Reads the points of a scan.
void read_scan(const TomlTable& table, const std::filesystem::path& folder, SceneLoad& load) {
  load.file = folder / table.text("file");
  load.location = table.location("file");
  if (table.has("unit")) load.unit = read_unit(table, "unit");
}

/// Checks that stiffnesses are non-negative, also over time, and limits sliders to non-negative
/// values.
void check_stiffness(const TomlTable& table, SceneLoad& load) {
  const auto expect_stiffness = [&](double value) {
    if (value < 0) table.fail("value", format_number(value), "a stiffness, not below 0");
  };
  expect_stiffness(load.value);
  for (const auto& keyframe : load.keyframes) expect_stiffness(keyframe.value);
  if (load.min < 0 && !table.has("min")) load.min = 0;
}

/// Reads a load of any type.
SceneLoad read_load(const TomlTable& table, const std::filesystem::path& folder) {
  using Type = SceneLoad::Type;
  SceneLoad load;
  read_named_value(table, load);
  load.name_location = table.location("name");
  load.type = table.choice<Type>("type", {{"pressure", Type::Pressure},
                                          {"uniform", Type::Uniform},
                                          {"gravity", Type::Gravity},
                                          {"point", Type::Point},
                                          {"line", Type::Line},
                                          {"point_cloud", Type::PointCloudSprings},
                                          {"attractors", Type::AttractorSprings}});
  const std::string what = "the load '" + load.name + "'";
  read_direction(table, what, load);
  refuse_keys_of_other_types(table, what, load.type);
  if (load.type == Type::Pressure || load.type == Type::Uniform) load.area = read_area(table);
  if (load.type == Type::Point) load.at = table.vector("at");
  if (load.type == Type::Line) load.line = placed(table, "curve");
  if (load.type == Type::PointCloudSprings) read_scan(table, folder, load);
  if (load.type == Type::AttractorSprings) read_pulls(table, folder, load);
  if (load.type == Type::PointCloudSprings || load.type == Type::AttractorSprings)
    check_stiffness(table, load);
  return load;
}

SceneStiffnessField read_weight(const TomlTable& table) {
  using Kind = StiffnessField::Kind;
  SceneStiffnessField weight;
  read_named_value(table, weight);
  weight.name_location = table.location("name");
  weight.kind = table.choice<Kind>("type", {{"alpha", Kind::Stretching}, {"beta", Kind::Bending}});
  weight.area = read_area(table);
  if (table.has("parametric_direction") && table.has("along"))
    table.fail("along", "both 'along' and 'parametric_direction'", "one of them");
  if (table.has("parametric_direction")) {
    const Vec2 along = table.numbers("parametric_direction", "u, v");
    if (along.norm() == 0)
      table.fail("parametric_direction", "[0, 0]", "a direction [u, v] in the parametric domain");
    weight.along = Vec2(along.normalized());
  } else if (table.has("along")) {
    if (table.is_array("along"))
      table.fail("along", "a list for 'along'",
                 "the name of a curve, or parametric_direction = [u, v]");
    weight.along = placed(table, "along");
  }
  return weight;
}

SceneLineOffset read_move(const TomlTable& table) {
  SceneLineOffset move;
  read_named_value(table, move);
  move.name_location = table.location("name");
  move.line = placed(table, "curve");
  if (table.has("direction")) move.direction = table.direction("direction");
  if (table.has("fade")) move.fade = table.number("fade", 0);
  if (move.fade && !(*move.fade >= 0 && *move.fade <= 0.5))
    table.fail("fade", format_number(*move.fade), "a fraction of the curve's length, 0 to 0.5");
  return move;
}

SceneMotion read_motion(const TomlTable& table) {
  SceneMotion motion;
  for (const auto& [key, slot] : {std::pair<const char*, double*>{"density", &motion.density},
                                  {"damping", &motion.damping}}) {
    *slot = table.number(key, *slot);
    if (*slot < 0) table.fail(key, format_number(*slot), "a number, not below 0");
  }
  motion.theta = table.number("theta", 1);
  if (motion.theta < 0.5 || motion.theta > 1)
    table.fail("theta", format_number(motion.theta), "a number from 0.5 to 1");
  return motion;
}

/// Checks that a line exists, as far as the scene itself determines that.
void check_line(const Scene& scene, const LocatedString& line) {
  std::vector<std::string> names;
  for (const SceneLine& source : scene.lines) {
    if (source.name.empty()) return;  // [[curves]]: the names are in its file
    if (is_part_of(line.text, source.name)) return;
    names.push_back(source.name);
  }
  throw InputError(scene.at(line.location) + "found the curve '" + line.text + "', expected " +
                   expected_one_of(line.text, names));
}

void check_lines(const Scene& scene) {
  const auto check = [&](const LocatedString& line) {
    if (!line.text.empty()) check_line(scene, line);
  };
  for (const auto& c : scene.constraints) check(c.line);
  for (const auto& load : scene.loads) {
    check(load.area.line);
    check(load.line);
  }
  for (const auto& weight : scene.weights) {
    check(weight.area.line);
    if (weight.along)
      if (const auto* line = std::get_if<LocatedString>(&*weight.along)) check(*line);
  }
  for (const auto& move : scene.moves) check(move.line);
}

/// Reads the key `drives` of the table of the parameter `of`.
void read_drives(const TomlTable& table, const std::string& of, std::vector<SceneRule>& rules) {
  for (const TomlTable& t : table.tables("drives", {"name", "factor", "offset"})) {
    SceneRule rule{of, t.text("name"), t.location("name"), t.number("factor"), {}};
    if (t.has("offset")) rule.offset = t.number("offset");
    rules.push_back(rule);
  }
}

/// Checks that each rule drives an existing parameter, without duplicates and cycles.
void check_rules(const Scene& scene) {
  std::vector<std::string> names;
  for (const ScalarParameter& p : scene.named_values()) names.push_back(p.name);
  for (size_t i = 0; i < scene.rules.size(); ++i) {
    const SceneRule& rule = scene.rules[i];
    const auto fail = [&](const std::string& found, const std::string& expected) {
      throw InputError(scene.at(rule.location) + "found " + found + ", expected " + expected);
    };
    if (std::find(names.begin(), names.end(), rule.driven) == names.end())
      fail("'" + rule.driven + "' to drive", expected_one_of(rule.driven, names));
    for_each_fair_parameter(scene.fairing, [&](const std::string& name, double) {
      if (name == rule.driven)
        fail("'" + name + "' to drive, which changes the curves",
             "a parameter of loads, stiffness fields, offsets, constraints or [skin]");
    });
    const auto expect_number = [&](const ScalarParameter& p) {
      if (p.name == rule.driven && !p.keyframes.empty())
        fail("'" + rule.driven + "' to drive, whose value is a function of time",
             "a number as its value");
    };
    for (const auto& p : scene.loads) expect_number(p);
    for (const auto& p : scene.weights) expect_number(p);
    for (const auto& p : scene.moves) expect_number(p);
    for (const auto& p : scene.sliders) expect_number(p);
    for (size_t j = 0; j < i; ++j) {
      const SceneRule& before = scene.rules[j];
      if (before.driven != rule.driven) continue;
      if (before.of == rule.of) fail("'" + rule.driven + "' again", "each name once");
      if (before.offset && rule.offset)
        fail("another offset of '" + rule.driven + "' (the first in line " +
                 std::to_string(before.location.line) + ")",
             "one of them");
    }
    Scene so_far = scene;
    so_far.rules.resize(i + 1);
    try {
      so_far.parameters();
    } catch (const InputError& e) {
      throw InputError(scene.at(rule.location) + e.what());
    }
  }
}

}  // namespace

void read_sculpting(const TomlTable& root, const std::filesystem::path& folder, Scene& scene) {
  UniqueNames names("name");
  const auto add_name = [&](const TomlTable& t, const std::string& kind, const std::string& name) {
    names.add(t, "name", name);
    for (const char* taken :
         {"alpha", "alpha_uu", "alpha_uv", "alpha_vv", "beta", "beta_uu", "beta_uv", "beta_vv"})
      if (name == taken)
        t.fail("name", "the " + kind + " name '" + std::string(taken) + "'",
               "another one: that is a parameter of [skin]");
  };
  names.read(
      root, "constraint",
      {"name", "type", "at", "to", "range", "direction", "parametric_direction", "curve", "normal"},
      scene.constraints, read_constraint);
  for (const TomlTable& t :
       root.tables("load", {"name", "type", "value", "min", "max", "direction", "at", "near",
                            "radius", "paint", "faces", "file", "unit", "to", "curve", "plane",
                            "rest_length", "falloff", "drives"})) {
    scene.loads.push_back(read_load(t, folder));
    add_name(t, "load", scene.loads.back().name);
    read_drives(t, scene.loads.back().name, scene.rules);
  }
  for (const TomlTable& t :
       root.tables("stiffness", {"name", "type", "value", "min", "max", "near", "radius", "paint",
                                 "faces", "parametric_direction", "along", "drives"})) {
    scene.weights.push_back(read_weight(t));
    add_name(t, "stiffness field", scene.weights.back().name);
    read_drives(t, scene.weights.back().name, scene.rules);
  }
  for (const TomlTable& t : root.tables(
           "offset", {"name", "curve", "value", "min", "max", "direction", "fade", "drives"})) {
    scene.moves.push_back(read_move(t));
    add_name(t, "offset", scene.moves.back().name);
    read_drives(t, scene.moves.back().name, scene.rules);
  }
  for (const TomlTable& t : root.tables("parameter", {"name", "value", "min", "max", "drives"})) {
    ScalarParameter& slider = scene.sliders.emplace_back();
    read_named_value(t, slider);
    add_name(t, "parameter", slider.name);
    read_drives(t, slider.name, scene.rules);
  }
  for (const TomlTable& t : root.table("motion", {"density", "damping", "theta"}))
    scene.motion = read_motion(t);
  check_lines(scene);
  check_rules(scene);
}

namespace {

using Refusals = std::vector<std::pair<const char*, const char*>>;

void refuse(const TomlTable& table, const std::string& what, const Refusals& refusals) {
  for (const auto& [key, reason] : refusals)
    if (table.has(key)) table.fail(key, "'" + std::string(key) + "' " + what, reason);
}

void check_compatible_keys(const TomlTable& root) {
  constexpr const char* each =
      "none: each face has the domain that suits it, or the one of its [[face]]";
  for (const TomlTable& t : root.table("mesh", mesh_keys()))
    refuse(t, "beside [[face]] or [[join]]",
           {{"domain", each},
            {"minimize_distortion", each},
            {"mesher", each},
            {"refine", "edge_length"}});
  for (const TomlTable& t : root.table("skin", skin_keys()))
    for (const char* key : {"alpha", "beta"})
      if (t.has(key) && t.is_array(key))
        t.fail(key, "three numbers beside [[face]] or [[join]]",
               "one number: faces have no common direction of u (a [[stiffness]] with along = "
               "\"CURVE\" acts along a curve)");
}

std::vector<std::string> loop_of(const TomlTable& table,
                                 const std::vector<LocatedString>& strings) {
  if (strings.empty())
    table.fail("loops", "a loop without curves",
               "names of curves: loops = [[\"a\", \"b\", \"c\"]]");
  std::vector<std::string> names;
  for (const LocatedString& name : strings) names.push_back(name.text);
  return names;
}

SkinOptions::Domain read_domain(const TomlTable& table) {
  using Domain = SkinOptions::Domain;
  return table.choice("domain", Domain::Auto,
                      {{"auto", Domain::Auto},
                       {"polygon", Domain::Polygon},
                       {"projected", Domain::Projected},
                       {"developable", Domain::Developable},
                       {"annulus", Domain::Annulus}});
}

/// Reads the options of a region. Throws InputError if `domain` is used to request an annulus.
RegionOptions read_region_options(const TomlTable& table) {
  if (table.has("domain") && (table.text("domain") == "annulus" || table.boolean("annulus", false)))
    table.fail("domain",
               "the domain '" + table.text("domain") + "'" +
                   (table.has("annulus") ? " with annulus = true" : ""),
               "annulus = true and no domain");
  return {read_domain(table), table.positive("edge_length", 0), table.boolean("convex", false)};
}

RegionSpec read_region(const TomlTable& table, UniqueNames& names) {
  RegionSpec spec;
  spec.where = table.at("loops");
  spec.kind =
      table.boolean("surface", true) ? RegionSpec::Kind::Surface : RegionSpec::Kind::NoSurface;
  for (const auto& loop : table.string_lists("loops")) spec.loops.push_back(loop_of(table, loop));
  if (spec.loops.empty())
    table.fail("loops", "no loop", "one or more: loops = [[\"a\", \"b\", \"c\"]]");
  spec.annulus = table.boolean("annulus", false);
  spec.skin = read_region_options(table);
  for (const LocatedString& inner : table.strings("inner")) spec.inner.push_back(inner.text);
  if (spec.kind == RegionSpec::Kind::NoSurface) {
    refuse(table, "with surface = false",
           {{"name", "none: there is no face"},
            {"annulus", "none: there is no face"},
            {"convex", "none: there is no face"},
            {"domain", "none: there is no face"},
            {"edge_length", "none: there is no face"},
            {"inner", "none: there is no face"}});
    if (spec.loops.size() > 1)
      table.fail("loops", std::to_string(spec.loops.size()) + " loops beside surface = false",
                 "one; write a [[face]] for each");
    return spec;
  }
  if (table.has("name")) {
    spec.name = table.text("name");
    if (spec.name.empty()) table.fail("name", "an empty name", "at least one character");
    names.add(table, "name", spec.name);
  }
  if (spec.annulus && spec.loops.size() != 2)
    table.fail("annulus", "annulus = true with " + std::to_string(spec.loops.size()) + " loops",
               "2, its boundary curves");
  return spec;
}

/// Reads the keys of [skin] that control how faces are found and joined.
void read_network_keys(const TomlTable& table, SceneNetwork& network) {
  network.location = table.location();
  network.tolerance = table.positive("gap_tolerance", network.tolerance);
  const auto angle = [&](const std::string& key, double& degrees, double most) {
    degrees = table.has(key) ? table.number(key) : degrees;
    if (!(degrees >= 0 && degrees <= most))
      table.fail(key, format_number(degrees), "0 to " + format_number(most) + " degrees");
  };
  angle("tangent_angle", network.tangent_angle, 45);
  angle("crease_angle", network.crease_angle, 180);
  network.join_tolerance = table.positive("angle_tolerance", network.join_tolerance);
  if (table.has("noisy_curves"))
    network.fair_noisy_lines =
        table.choice<bool>("noisy_curves", {{"fair", true}, {"keep", false}});
  if (table.has("symmetry"))
    network.symmetry = table.choice<int>("symmetry", {{"x", 0}, {"y", 1}, {"z", 2}});
  network.max_faces_per_edge = table.integer("max_faces_per_edge", 1, network.max_faces_per_edge);
  if (network.max_faces_per_edge > 16)
    table.fail("max_faces_per_edge", std::to_string(network.max_faces_per_edge), "1 to 16");
}

/// Reads how faces are found and joined: keys of [skin], [[face]] and [[join]]. Throws InputError
/// for errors in the tables.
void read_network(const TomlTable& root, Scene& scene) {
  SceneNetwork network;
  for (const TomlTable& table : root.table("skin", skin_keys())) read_network_keys(table, network);
  if (root.has("face") || root.has("join")) check_compatible_keys(root);
  UniqueNames names("face name");
  for (const TomlTable& t : root.tables("face", {"name", "loops", "inner", "annulus", "convex",
                                                 "surface", "domain", "edge_length"}))
    network.regions.push_back(read_region(t, names));
  for (const TomlTable& t : root.tables("join", {"curves", "continuity"})) {
    const auto kind = t.choice<JoinSpec::Kind>("continuity", {{"G0", JoinSpec::Kind::Crease},
                                                              {"G1", JoinSpec::Kind::Tangent},
                                                              {"G2", JoinSpec::Kind::Curvature},
                                                              {"smooth", JoinSpec::Kind::Smooth}});
    const auto lines = t.strings("curves");
    if (lines.empty()) t.fail("curves", "no curves", "names: curves = [\"a\", \"b\"]");
    for (const LocatedString& line : lines)
      network.joins.push_back({line.text, kind, scene.at(line.location)});
  }
  scene.network = std::move(network);
}

void read_mesh(const TomlTable& table, SkinOptions& options) {
  using Mesher = SkinOptions::Mesher;
  options.element = table.choice("element", TriangleElement::HCT,
                                 {{"hct", TriangleElement::HCT}, {"z12", TriangleElement::Z12}});
  options.mesher = table.choice("mesher", Mesher::Delaunay,
                                {{"delaunay", Mesher::Delaunay}, {"fan", Mesher::Fan}});
  options.domain = read_domain(table);
  options.minimize_distortion = table.boolean("minimize_distortion", false);
  options.edge_length = table.positive("edge_length", 0);
  if (!table.has("refine")) return;
  if (options.mesher != Mesher::Fan)
    table.fail("refine", "'refine' with the Delaunay mesher",
               "it only with mesher = \"fan\"; edge_length sets the size of Delaunay elements");
  if (table.has("edge_length"))
    table.fail("refine", "both 'refine' and 'edge_length'", "one of them");
  options.fan_refinements = table.integer("refine", 0, 0);
  if (options.fan_refinements > 10)
    table.fail("refine", std::to_string(options.fan_refinements), "0 to 10");
}

void read_skin(const TomlTable& table, SceneSkin& skin) {
  using FixedBoundary = SceneSkin::FixedBoundary;
  skin.units = table.choice("load_units", LoadUnits::Relative,
                            {{"relative", LoadUnits::Relative}, {"absolute", LoadUnits::Absolute}});
  skin.boundary =
      table.choice("boundary", FixedBoundary::Lines,
                   {{"curves", FixedBoundary::Lines}, {"corners", FixedBoundary::Corners}});
  skin.fair = table.choice("fair", SceneSkin::Fair::Auto,
                           {{"auto", SceneSkin::Fair::Auto},
                            {"bending", SceneSkin::Fair::Bending},
                            {"variation", SceneSkin::Fair::Variation},
                            {"loft", SceneSkin::Fair::Loft}});
  for (const char* key : {"fair_strength", "max_displacement"})
    if (table.has(key) && skin.fair != SceneSkin::Fair::Variation)
      table.fail(key, std::string("'") + key + "' without fair = \"variation\"",
                 "it only with fair = \"variation\"");
  skin.strength = table.positive("fair_strength", 1);
  if (skin.strength > 1)
    table.fail("fair_strength", format_number(skin.strength), "above 0, at most 1");
  skin.max_displacement = table.positive("max_displacement", 0);
  if (table.has("sections")) {
    if (skin.fair != SceneSkin::Fair::Loft)
      table.fail("sections", "'sections' without a loft", "it only with fair = \"loft\"");
    skin.sections = table.names("sections");
  }
  if (table.has("alpha")) {
    skin.isotropic_alpha = !table.is_array("alpha");
    if (skin.isotropic_alpha) {
      skin.material.alpha = table.number("alpha") * Mat2::Identity();
    } else {
      const VecX a = table.numbers("alpha", "a11, a12, a22");
      skin.material.alpha << a[0], a[1], a[1], a[2];
    }
  }
  if (table.has("beta")) {
    skin.isotropic_beta = !table.is_array("beta");
    skin.material.beta = skin.isotropic_beta ? Vec3::Constant(table.number("beta"))
                                             : Vec3(table.numbers("beta", "b11, b12, b22"));
  }
  const std::string expected = material_requirement(skin.material);
  if (!expected.empty()) {
    const std::string key = expected.starts_with("beta") || !table.has("alpha") ? "beta" : "alpha";
    table.fail(key, "stiffnesses without a unique surface", expected);
  }
}

/// Reads the mesh that a target lists as points and faces.
std::shared_ptr<const ShellMesh> read_target_mesh(const TomlTable& table) {
  auto mesh = std::make_shared<ShellMesh>();
  const std::vector<Vec3> points = table.points("points");
  mesh->points.resize(static_cast<long>(points.size()), 3);
  for (long i = 0; i < mesh->points.rows(); ++i)
    mesh->points.row(i) = points[static_cast<size_t>(i)];
  for (const std::vector<int>& face : table.index_lists("faces")) {
    const int largest = *std::max_element(face.begin(), face.end());
    if (face.size() < 3 || largest >= mesh->node_count())
      table.fail(
          "faces", face.size() < 3 ? "a face with fewer than 3 vertices" : std::to_string(largest),
          "faces with 3 or more vertices from 0 to " + std::to_string(mesh->node_count() - 1));
    mesh->add_face(face);
  }
  return mesh;
}

NamedFields read_fields(const TomlTable& root, const std::filesystem::path& folder) {
  NamedFields fields;
  for (const TomlTable& t : root.tables("field", {"name", "file", "array"})) {
    const std::string name = t.text("name");
    if (!Formula::is_field_name(name))
      t.fail("name", "'" + name + "'",
             "letters, digits and '_', not beginning with a digit, and not the name of a "
             "coordinate or "
             "function");
    if (fields.count(name)) t.fail("name", "a second field '" + name + "'", "another name");
    try {
      fields.emplace(name, PointField(folder / t.text("file"), t.text("array", "")));
    } catch (const InputError& e) {
      throw InputError(t.at("file") + e.what());
    }
  }
  return fields;
}

SceneTarget read_target(const TomlTable& table, const std::filesystem::path& folder,
                        const SceneSkin& skin) {
  SceneTarget target;
  target.location = table.location("file");
  if (table.has("points") && table.has("file"))
    table.fail("file", "a file beside 'points' and 'faces'", "one of them");
  if (table.has("points") || table.has("faces"))
    target.mesh = read_target_mesh(table);
  else
    target.file = folder / table.text("file");
  if (table.has("unit")) target.unit = read_unit(table, "unit");
  target.cage = table.choice("cage", false, {{"catmull-clark", true}, {"none", false}});
  target.tolerance = table.positive("fit_tolerance", 0);
  if (skin.is_faired() || skin.boundary != SceneSkin::FixedBoundary::Lines)
    table.fail("file", "a target beside 'fair' or boundary = \"corners\" in [skin]",
               "one of them: the target defines the shape between the curves");
  return target;
}

SceneNeighbour read_neighbour(const TomlTable& table, const std::filesystem::path& folder) {
  SceneNeighbour neighbour;
  neighbour.location = table.location("file");
  neighbour.file = (folder / table.text("file")).lexically_normal();
  for (const auto& [key, names] : {std::pair{"faces", &neighbour.faces},
                                   {"without", &neighbour.without},
                                   {"edges", &neighbour.edges}})
    if (table.has(key))
      for (const LocatedString& name : table.strings(key)) names->push_back(name.text);
  neighbour.continuity = table.choice("continuity", NeighbourContinuity::Automatic,
                                      {{"auto", NeighbourContinuity::Automatic},
                                       {"G0", NeighbourContinuity::Position},
                                       {"G1", NeighbourContinuity::Tangent},
                                       {"G2", NeighbourContinuity::Curvature}});
  if (table.has("fill")) neighbour.fill = table.boolean("fill", true);
  neighbour.bridge = table.boolean("bridge", false);
  neighbour.tension = table.positive("tension", 0);
  if (neighbour.tension > 0 && !neighbour.bridge)
    table.fail("tension", "a tension without 'bridge'", "bridge = true");
  if (table.has("openings"))
    for (const double number : table.list("openings")) {
      if (!(number >= 1 && number <= 1e6 && number == std::floor(number)))
        table.fail("openings", format_number(number), "numbers of openings, from 1");
      neighbour.openings.push_back(static_cast<int>(number));
    }
  return neighbour;
}

// Rejects keys that contradict [skin] fair or have no effect with it.
void check_fair_keys(const TomlTable& root, const SceneSkin& skin) {
  using Fair = SceneSkin::Fair;
  if (skin.is_faired() && skin.boundary == SceneSkin::FixedBoundary::Corners)
    for (const TomlTable& t : root.table("skin", skin_keys()))
      t.fail("fair", "\"" + skin.fair_name() + "\" with boundary = \"corners\"",
             "boundary = \"curves\": its curves define a fair shape");
  if (skin.fair == Fair::Variation || root.has("neighbour")) return;
  for (const TomlTable& t : root.tables("join", {"curves", "continuity"}))
    if (t.text("continuity") == "G2")
      t.fail("continuity", "\"G2\" for a surface that is not faired",
             "\"G0\" or \"G1\", or fair = \"variation\" in [skin]");
}

const std::vector<std::string> kPictureKeys = {"file",
                                               "title",
                                               "show",
                                               "contours",
                                               "contour_direction",
                                               "zebra",
                                               "zebra_direction",
                                               "isocurves",
                                               "curves",
                                               "mesh",
                                               "view",
                                               "size"};

ScenePicture scene_picture(const TomlTable& table, const std::string& unit, UniqueNames& files) {
  using Field = PictureScene::Field;
  ScenePicture picture;
  PictureScene& look = picture.look;
  picture.file = output_file(table, "file", files, {".png"});
  look.title = table.text("title", "");
  look.unit = unit;
  look.field = table.choice("show", Field::None,
                            {{"shaded", Field::None},
                             {"mean_curvature", Field::Mean},
                             {"gauss_curvature", Field::Gauss},
                             {"faces", Field::Regions}});
  look.contours = table.integer("contours", 0, 0);
  look.parameter_lines = table.integer("isocurves", 0, 0);
  if (table.has("contour_direction")) {
    if (look.contours == 0)
      table.fail("contour_direction", "'contour_direction' without 'contours'", "both");
    look.contour_direction = table.direction("contour_direction");
  }
  look.zebra = table.integer("zebra", 1, 0);
  if (look.zebra > 0 && look.field != Field::None)
    table.fail("zebra", "'zebra' beside show = \"" + table.text("show") + "\"", "one of them");
  if (table.has("zebra_direction")) {
    if (look.zebra == 0) table.fail("zebra_direction", "'zebra_direction' without 'zebra'", "both");
    look.zebra_direction = table.direction("zebra_direction");
  }
  look.lines = table.boolean("curves", true);
  look.mesh = table.boolean("mesh", false);
  read_view(table, look.azimuth, look.elevation, picture.size);
  return picture;
}

SceneSweep read_sweep(const TomlTable& table, const Scene& scene, UniqueNames& files) {
  SceneSweep sweep;
  sweep.parameter = table.text("parameter");
  sweep.values = table.list("values");
  sweep.columns = table.integer("columns", 1, 0);
  sweep.picture = scene_picture(table, scene.unit, files);
  // All panels of a sheet have the same lines.
  for_each_fair_parameter(scene.fairing, [&](const std::string& name, double) {
    if (name == sweep.parameter)
      table.fail("parameter", "'" + name + "', which changes the curves",
                 "a parameter of loads, constraints or [skin]");
  });
  double present = 0;
  for (const Parameter& p : scene.parameters())
    if (p.name == sweep.parameter) present = p.value;
  Scene(scene).set(sweep.parameter, present, table.at("parameter"));  // throws if the parameter
                                                                      // does not exist
  for (const double value : sweep.values)
    Scene(scene).set(sweep.parameter, value, table.at("values"));
  return sweep;
}

Scene scene_of(const toml::table& root_table, const std::filesystem::path& file,
               bool lines_required) {
  refuse_renamed_keys(root_table, SceneKind::Surface, file.string());
  const TomlTable root(
      file.string(), root_table, "the scene",
      {"name",    "unit",      "fit_tolerance", "corner_angle", "curve",  "curves",    "fair",
       "face",    "join",      "skin",          "mesh",         "target", "neighbour", "constraint",
       "load",    "stiffness", "offset",        "parameter",    "motion", "stress",    "output",
       "compare", "picture",   "sweep",         "field"});
  const std::filesystem::path folder = file.parent_path();
  Scene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = read_unit(root, "unit");
  scene.skin.options.tolerance = root.positive("fit_tolerance", 0);
  scene.skin.options.corner_angle = root.positive("corner_angle", 20);
  scene.skin.corner_angle_is_stated = root.has("corner_angle");
  if (scene.skin.options.corner_angle >= 180)
    root.fail("corner_angle", format_number(scene.skin.options.corner_angle),
              "less than 180 degrees");

  read_network(root, scene);
  scene.lines = read_scene_lines(root, folder, true, lines_required && !root.has("neighbour"));
  scene.fairing = read_fair_stages(root);

  for (const TomlTable& t : root.table("mesh", mesh_keys())) read_mesh(t, scene.skin.options);
  for (const TomlTable& t : root.table("skin", skin_keys())) read_skin(t, scene.skin);
  if (scene.skin.fair == SceneSkin::Fair::Variation &&
      scene.skin.options.element != TriangleElement::HCT)
    throw InputError(scene.at(root.location("mesh")) +
                     "found fair = \"variation\" with element \"z12\", expected element = \"hct\"");
  // Only fairing distinguishes a smooth join from one of tangent planes alone.
  if (scene.skin.fair != SceneSkin::Fair::Variation)
    for (JoinSpec& join : scene.network.joins)
      if (join.kind == JoinSpec::Kind::Tangent) join.kind = JoinSpec::Kind::Smooth;

  for (const TomlTable& t :
       root.tables("target", {"file", "points", "faces", "unit", "cage", "fit_tolerance"}))
    scene.targets.push_back(read_target(t, folder, scene.skin));

  for (const TomlTable& t :
       root.tables("neighbour", {"file", "faces", "without", "continuity", "fill", "openings",
                                 "edges", "bridge", "tension"}))
    scene.neighbours.push_back(read_neighbour(t, folder));

  read_sculpting(root, folder, scene);
  check_fair_keys(root, scene.skin);

  const NamedFields fields = read_fields(root, folder);
  for (const TomlTable& t : root.table("stress", stress_keys()))
    scene.stress = read_stress(t, scene.unit, fields);

  UniqueNames files("file name");
  for (const TomlTable& t : root.table("compare", {"file"}))
    scene.compare = folder / t.text("file");
  for (const TomlTable& t : root.table("output", output_keys())) {
    if (t.has("step")) scene.step = output_file(t, "step", files, {".step", ".stp"});
    using Form = Scene::StepForm;
    scene.step_form =
        t.choice("step_form", Form::Auto,
                 {{"auto", Form::Auto}, {"face", Form::Face}, {"exact", Form::Exact}});
    scene.step_tolerance = t.positive("step_tolerance", 0);
    scene.step_lines = t.boolean("step_curves", false);
    scene.step_ap242 = t.choice("step_schema", false, {{"ap214", false}, {"ap242", true}});
    scene.step_neighbours = t.boolean("step_neighbours", true);
    for (const char* key :
         {"step_form", "step_tolerance", "step_curves", "step_schema", "step_neighbours"})
      if (t.has(key) && scene.step.empty())
        t.fail(key, "'" + std::string(key) + "' without 'step'", "both");
    if (t.has("vtu")) scene.vtu = output_file(t, "vtu", files, {".vtu"});
    if (t.has("vtp")) scene.vtp = output_file(t, "vtp", files, {".vtp"});
    if (t.has("mesh")) scene.mesh = output_file(t, "mesh", files, mesh_file_endings());
    if (t.has("calculix")) scene.calculix = output_file(t, "calculix", files, {".inp"});
    if (t.has("calculix") && !scene.stress)
      t.fail("calculix", "a CalculiX deck", "a section [stress] with material and supports for it");
  }
  for (const TomlTable& t : root.tables("picture", kPictureKeys))
    scene.pictures.push_back(scene_picture(t, scene.unit, files));
  std::vector<std::string> sweep_keys = {"parameter", "values", "columns"};
  sweep_keys.insert(sweep_keys.end(), kPictureKeys.begin(), kPictureKeys.end());
  for (const TomlTable& t : root.tables("sweep", sweep_keys))
    scene.sweeps.push_back(read_sweep(t, scene, files));
  return scene;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::filesystem::path& file, bool lines_required) {
  return scene_of(parse_toml(text, file, "a scene (unit, [[curve]] …)"), file, lines_required);
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_input_file(file, "a scene (.toml)"), file);
}

}  // namespace batten
