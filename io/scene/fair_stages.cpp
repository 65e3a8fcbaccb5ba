#include "batten/io/scene/fair_stages.h"

#include "batten/core/errors.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
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
    none("at", "none: end_curvature is about both ends of the curve");
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

void read_local(const TomlTable& t, FairStage& stage) {
  if (t.has("brush") && t.has("stretch"))
    t.fail("stretch", "both 'brush' and 'stretch'", "one of them");
  const std::string kind = t.has("brush") ? "brush" : "stretch";
  for (const char* key : {"noise", "deviation", "corner_angle", "corners", "closed", "hold_ends",
                          "alpha", "condition", "minimum", "outliers"})
    if (t.has(key))
      t.fail(key, "'" + std::string(key) + "' beside '" + kind + "'",
             "it only in a stage of whole lines: local stages have a 'wavelength'");
  for (const TomlTable& b : t.table("brush", {"at", "radius"}))
    stage.brush = {b.vector("at"), b.positive("radius")};
  for (const TomlTable& s : t.table("stretch", {"from", "to"}))
    stage.segment = {s.vector("from"), s.vector("to")};
  stage.options.smoothing = FairOptions::Smoothing::Wavelength;
  stage.options.wavelength = t.positive("wavelength");
}

FairStage read_stage(const TomlTable& t, size_t index) {
  FairStage stage;
  stage.name = t.text("name", "fair-" + std::to_string(index + 1));
  stage.location = t.location();
  stage.lines = t.names("lines");
  if (t.has("brush") || t.has("stretch")) {
    read_local(t, stage);
    return stage;
  }
  FairOptions& o = stage.options;
  read_balance(t, o);
  if (t.has("minimum")) {
    for (const char* key : {"noise", "deviation", "wavelength", "corners", "hold_ends", "alpha",
                            "condition", "outliers"})
      if (t.has(key))
        t.fail(key, "'" + std::string(key) + "' beside 'minimum'",
               "none: the curve goes through all points");
    stage.minimum = t.choice<CurveFunctional>(
        "minimum",
        {{"energy", CurveFunctional::Energy}, {"variation", CurveFunctional::Variation}});
  }
  o.corner_angle = t.positive("corner_angle", o.corner_angle);
  if (o.corner_angle > 180)
    t.fail("corner_angle", format_number(o.corner_angle), "at most 180 degrees (180: no corners)");
  if (t.has("corners")) stage.corners = t.points("corners");
  if (t.has("closed")) o.closed = t.boolean("closed", false);
  o.reject_outliers = t.choice<bool>("outliers", true, {{"drop", true}, {"keep", false}});
  if (t.has("hold_ends")) stage.fix_ends = t.boolean("hold_ends", false);
  o.alpha = t.number("alpha", 0);
  if (o.alpha < 0) t.fail("alpha", format_number(o.alpha), "0 or more");
  UniqueNames conditions("condition");
  conditions.read(t, "condition", {"name", "type", "at", "direction"}, o.conditions,
                  read_condition);
  return stage;
}

}  // namespace

std::vector<FairStage> read_fair_stages(const TomlTable& root) {
  std::vector<FairStage> stages;
  UniqueNames names("stage");
  names.read(
      root, "fair",
      {"name", "lines", "noise", "deviation", "wavelength", "outliers", "corner_angle", "corners",
       "closed", "hold_ends", "alpha", "condition", "minimum", "brush", "stretch"},
      stages, [&](const TomlTable& t) { return read_stage(t, stages.size()); });
  return stages;
}

}  // namespace batten
