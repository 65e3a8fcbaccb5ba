#include "batten/io/scene/scene_sculpting.h"

#include <algorithm>
#include <initializer_list>

#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

LocatedString placed(const TomlTable& table, const std::string& key) {
  return {table.text(key), table.location(key)};
}

/// name, value (a number, or over time), min, max.
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

/// Keys that a thing of its type does not know: each answered with what has it.
void refuse(const TomlTable& table, const std::string& what,
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
                                       {"line_normal", Type::LineNormal}});
  const std::string what = "the constraint '" + c.name + "'";
  const bool point = c.type == Type::Point, along_line = c.type == Type::LineNormal;
  const char* only_point = "it only where type = \"point\"";
  if (!point) refuse(table, what, {{"to", only_point}, {"range", only_point}});
  if (point || along_line)
    refuse(table, what, {{"direction", "it only where type = \"normal\" or \"tangent\""}});
  if (c.type != Type::Tangent) refuse(table, what, {{"along", "it only where type = \"tangent\""}});
  if (along_line) {
    refuse(table, what, {{"at", "'line': it acts all along that"}});
    c.line = placed(table, "line");
    c.keep_tangent_planes = !table.has("normal");
    if (!c.keep_tangent_planes) c.goal = c.middle = table.direction("normal");
    return c;
  }
  const char* only_line = "it only where type = \"line_normal\"";
  refuse(table, what, {{"line", only_line}, {"normal", only_line}});
  c.at = table.vector("at");
  c.goal = point ? table.vector("to") : table.direction("direction");
  c.middle = c.goal;
  if (table.has("range")) c.range = table.positive("range");
  if (c.type == Type::Tangent) {
    c.along = table.numbers("along", "su, sv");
    if (c.along.norm() == 0) table.fail("along", "[0, 0]", "a direction [su, sv]");
    c.along.normalize();
  }
  return c;
}

/// Reads pulls: the places that they draw, towards what, how long and how far.
void read_pulls(const TomlTable& table, const std::filesystem::path& folder, SceneLoad& load) {
  Load::AttractorSprings& pulls = load.pulls;
  pulls.at = table.points("at");
  if (pulls.at.empty()) table.fail("at", "an empty list", "one place or more");
  const int targets = table.has("to") + table.has("curve") + table.has("plane");
  if (targets != 1)
    table.fail(
        "at",
        targets == 0 ? "pulls without anything that draws them" : "pulls with more than one target",
        "one of: to, curve, plane");
  if (table.has("to")) {
    const auto to = table.points("to");
    if (to.size() != pulls.at.size())
      table.fail("to", std::to_string(to.size()) + " points",
                 std::to_string(pulls.at.size()) + ", one for each place of 'at'");
    pulls.target = Load::AttractorSprings::TargetPoints{to};
  }
  if (table.has("curve")) {
    load.curve = placed(table, "curve");
    load.file = folder / load.curve.text;
    load.location = load.curve.location;
  }
  for (const TomlTable& t : table.table("plane", {"through", "normal"}))
    pulls.target = Load::AttractorSprings::Plane{t.vector("through"), t.direction("normal")};
  for (const auto& [key, slot] :
       {std::pair<const char*, double*>{"rest_length", &pulls.rest_length},
        {"falloff", &pulls.falloff}}) {
    *slot = table.number(key, 0);
    if (*slot < 0) table.fail(key, format_number(*slot), "a length, not below 0");
  }
}

/// Reads the direction, of types that have one.
void read_direction(const TomlTable& table, const std::string& what, SceneLoad& load) {
  using Type = SceneLoad::Type;
  if (load.type == Type::Pressure)
    refuse(table, what, {{"direction", "none: pressure acts along the surface's normal"}});
  else if (load.type == Type::PointCloudSprings || load.type == Type::AttractorSprings)
    refuse(table, what, {{"direction", "none: it draws the surface towards its points"}});
  else
    load.direction = table.direction("direction");
}

/// Refuses keys that only other types have.
void refuse_keys_of_other_types(const TomlTable& table, const std::string& what,
                                SceneLoad::Type type) {
  using Type = SceneLoad::Type;
  const auto refuse_unless = [&](std::initializer_list<Type> types, const std::string& words,
                                 std::initializer_list<const char*> keys) {
    if (std::find(types.begin(), types.end(), type) != types.end()) return;
    const std::string expected = "it only where type = " + words;
    for (const char* key : keys) refuse(table, what, {{key, expected.c_str()}});
  };
  refuse_unless({Type::PointCloudSprings}, "\"scan\"", {"file", "unit"});
  refuse_unless({Type::AttractorSprings}, "\"pulls\"",
                {"to", "curve", "plane", "rest_length", "falloff"});
  refuse_unless({Type::Line}, "\"line\"", {"line"});
  refuse_unless({Type::Point, Type::AttractorSprings}, "\"point\" or \"pulls\"", {"at"});
  refuse_unless({Type::Pressure, Type::Uniform}, "\"pressure\" or \"uniform\"",
                {"near", "radius", "paint", "regions"});
}

