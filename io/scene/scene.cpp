// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene.h"

#include <algorithm>
#include <cmath>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

/// Calls f with a reference to each parameter that has a table of its own.
template <class AnyScene, class Function>
void for_each_named(AnyScene& scene, const Function& f) {
  for (auto& load : scene.loads) f(load);
  for (auto& weight : scene.weights) f(weight);
  for (auto& move : scene.moves) f(move);
  for (auto& slider : scene.sliders) f(slider);
}

/// Enumerates all parameters: calls f(name, value, min, max) with a reference to each value.
template <class AnyScene, class Function>
void for_each_parameter(AnyScene& scene, const Function& f) {
  for_each_named(scene, [&](auto& p) { f(p.name, p.value, p.min, p.max); });
  for (auto& c : scene.constraints)
    for (int i = 0; i < 3 && c.type != SceneConstraint::Type::LineNormal; ++i)
      f(c.name + "." + "xyz"[i], c.goal[i], c.middle[i] - c.range, c.middle[i] + c.range);
  auto& alpha = scene.skin.material.alpha;
  auto& beta = scene.skin.material.beta;
  if (scene.skin.isotropic_alpha) {
    f("alpha", alpha(0, 0), 0.0, kInfinity);
  } else {
    f("alpha_uu", alpha(0, 0), 0.0, kInfinity);
    f("alpha_uv", alpha(0, 1), -kInfinity, kInfinity);
    f("alpha_vv", alpha(1, 1), 0.0, kInfinity);
  }
  if (scene.skin.isotropic_beta) {
    f("beta", beta[0], 0.0, kInfinity);
  } else {
    f("beta_uu", beta[0], 0.0, kInfinity);
    f("beta_uv", beta[1], 0.0, kInfinity);
    f("beta_vv", beta[2], 0.0, kInfinity);
  }
  for_each_fair_parameter(
      scene.fairing, [&](const std::string& name, auto& value) { f(name, value, 0.0, kInfinity); });
}

}  // namespace

std::string material_requirement(const SurfaceStiffness& material) {
  const double scale = material.alpha.norm();
  const Vec2 eigenvalues = symmetric_eigenvalues(material.alpha);
  if (eigenvalues[0] < -1e-12 * scale)
    return "alpha ≥ 0: alpha_uu ≥ 0, alpha_vv ≥ 0, alpha_uv² ≤ alpha_uu·alpha_vv";
  if (material.beta.minCoeff() < 0) return "beta ≥ 0";
  if (scale == 0 && material.beta.maxCoeff() == 0) return "alpha or beta above 0";
  return "";
}

std::vector<ScalarParameter> Scene::named_values() const {
  std::vector<ScalarParameter> list;
  for_each_parameter(*this, [&](const std::string& n, double value, double min, double max) {
    ScalarParameter p;
    p.name = n;
    p.value = value;
    p.min = min;
    p.max = max;
    list.push_back(p);
  });
  size_t i = 0;  // parameters with their own table come first, in the same order
  for_each_named(*this, [&](const ScalarParameter& p) { list[i++].keyframes = p.keyframes; });
  for (const SceneRule& rule : rules)
    for (ScalarParameter& p : list) {
      if (p.name != rule.driven) continue;
      if (p.rule_terms.empty()) p.offset = p.value;
      p.rule_terms.push_back({rule.of, rule.factor});
      p.keyframes.clear();
    }
  for (const SceneRule& rule : rules)
    for (ScalarParameter& p : list)
      if (p.name == rule.driven && rule.offset) p.offset = *rule.offset;
  return list;
}

std::vector<Parameter> Scene::parameters() const {
  Parameters all;
  const std::vector<ScalarParameter> values = named_values();
  for (ScalarParameter p : values) {
    p.rule_terms.clear();
    // The value of a driven parameter is not used, so it may be out of range.
    p.value = std::clamp(p.value, p.min, p.max);
    all.add(std::move(p));
  }
  for (const ScalarParameter& p : values)
    if (!p.rule_terms.empty()) all.set_rule(p.name, p.rule_terms, p.offset);
  std::vector<Parameter> list;
  for (const ScalarParameter& p : values) list.push_back({p.name, all.value(p.name), p.min, p.max});
  return list;
}

