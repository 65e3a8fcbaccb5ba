#include "batten/io/sessions/session_log_entities.h"

#include "batten/core/containers.h"

namespace batten::session_log {
namespace {

const std::vector<std::string> kLoadKeys = {
    "name", "type", "near",  "radius",  "paint",  "regions",     "direction", "at",
    "line", "to",   "curve", "through", "normal", "rest_length", "falloff",   "points"};

const std::vector<std::string> kConstraintKeys = {"name",   "type", "at",    "goal",
                                                  "normal", "line", "along", "tau"};

const std::vector<std::string> kParameterKeys = {"name",      "value",   "min",   "max",
                                                 "over_time", "follows", "offset"};

constexpr std::pair<CharacterLine::Role, const char*> kRoles[] = {
    {CharacterLine::Role::Inner, "inner"},
    {CharacterLine::Role::Outline, "outline"},
    {CharacterLine::Role::Hole, "hole"}};

constexpr std::pair<CharacterLine::MeshAlignment, const char*> kMeshAlignments[] = {
    {CharacterLine::MeshAlignment::Auto, "auto"},
    {CharacterLine::MeshAlignment::EdgeAligned, "fitted"},
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
  if (!area.regions.empty()) json["regions"] = area.regions;
}

Area area_of(const LogObject& object) {
  Area area;
  if (object.has("near"))
    area.where = Area::NearLine{object.text("near"), object.number("radius")};
  else if (object.has("paint"))
    area.where = Area::Painted{strokes_of(object, "paint")};
  if (object.has("regions")) area.regions = object.strings("regions");
  return area;
}

/// Converts a piecewise cubic C1 line to its nodes.
HermiteCurve nodes_of(const CharacterLine& line) {
  const auto refuse = [&](const std::string& what) {
    throw InputError("session log: found the line '" + line.name + "', which " + what +
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
      refuse("turns a corner");
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
  if (p.has("over_time"))
    for (const LogJson& keyframe : p.array("over_time")) {
      const LogJson pair = {{"moment", keyframe}};
      const VecX m = LogObject(pair, p.where(), "'over_time'", {"moment"}).numbers("moment", 2);
      value.keyframes.push_back({m[0], m[1]});
    }
  if (p.has("follows")) value.rule_terms = terms_of(p, "follows");
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
                          json["line"] = l.line;
                          json["direction"] = json_vector(l.direction);
                        },
                        [&](const Load::AttractorSprings& s) {
                          json["type"] = "pulls";
                          json["at"] = json_points(s.at);
                          if (const auto* places =
                                  std::get_if<Load::AttractorSprings::TargetPoints>(&s.target)) {
                            json["to"] = json_points(places->to);
                          } else if (const auto* c =
                                         std::get_if<Load::AttractorSprings::Curve>(&s.target)) {
                            json["curve"] = json_of(c->curve);
                          } else {
                            const auto& plane = std::get<Load::AttractorSprings::Plane>(s.target);
                            json["through"] = json_vector(plane.through);
                            json["normal"] = json_vector(plane.normal);
                          }
                          json["rest_length"] = json_number(s.rest_length);
                          json["falloff"] = json_number(s.falloff);
                        },
                        [&](const Load::PointCloudSprings& s) {
                          json["type"] = "scan";
                          json["points"] = json_points(s.points);
                        }},
             load.kind);
  return json;
}

Load load_of(const LogObject& parent) {
  const LogObject o = parent.object("load", kLoadKeys);
  const auto kind = [&]() -> decltype(Load::kind) {
    const std::string type = o.text("type");
    if (type == "pressure") return Load::Pressure{area_of(o)};
    if (type == "uniform") return Load::Uniform{o.vector("direction"), area_of(o)};
    if (type == "gravity") return Load::Gravity{o.vector("direction")};
    if (type == "point") return Load::Point{o.vector("at"), o.vector("direction")};
    if (type == "line") return Load::Line{o.text("line"), o.vector("direction")};
    if (type == "scan") return Load::PointCloudSprings{o.points("points")};
    if (type != "pulls") {
      const std::vector<std::string> types = {"pressure", "uniform", "gravity", "point",
                                              "line",     "pulls",   "scan"};
      o.fail("the load type '" + type + "'", expected_one_of(type, types));
    }
    Load::AttractorSprings pulls;
    pulls.at = o.points("at");
    if (o.has("to"))
      pulls.target = Load::AttractorSprings::TargetPoints{o.points("to")};
    else if (o.has("curve"))
      pulls.target = Load::AttractorSprings::Curve{curve_of(o, "curve")};
    else
      pulls.target = Load::AttractorSprings::Plane{o.vector("through"), o.vector("normal")};
    pulls.rest_length = o.number("rest_length", 0);
    pulls.falloff = o.number("falloff", 0);
    return pulls;
  };
  return {o.text("name"), kind()};
}

LogJson json_of(const StiffnessField& weight) {
  LogJson json = {{"name", weight.name},
                  {"kind", weight.kind == StiffnessField::Kind::Bending ? "beta" : "alpha"}};
  add_area(json, weight.area);
  if (weight.along) {
    if (const auto* line = std::get_if<std::string>(&*weight.along)) {
      json["along"] = *line;
    } else {
      const Vec2& along = std::get<Vec2>(*weight.along);
      json["along"] = {json_number(along[0]), json_number(along[1])};
    }
  }
  return json;
}

StiffnessField weight_of(const LogObject& parent) {
  const LogObject o =
      parent.object("weight", {"name", "kind", "near", "radius", "paint", "regions", "along"});
  StiffnessField weight;
  weight.name = o.text("name");
  const std::string kind = o.text("kind");
  if (kind != "alpha" && kind != "beta") o.fail("the kind '" + kind + "'", "one of: alpha, beta");
  weight.kind = kind == "beta" ? StiffnessField::Kind::Bending : StiffnessField::Kind::Stretching;
  weight.area = area_of(o);
  if (o.has("along")) {
    if (o.at("along").is_string())
      weight.along = o.text("along");
    else
      weight.along = Vec2(o.numbers("along", 2));
  }
  return weight;
}

LogJson json_of(const Constraint& constraint) {
  LogJson json = {{"name", constraint.name}};
  std::visit(Overloaded{[&](const Constraint::Point& p) {
                          json["type"] = "point";
                          json["at"] = json_vector(p.at);
                          json["goal"] = json_vector(p.goal);
                        },
                        [&](const Constraint::Normal& n) {
                          json["type"] = "normal";
                          json["at"] = json_vector(n.at);
                          json["normal"] = json_vector(n.normal);
                        },
                        [&](const Constraint::Tangent& t) {
                          json["type"] = "tangent";
                          json["at"] = json_vector(t.at);
                          json["along"] = {json_number(t.along[0]), json_number(t.along[1])};
                          json["tau"] = json_vector(t.tau);
                        },
                        [&](const Constraint::LineNormal& l) {
                          json["type"] = "line_normal";
                          json["line"] = l.line;
                          if (l.normal) json["normal"] = json_vector(*l.normal);
                        }},
             constraint.kind);
  return json;
}

Constraint constraint_of(const LogObject& parent) {
  const LogObject o = parent.object("constraint", kConstraintKeys);
  const auto kind = [&]() -> decltype(Constraint::kind) {
    const std::string type = o.text("type");
    if (type == "point") return Constraint::Point{o.vector("at"), o.vector("goal")};
    if (type == "normal") return Constraint::Normal{o.vector("at"), o.vector("normal")};
    if (type == "tangent")
      return Constraint::Tangent{o.vector("at"), Vec2(o.numbers("along", 2)), o.vector("tau")};
    if (type == "line_normal") {
      std::optional<Vec3> normal;
      if (o.has("normal")) normal = o.vector("normal");
      return Constraint::LineNormal{o.text("line"), normal};
    }
    const std::vector<std::string> types = {"point", "normal", "tangent", "line_normal"};
    o.fail("the constraint type '" + type + "'", expected_one_of(type, types));
  };
  return {o.text("name"), kind()};
}

LogJson json_of(const LineOffset& move) {
  LogJson json = {{"name", move.name}, {"line", move.line}, {"fade", json_number(move.fade)}};
  if (move.direction) json["direction"] = json_vector(*move.direction);
  return json;
}

LineOffset move_of(const LogObject& parent) {
  const LogObject o = parent.object("move", {"name", "line", "direction", "fade"});
  LineOffset move{o.text("name"), o.text("line"), {}, o.number("fade", 0)};
  if (o.has("direction")) move.direction = o.vector("direction");
  return move;
}

LogJson json_of(const CharacterLine& line) {
  LogJson json = {{"name", line.name}};
  for (const auto& [role, word] : kRoles)
    if (role == line.role) json["role"] = word;
  for (const auto& [mesh_alignment, word] : kMeshAlignments)
    if (mesh_alignment == line.mesh_alignment) json["treatment"] = word;
  json["curve"] = json_of(nodes_of(line));
  return json;
}

CharacterLine line_of(const LogObject& parent) {
  const LogObject o = parent.object("line", {"name", "role", "treatment", "curve"});
  CharacterLine line;
  line.name = o.text("name");
  const auto choose = [&](const std::string& key, const auto& table, auto& slot) {
    std::vector<std::string> words;
    const std::string found = o.text(key);
    for (const auto& [value, word] : table) {
      words.emplace_back(word);
      if (found == word) return void(slot = value);
    }
    o.fail("the " + key + " '" + found + "'", expected_one_of(found, words));
  };
  choose("role", kRoles, line.role);
  choose("treatment", kMeshAlignments, line.mesh_alignment);
  line.curve = curve_from_hermite(curve_of(o, "curve"));
  return line;
}

LogJson json_of(const std::vector<ScalarParameter::Term>& terms) {
  LogJson list = LogJson::array();
  for (const auto& term : terms)
    list.push_back({{"of", term.of}, {"factor", json_number(term.factor)}});
  return list;
}

LogJson json_of(const ScalarParameter& p) {
  LogJson json = {{"name", p.name}, {"value", json_number(p.value)}};
  if (std::isfinite(p.min)) json["min"] = p.min;
  if (std::isfinite(p.max)) json["max"] = p.max;
  for (const auto& keyframe : p.keyframes)
    json["over_time"].push_back({json_number(keyframe.time), json_number(keyframe.value)});
  if (!p.rule_terms.empty()) json["follows"] = json_of(p.rule_terms);
  if (p.offset != 0) json["offset"] = json_number(p.offset);
  return json;
}

std::vector<ScalarParameter::Term> terms_of(const LogObject& o, const std::string& key) {
  std::vector<ScalarParameter::Term> terms;
  for (const LogObject& term : o.objects(key, {"of", "factor"}))
    terms.push_back({term.text("of"), term.number("factor")});
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