/// Reads which points a scan has.
void read_scan(const TomlTable& table, const std::filesystem::path& folder, SceneLoad& load) {
  load.file = folder / table.text("file");
  load.location = table.location("file");
  if (table.has("unit")) load.unit = read_unit(table, "unit");
}

/// Checks stiffnesses, now and over time, and keeps sliders from going below 0.
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
                                          {"scan", Type::PointCloudSprings},
                                          {"pulls", Type::AttractorSprings}});
  const std::string what = "the load '" + load.name + "'";
  read_direction(table, what, load);
  refuse_keys_of_other_types(table, what, load.type);
  if (load.type == Type::Pressure || load.type == Type::Uniform) load.area = read_area(table);
  if (load.type == Type::Point) load.at = table.vector("at");
  if (load.type == Type::Line) load.line = placed(table, "line");
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
  weight.kind = table.choice<Kind>("kind", {{"alpha", Kind::Stretching}, {"beta", Kind::Bending}});
  weight.area = read_area(table);
  if (table.has("along") && table.is_array("along")) {
    const Vec2 along = table.numbers("along", "u, v");
    if (along.norm() == 0) table.fail("along", "[0, 0]", "a direction [u, v], or a line's name");
    weight.along = Vec2(along.normalized());
  } else if (table.has("along")) {
    weight.along = placed(table, "along");
  }
  return weight;
}

SceneLineOffset read_move(const TomlTable& table) {
  SceneLineOffset move;
  read_named_value(table, move);
  move.name_location = table.location("name");
  move.line = placed(table, "line");
  if (table.has("direction")) move.direction = table.direction("direction");
  if (table.has("fade")) move.fade = table.number("fade", 0);
  if (move.fade && !(*move.fade >= 0 && *move.fade <= 0.5))
    table.fail("fade", format_number(*move.fade), "a share of the line's length from 0 to 0.5");
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

/// That there is such a line, as far as the scene itself can tell.
void check_line(const Scene& scene, const LocatedString& line) {
  std::vector<std::string> names;
  for (const SceneLine& source : scene.lines) {
    if (source.name.empty()) return;  // [[lines]]: its file knows
    if (is_part_of(line.text, source.name)) return;
    names.push_back(source.name);
  }
  throw InputError(scene.at(line.location) + "found the line '" + line.text + "', expected " +
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

/// That each rule drives something, once, and that no two go around in a circle.
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
        fail("'" + name + "' to drive, which changes the lines",
             "a parameter of loads, weights, moves, constraints or [skin]");
    });
    const auto expect_number = [&](const ScalarParameter& p) {
      if (p.name == rule.driven && !p.keyframes.empty())
        fail("'" + rule.driven + "' to drive, whose value is one over time", "a number there");
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
  names.read(root, "constraint",
             {"name", "type", "at", "to", "range", "direction", "along", "line", "normal"},
             scene.constraints, read_constraint);
  for (const TomlTable& t :
       root.tables("load", {"name", "type", "value", "min", "max", "direction", "at", "line",
                            "near", "radius", "paint", "regions", "file", "unit", "to", "curve",
                            "plane", "rest_length", "falloff"})) {
    scene.loads.push_back(read_load(t, folder));
    add_name(t, "load", scene.loads.back().name);
  }
  for (const TomlTable& t : root.tables("weight", {"name", "kind", "value", "min", "max", "near",
                                                   "radius", "paint", "regions", "along"})) {
    scene.weights.push_back(read_weight(t));
    add_name(t, "weight", scene.weights.back().name);
  }
  for (const TomlTable& t :
       root.tables("move", {"name", "line", "value", "min", "max", "direction", "fade"})) {
    scene.moves.push_back(read_move(t));
    add_name(t, "move", scene.moves.back().name);
  }
  for (const TomlTable& t : root.tables("parameter", {"name", "value", "min", "max", "drives"})) {
    ScalarParameter& slider = scene.sliders.emplace_back();
    read_named_value(t, slider);
    add_name(t, "parameter", slider.name);
    for (const TomlTable& d : t.tables("drives", {"name", "factor", "offset"})) {
      SceneRule rule{slider.name, d.text("name"), d.location("name"), d.number("factor"), {}};
      if (d.has("offset")) rule.offset = d.number("offset");
      scene.rules.push_back(rule);
    }
  }
  for (const TomlTable& t : root.table("motion", {"density", "damping", "theta"}))
    scene.motion = read_motion(t);
  check_lines(scene);
  check_rules(scene);
}

}  // namespace batten