void Scene::set(const std::string& parameter, double value, const std::string& where) {
  Scene changed = *this;
  std::vector<std::string> names;
  bool known = false;
  for_each_parameter(changed, [&](const std::string& n, double& slot, double min, double max) {
    names.push_back(n);
    if (n != parameter) return;
    known = true;
    if (!(value >= min && value <= max) || !std::isfinite(value))
      throw InputError(where + "found " + format_number(value) + " for '" + n +
                       "', expected a number " +
                       (min == -kInfinity && max == kInfinity ? "" : format_range(min, max)));
    slot = value;
  });
  if (!known)
    throw InputError(where + "found parameter '" + parameter + "', expected " +
                     expected_one_of(parameter, names));
  for (const SceneRule& rule : rules)
    if (rule.driven == parameter)
      throw InputError(where + "found a value for '" + parameter + "', expected one for '" +
                       rule.of + "', which drives it");
  for_each_named(changed, [&](ScalarParameter& p) {
    if (p.name == parameter) p.keyframes.clear();
  });
  SurfaceStiffness& material = changed.skin.material;
  if (parameter == "alpha") material.alpha = value * Mat2::Identity();
  if (parameter == "beta") material.beta = Vec3::Constant(value);
  if (parameter == "alpha_uv") material.alpha(1, 0) = value;
  const std::string expected = material_requirement(material);
  if (!expected.empty())
    throw InputError(where + "found " + format_number(value) + " for '" + parameter +
                     "', expected " + expected);
  for_each_fair_parameter(changed.fairing, [&](const std::string& name, double number_above_0) {
    if (!(number_above_0 > 0))
      throw InputError(where + "found 0 for '" + name + "', expected a number above 0");
  });
  for (const auto& c : changed.constraints)
    if (c.type != SceneConstraint::Type::Point && c.type != SceneConstraint::Type::LineNormal &&
        c.goal.norm() == 0)
      throw InputError(where + "found 0 for '" + parameter + "', expected a direction of '" +
                       c.name + "' that is not [0, 0, 0]");
  *this = std::move(changed);
}

std::string SceneSkin::fair_name() const {
  switch (fair) {
    case Fair::Auto:
      return "auto";
    case Fair::Bending:
      return "bending";
    case Fair::Variation:
      return "variation";
    case Fair::Loft:
      break;
  }
  return "loft";
}

bool Scene::is_sculpted() const {
  return !loads.empty() || !constraints.empty() || !weights.empty() || !moves.empty() ||
         !sliders.empty() || skin.boundary == SceneSkin::FixedBoundary::Corners;
}

bool is_part_of(const std::string& run, const std::string& line) {
  return run == line || (run.starts_with(line + ".") && run.size() > line.size() + 1 &&
                         run.find_first_not_of("0123456789", line.size() + 1) == std::string::npos);
}

