// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sessions/session_log_entities.h"

#include "batten/core/containers.h"

namespace batten::session_log {
namespace {

const std::vector<std::string> kLoadKeys = {
    "name",  "type", "near",     "radius", "paint",       "faces",   "direction", "at",
    "curve", "to",   "geometry", "plane",  "rest_length", "falloff", "points"};

const std::vector<std::string> kConstraintKeys = {
    "name", "type", "at", "to", "normal", "curve", "parametric_direction", "direction"};

const std::vector<std::string> kParameterKeys = {"name",      "value", "min",   "max",
                                                 "keyframes", "terms", "offset"};

constexpr std::pair<CharacterLine::Role, const char*> kRoles[] = {
    {CharacterLine::Role::Inner, "inner"},
    {CharacterLine::Role::Outline, "outline"},
    {CharacterLine::Role::Hole, "hole"}};

constexpr std::pair<CharacterLine::MeshAlignment, const char*> kMeshAlignments[] = {
    {CharacterLine::MeshAlignment::Auto, "auto"},
    {CharacterLine::MeshAlignment::EdgeAligned, "aligned"},
    {CharacterLine::MeshAlignment::Embedded, "embedded"}};

LogJson json_points(const std::vector<Vec3>& points) {
  LogJson list = LogJson::array();
  for (const Vec3& p : points) list.push_back(json_vector(p));
  return list;
}

void add_area(LogJson& json, const Area& area) {
  if (const auto* near = std::get_if<Area::NearLine>(&area.where)) {
    json["near"] = near->line;
    json["radius"] = json_number(near->radius);
  } else if (const auto* painted = std::get_if<Area::Painted>(&area.where)) {
    json["paint"] = json_of(painted->strokes);
  }
  if (!area.regions.empty()) json["faces"] = area.regions;
}

Area area_of(const LogObject& object) {
  Area area;
  if (object.has("near"))
    area.where = Area::NearLine{object.text("near"), object.number("radius")};
  else if (object.has("paint"))
    area.where = Area::Painted{strokes_of(object, "paint")};
  if (object.has("faces")) area.regions = object.strings("faces");
  return area;
}

/// Converts a piecewise cubic C1 curve to its nodes.
HermiteCurve nodes_of(const CharacterLine& line) {
  const auto refuse = [&](const std::string& what) {
    throw InputError("session log: found the curve '" + line.name + "', which " + what +
                     ", expected a piecewise cubic without corners");
  };
  if (!line.curve || !line.curve->piecewise_cubic()) refuse("is not piecewise cubic");
  const InputCurve& curve = *line.curve;
  const std::vector<double> at = curve.breaks();
  Points positions(isize(at), 3), slopes(isize(at), 3);
  for (size_t i = 0; i < at.size(); ++i) {
    const int k = static_cast<int>(i);
    positions.row(k) = curve.evaluate(at[i]);
    slopes.row(k) = curve.evaluate(at[i], 1);
    if (i == 0) continue;
    // The cubic with this piece's start derivatives and end position must end with its slope.
    const double h = at[i] - at[i - 1];
    const Vec3 start = slopes.row(k - 1), bend = curve.evaluate(at[i - 1], 2);
    const Vec3 chord = (positions.row(k) - positions.row(k - 1)) / h;
    const Vec3 end = 3 * chord - 2 * start - 0.5 * h * bend;
    if ((end - Vec3(slopes.row(k))).norm() > 1e-6 * (start.norm() + chord.norm()))
      refuse("has a corner");
  }
  return {at, positions, slopes};
}

ScalarParameter parameter_from(const LogObject& p) {
  ScalarParameter value;
  value.name = p.text("name");
  value.value = p.number("value", 0);
  value.min = p.number("min", value.min);
  value.max = p.number("max", value.max);
  value.offset = p.number("offset", 0);
  if (p.has("keyframes"))
    for (const LogJson& keyframe : p.array("keyframes")) {
      const LogJson pair = {{"keyframe", keyframe}};
      const VecX m = LogObject(pair, p.where(), "'keyframes'", {"keyframe"}).numbers("keyframe", 2);
      value.keyframes.push_back({m[0], m[1]});
    }
  if (p.has("terms")) value.rule_terms = terms_of(p, "terms");
  return value;
}

}  // namespace

LogJson json_of(const std::vector<Area::Painted::Stroke>& strokes) {
  LogJson list = LogJson::array();
  for (const auto& s : strokes)
    list.push_back({{"at", json_vector(s.at)},
                    {"radius", json_number(s.radius)},
                    {"strength", json_number(s.strength)}});
  return list;
}

std::vector<Area::Painted::Stroke> strokes_of(const LogObject& object, const std::string& key) {
  std::vector<Area::Painted::Stroke> strokes;
  for (const LogObject& s : object.objects(key, {"at", "radius", "strength"}))
    strokes.push_back({s.vector("at"), s.number("radius"), s.number("strength", 1)});
  return strokes;
}

LogJson json_of(const HermiteCurve& curve) {
  LogJson dofs = LogJson::array(), parameters = LogJson::array();
  for (int i = 0; i < curve.dofs().rows(); ++i) dofs.push_back(json_vector(curve.dofs().row(i)));
  for (const double u : curve.parameters()) parameters.push_back(json_number(u));
  return {{"parameters", parameters},
          {"closed", curve.closed()},
          {"corners", curve.mesh().corners()},
          {"dofs", dofs}};
}

HermiteCurve curve_of(const LogObject& parent, const std::string& key) {
  const LogObject object = parent.object(key, {"parameters", "closed", "corners", "dofs"});
  const std::vector<Vec3> rows = object.points("dofs");
  std::vector<int> corners;
  for (const double corner : object.list("corners")) corners.push_back(static_cast<int>(corner));
  Points dofs(isize(rows), 3);
  for (size_t i = 0; i < rows.size(); ++i) dofs.row(static_cast<int>(i)) = rows[i];
  return {CurveMesh(object.list("parameters"), object.boolean("closed"), corners), std::move(dofs)};
}

LogJson json_of(const Load& load) {
  LogJson json = {{"name", load.name}};
  std::visit(Overloaded{[&](const Load::Pressure& p) {
                          json["type"] = "pressure";
                          add_area(json, p.area);
                        },
                        [&](const Load::Uniform& u) {
                          json["type"] = "uniform";
                          json["direction"] = json_vector(u.direction);
                          add_area(json, u.area);
                        },
                        [&](const Load::Gravity& g) {
                          json["type"] = "gravity";
                          json["direction"] = json_vector(g.direction);
                        },
                        [&](const Load::Point& p) {
                          json["type"] = "point";
                          json["at"] = json_vector(p.at);
                          json["direction"] = json_vector(p.direction);
                        },
                        [&](const Load::Line& l) {
                          json["type"] = "line";
                          json["curve"] = l.line;
                          json["direction"] = json_vector(l.direction);
                        },
                        [&](const Load::AttractorSprings& s) {
                          json["type"] = "attractors";
                          json["at"] = json_points(s.at);
                          if (const auto* places =
                                  std::get_if<Load::AttractorSprings::TargetPoints>(&s.target)) {
                            json["to"] = json_points(places->to);
                          } else if (const auto* c =
                                         std::get_if<Load::AttractorSprings::Curve>(&s.target)) {
                            json["geometry"] = json_of(c->curve);
                          } else {
                            const auto& plane = std::get<Load::AttractorSprings::Plane>(s.target);
                            json["plane"] = {{"origin", json_vector(plane.through)},
                                             {"normal", json_vector(plane.normal)}};
                          }
                          json["rest_length"] = json_number(s.rest_length);
                          json["falloff"] = json_number(s.falloff);
                        },
                        [&](const Load::PointCloudSprings& s) {
                          json["type"] = "point_cloud";
                          json["points"] = json_points(s.points);
                        }},
             load.kind);
  return json;
}

namespace {
Load::AttractorSprings::Plane plane_of(const LogObject& parent) {
  const LogObject plane = parent.object("plane", {"origin", "normal"});
  return {plane.vector("origin"), plane.vector("normal")};
}
}  // namespace

Load load_of(const LogObject& parent) {
  const LogObject o = parent.object("load", kLoadKeys);
  const auto kind = [&]() -> decltype(Load::kind) {
    const std::string type = o.text("type");
    if (type == "pressure") return Load::Pressure{area_of(o)};
    if (type == "uniform") return Load::Uniform{o.vector("direction"), area_of(o)};
    if (type == "gravity") return Load::Gravity{o.vector("direction")};
    if (type == "point") return Load::Point{o.vector("at"), o.vector("direction")};
    if (type == "line") return Load::Line{o.text("curve"), o.vector("direction")};
    if (type == "point_cloud") return Load::PointCloudSprings{o.points("points")};
    if (type != "attractors") {
      const std::vector<std::string> types = {"pressure", "uniform",    "gravity",    "point",
                                              "line",     "attractors", "point_cloud"};
      o.fail("the load type '" + type + "'", expected_one_of(type, types));
    }
    Load::AttractorSprings attractors;
    attractors.at = o.points("at");
    if (o.has("to"))
      attractors.target = Load::AttractorSprings::TargetPoints{o.points("to")};
    else if (o.has("geometry"))
      attractors.target = Load::AttractorSprings::Curve{curve_of(o, "geometry")};
    else
      attractors.target = plane_of(o);
    attractors.rest_length = o.number("rest_length", 0);
    attractors.falloff = o.number("falloff", 0);
    return attractors;
  };
  return {o.text("name"), kind()};
}

LogJson json_of(const StiffnessField& stiffness) {
  LogJson json = {{"name", stiffness.name},
                  {"type", stiffness.kind == StiffnessField::Kind::Bending ? "beta" : "alpha"}};
  add_area(json, stiffness.area);
  if (stiffness.along) {
    if (const auto* line = std::get_if<std::string>(&*stiffness.along)) {
      json["along"] = *line;
    } else {
      const Vec2& along = std::get<Vec2>(*stiffness.along);
      json["parametric_direction"] = {json_number(along[0]), json_number(along[1])};
    }
  }
  return json;
}

StiffnessField stiffness_of(const LogObject& parent) {
  const LogObject o = parent.object("stiffness", {"name", "type", "near", "radius", "paint",
                                                  "faces", "along", "parametric_direction"});
  StiffnessField stiffness;
  stiffness.name = o.text("name");
  const std::string type = o.text("type");
  if (type != "alpha" && type != "beta") o.fail("the type '" + type + "'", "one of: alpha, beta");
  stiffness.kind =
      type == "beta" ? StiffnessField::Kind::Bending : StiffnessField::Kind::Stretching;
  stiffness.area = area_of(o);
  if (o.has("along"))
    stiffness.along = o.text("along");
  else if (o.has("parametric_direction"))
    stiffness.along = Vec2(o.numbers("parametric_direction", 2));
  return stiffness;
}

LogJson json_of(const Constraint& constraint) {
  LogJson json = {{"name", constraint.name}};
  std::visit(
      Overloaded{
          [&](const Constraint::Point& p) {
            json["type"] = "point";
            json["at"] = json_vector(p.at);
            json["to"] = json_vector(p.goal);
          },
          [&](const Constraint::Normal& n) {
            json["type"] = "normal";
            json["at"] = json_vector(n.at);
            json["normal"] = json_vector(n.normal);
          },
          [&](const Constraint::Tangent& t) {
            json["type"] = "tangent";
            json["at"] = json_vector(t.at);
            json["parametric_direction"] = {json_number(t.along[0]), json_number(t.along[1])};
            json["direction"] = json_vector(t.tau);
          },
          [&](const Constraint::LineNormal& l) {
            json["type"] = "curve_normal";
            json["curve"] = l.line;
            if (l.normal) json["normal"] = json_vector(*l.normal);
          }},
      constraint.kind);
  return json;
}

Constraint constraint_of(const LogObject& parent) {
  const LogObject o = parent.object("constraint", kConstraintKeys);
  const auto kind = [&]() -> decltype(Constraint::kind) {
    const std::string type = o.text("type");
    if (type == "point") return Constraint::Point{o.vector("at"), o.vector("to")};
    if (type == "normal") return Constraint::Normal{o.vector("at"), o.vector("normal")};
    if (type == "tangent")
      return Constraint::Tangent{o.vector("at"), Vec2(o.numbers("parametric_direction", 2)),
                                 o.vector("direction")};
    if (type == "curve_normal") {
      std::optional<Vec3> normal;
      if (o.has("normal")) normal = o.vector("normal");
      return Constraint::LineNormal{o.text("curve"), normal};
    }
    const std::vector<std::string> types = {"point", "normal", "tangent", "curve_normal"};
    o.fail("the constraint type '" + type + "'", expected_one_of(type, types));
  };
  return {o.text("name"), kind()};
}

LogJson json_of(const LineOffset& offset) {
  LogJson json = {
      {"name", offset.name}, {"curve", offset.line}, {"fade", json_number(offset.fade)}};
  if (offset.direction) json["direction"] = json_vector(*offset.direction);
  return json;
}

LineOffset offset_of(const LogObject& parent) {
  const LogObject o = parent.object("offset", {"name", "curve", "direction", "fade"});
  LineOffset offset{o.text("name"), o.text("curve"), {}, o.number("fade", 0)};
  if (o.has("direction")) offset.direction = o.vector("direction");
  return offset;
}

LogJson json_of(const CharacterLine& line) {
  LogJson json = {{"name", line.name}};
  for (const auto& [role, name] : kRoles)
    if (role == line.role) json["role"] = name;
  for (const auto& [mesh_alignment, name] : kMeshAlignments)
    if (mesh_alignment == line.mesh_alignment) json["alignment"] = name;
  json["geometry"] = json_of(nodes_of(line));
  return json;
}

CharacterLine character_line_of(const LogObject& parent) {
  const LogObject o = parent.object("curve", {"name", "role", "alignment", "geometry"});
  CharacterLine line;
  line.name = o.text("name");
  const auto choose = [&](const std::string& key, const auto& table, auto& slot) {
    std::vector<std::string> names;
    const std::string found = o.text(key);
    for (const auto& [value, name] : table) {
      names.emplace_back(name);
      if (found == name) return void(slot = value);
    }
    o.fail("the " + key + " '" + found + "'", expected_one_of(found, names));
  };
  choose("role", kRoles, line.role);
  choose("alignment", kMeshAlignments, line.mesh_alignment);
  line.curve = curve_from_hermite(curve_of(o, "geometry"));
  return line;
}

LogJson json_of(const std::vector<ScalarParameter::Term>& terms) {
  LogJson list = LogJson::array();
  for (const auto& term : terms)
    list.push_back({{"name", term.of}, {"factor", json_number(term.factor)}});
  return list;
}

LogJson json_of(const ScalarParameter& p) {
  LogJson json = {{"name", p.name}, {"value", json_number(p.value)}};
  if (std::isfinite(p.min)) json["min"] = p.min;
  if (std::isfinite(p.max)) json["max"] = p.max;
  for (const auto& keyframe : p.keyframes)
    json["keyframes"].push_back({json_number(keyframe.time), json_number(keyframe.value)});
  if (!p.rule_terms.empty()) json["terms"] = json_of(p.rule_terms);
  if (p.offset != 0) json["offset"] = json_number(p.offset);
  return json;
}

std::vector<ScalarParameter::Term> terms_of(const LogObject& o, const std::string& key) {
  std::vector<ScalarParameter::Term> terms;
  for (const LogObject& term : o.objects(key, {"name", "factor"}))
    terms.push_back({term.text("name"), term.number("factor")});
  return terms;
}

std::vector<ScalarParameter> parameters_of(const LogObject& o) {
  std::vector<ScalarParameter> list;
  if (!o.has("parameters")) return list;
  for (const LogObject& p : o.objects("parameters", kParameterKeys))
    list.push_back(parameter_from(p));
  return list;
}

ScalarParameter parameter_of(const LogObject& parent) {
  return parameter_from(parent.object("parameter", kParameterKeys));
}

}  // namespace batten::session_log