namespace {

CurveCondition read_condition(const TomlTable& t) {
  using Type = CurveCondition::Type;
  CurveCondition c;
  c.name = t.text("name");
  c.type = t.choice<Type>("type", {{"point", Type::Point},
                                   {"tangent", Type::Tangent},
                                   {"end_curvature", Type::ZeroEndCurvature},
                                   {"plane", Type::Plane},
                                   {"symmetry", Type::Symmetry}});
  const bool has_place = c.type != Type::ZeroEndCurvature;
  const bool has_direction = has_place && c.type != Type::Point;
  const auto none = [&](const std::string& key, const std::string& expected) {
    if (t.has(key)) t.fail(key, "'" + key + "' for the condition '" + c.name + "'", expected);
  };
  if (has_place)
    c.at = t.vector("at");
  else
    none("at", "none: end_curvature applies to both ends of the curve");
  if (has_direction)
    c.direction = t.direction("direction");
  else
    none("direction", "it only where type = \"tangent\", \"plane\" or \"symmetry\"");
  return c;
}

void read_balance(const TomlTable& t, FairOptions& options) {
  using Smoothing = FairOptions::Smoothing;
  std::string given;
  for (const std::string key : {"noise", "deviation", "wavelength"}) {
    if (!t.has(key)) continue;
    if (!given.empty())
      t.fail(key, "both '" + given + "' and '" + key + "'", "one of them, or none");
    given = key;
  }
  if (t.has("noise")) {
    options.smoothing = Smoothing::Noise;
    options.noise = t.positive("noise");
  }
  if (t.has("deviation")) {
    options.smoothing = Smoothing::Deviation;
    options.deviation = t.positive("deviation");
  }
  if (t.has("wavelength")) {
    options.smoothing = Smoothing::Wavelength;
    options.wavelength = t.positive("wavelength");
  }
}

void read_local(const TomlTable& t, SceneFairStage& stage) {
  if (t.has("brush") && t.has("segment"))
    t.fail("segment", "both 'brush' and 'segment'", "one of them");
  const std::string kind = t.has("brush") ? "brush" : "segment";
  for (const char* key : {"noise", "deviation", "corner_angle", "corners", "closed", "fix_ends",
                          "alpha", "condition", "minimize", "outliers"})
    if (t.has(key))
      t.fail(key, "'" + std::string(key) + "' beside '" + kind + "'",
             "it only in a stage without 'brush' and 'segment'; these have a 'wavelength'");
  for (const TomlTable& b : t.table("brush", {"at", "radius"}))
    stage.brush = {b.vector("at"), b.positive("radius")};
  for (const TomlTable& s : t.table("segment", {"from", "to"}))
    stage.segment = {s.vector("from"), s.vector("to")};
  stage.options.smoothing = FairOptions::Smoothing::Wavelength;
  stage.options.wavelength = t.positive("wavelength");
}

SceneFairStage read_stage(const TomlTable& t, size_t index) {
  SceneFairStage stage;
  stage.name = t.text("name", "fair-" + std::to_string(index + 1));
  stage.location = t.location();
  stage.lines = t.names("curves");
  if (t.has("brush") || t.has("segment")) {
    read_local(t, stage);
    return stage;
  }
  FairOptions& o = stage.options;
  read_balance(t, o);
  if (t.has("minimize")) {
    for (const char* key : {"noise", "deviation", "wavelength", "corners", "fix_ends", "alpha",
                            "condition", "outliers"})
      if (t.has(key))
        t.fail(key, "'" + std::string(key) + "' beside 'minimize'",
               "none: the curve goes through all points");
    stage.minimum = t.choice<CurveFunctional>(
        "minimize",
        {{"bending", CurveFunctional::Energy}, {"variation", CurveFunctional::Variation}});
  }
  o.corner_angle = t.positive("corner_angle", o.corner_angle);
  if (o.corner_angle > 180)
    t.fail("corner_angle", format_number(o.corner_angle), "at most 180 degrees (180: no corners)");
  if (t.has("corners")) stage.corners = t.points("corners");
  if (t.has("closed")) o.closed = t.boolean("closed", false);
  o.reject_outliers = t.choice<bool>("outliers", true, {{"drop", true}, {"keep", false}});
  if (t.has("fix_ends")) stage.fix_ends = t.boolean("fix_ends", false);
  o.alpha = t.number("alpha", 0);
  if (o.alpha < 0) t.fail("alpha", format_number(o.alpha), "0 or more");
  UniqueNames conditions("condition");
  conditions.read(t, "condition", {"name", "type", "at", "direction"}, o.conditions,
                  read_condition);
  return stage;
}

}  // namespace

std::vector<SceneFairStage> read_fair_stages(const TomlTable& root) {
  std::vector<SceneFairStage> stages;
  UniqueNames names("stage");
  names.read(
      root, "fair",
      {"name", "curves", "noise", "deviation", "wavelength", "outliers", "corner_angle", "corners",
       "closed", "fix_ends", "alpha", "condition", "minimize", "brush", "segment"},
      stages, [&](const TomlTable& t) { return read_stage(t, stages.size()); });
  return stages;
}

}  // namespace batten
