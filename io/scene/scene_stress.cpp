// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene_stress.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/io/files/text.h"

namespace batten {

namespace {

std::string format_box(const Box3& box) {
  std::string text;
  for (const Vec3& corner : {Vec3(box.min()), Vec3(box.max())}) {
    text += text.empty() ? "[" : " to [";
    for (int c = 0; c < 3; ++c) text += (c ? ", " : "") + format_number(corner[c]);
    text += "]";
  }
  return text;
}

}  // namespace

std::string SceneStress::Support::description() const {
  const std::string what = kind == Kind::Clamped     ? "clamped "
                           : kind == Kind::Pinned    ? "pinned "
                           : kind == Kind::Symmetric ? "symmetric "
                           : kind == Kind::Elastic   ? "elastic "
                                                     : "prescribed ";
  if (!point) {
    const std::string where = line.text.empty() ? region.text : line.text;
    if (!box) return what + (where.empty() ? "all" : where);
    return what + (where.empty() ? "box " : where + " in the box ") + format_box(*box);
  }
  std::string at;
  for (int c = 0; c < 3; ++c) at += (c ? ", " : "[") + format_number((*point)[c]);
  return what + "point " + at + "]";
}

std::vector<std::string> SceneStress::cases() const {
  std::vector<std::string> names;
  for (const Load& load : loads)
    if (std::find(names.begin(), names.end(), load.load_case) == names.end())
      names.push_back(load.load_case);
  return names;
}

bool SceneStress::has_density() const {
  return material.density > 0 || std::any_of(plies.begin(), plies.end(), [](const ScenePly& ply) {
           return ply.material.density > 0;
         });
}

bool SceneStress::has_expansion() const {
  const auto expands = [](const SceneMaterial& m) {
    return m.expansion[0] != 0 || m.expansion[1] != 0;
  };
  return expands(material) || std::any_of(plies.begin(), plies.end(), [&](const ScenePly& ply) {
           return expands(ply.material);
         });
}

const std::vector<std::string>& stress_keys() {
  static const std::vector<std::string> keys = {"thickness",      "thicknesses",
                                                "material",       "young",
                                                "poisson",        "density",
                                                "yield",          "pressure",
                                                "pressures",      "gravity",
                                                "supports",       "hinges",
                                                "loads",          "combinations",
                                                "modes",          "buckling",
                                                "shear_modulus",  "material_direction",
                                                "sensitivities",  "follower_pressure",
                                                "inertia_relief", "expansion",
                                                "strength",       "plies",
                                                "layup",          "ply_thickness",
                                                "materials",      "reference_surface",
                                                "stiffeners",     "masses",
                                                "results",        "rigid_curves",
                                                "harmonic",       "spectrum"};
  return keys;
}

namespace {

const std::string kDefaultLoadCase = "loads";

/// The materials of plies for reports: "5 plies of carbon, core".
std::string ply_names(const std::vector<ScenePly>& plies) {
  std::vector<std::string> names;
  for (const ScenePly& ply : plies)
    if (!ply.material.name.empty() &&
        std::find(names.begin(), names.end(), ply.material.name) == names.end())
      names.push_back(ply.material.name);
  return format_count(isize(plies), "ply", "plies") +
         (names.empty() ? "" : " of " + comma_separated(names));
}

/// Material, plies and reference surface.
void read_section(const TomlTable& table, const std::string& unit, SceneStress& stress) {
  stress.plies = read_plies(table, unit);
  if (stress.plies.empty()) {
    if (table.has("materials"))
      table.fail("materials", "'materials' without 'plies'", "both, or the keys of one material");
    stress.material = read_material(table, unit);
    stress.thickness = table.positive("thickness");
  } else {
    for (const char* key : {"thickness", "thicknesses"})
      if (table.has(key))
        table.fail(key, "'" + std::string(key) + "' beside plies",
                   "none: the thicknesses of the plies are added");
    for (const ScenePly& ply : stress.plies) stress.thickness += ply.thickness;
    stress.material.name = ply_names(stress.plies);
  }
  bool has_direction = stress.material.is_orthotropic();
  for (const ScenePly& ply : stress.plies)
    has_direction = has_direction || ply.material.is_orthotropic() || ply.angle != 0;
  if (has_direction)
    stress.along = table.direction("material_direction");
  else if (table.has("material_direction"))
    table.fail("material_direction", "'material_direction' of an isotropic material",
               "young = [along, across] with it");
  stress.offset =
      table.choice("reference_surface", 0.0, {{"middle", 0.0}, {"bottom", 0.5}, {"top", -0.5}});
}

// Reads box = [[x, y, z], [x, y, z]]: two opposite corners, in any order.
std::optional<Box3> read_box(const TomlTable& t) {
  if (!t.has("box")) return {};
  const std::vector<Vec3> corners = t.points("box");
  const Box3 box = bounding_box(corners);
  if (corners.size() != 2 || !(box.sizes().minCoeff() > 0))
    t.fail("box", corners.size() == 2 ? "a flat box" : std::to_string(corners.size()) + " corners",
           "two opposite corners that differ in x, y and z");
  return box;
}

// Reads {foundation = k, face = "…"}, or {spring = [kx, ky, kz]} with a curve, a point, or a
// face.
void read_elastic(const TomlTable& t, SceneStress::Support& support) {
  support.kind = SceneStress::Support::Kind::Elastic;
  for (const char* key : {"type", "directions", "normal", "rotation", "displacement"})
    if (t.has(key))
      t.fail(key, "'" + std::string(key) + "' with 'spring' or 'foundation'", "one of them");
  if (t.has("foundation") == t.has("spring"))
    t.fail("spring", "both 'foundation' and 'spring'", "one of them");
  if (t.has("foundation")) {
    if (t.has("curve") || t.has("point"))
      t.fail("foundation", "'foundation' with a curve or a point",
             "a face, or neither for the whole surface");
    support.foundation = t.positive("foundation");
  } else {
    support.springs = t.vector("spring");
    if (support.springs.minCoeff() < 0 || support.springs.isZero(0))
      t.fail("spring", "a negative stiffness, or three zeros",
             "three numbers, 0 or more, at least one above 0");
  }
}

void read_place(const TomlTable& t, SceneStress::Support& support) {
  if (t.has("curve") + t.has("point") + t.has("face") > 1 || (t.has("point") && t.has("box")))
    t.fail(t.has("point") ? "point" : "curve", "more than one location",
           "one of curve, point and face; a box with a curve or a face, or alone");
  if (t.has("curve")) support.line = {t.text("curve"), t.location("curve")};
  if (t.has("point")) support.point = t.vector("point");
  if (t.has("face")) support.region = {t.text("face"), t.location("face")};
  support.box = read_box(t);
}

std::vector<Vec3> cylindrical_directions(const TomlTable& t) {
  const std::vector<std::string> names = {"radial", "hoop", "axial"};
  std::vector<Vec3> directions;
  for (const LocatedString& name : t.strings("directions")) {
    const auto known = std::find(names.begin(), names.end(), name.text);
    if (known == names.end())
      t.fail("directions", "'" + name.text + "'", expected_one_of(name.text, names));
    directions.emplace_back(Vec3::Unit(known - names.begin()));
  }
  return directions;
}

SceneStress::Support read_support(const TomlTable& t) {
  using Kind = SceneStress::Support::Kind;
  SceneStress::Support support;
  support.location = t.location();
  read_place(t, support);
  if (t.has("foundation") || t.has("spring")) {
    read_elastic(t, support);
    return support;
  }
  if (!t.has("curve") && !t.has("point") && !t.has("face") && !t.has("box"))
    t.fail("curve", "a support without a location",
           "one of curve = \"…\", point = [x, y, z], face = \"…\", box = [[x, y, z], [x, y, z]]");
  const bool directions = t.has("directions");
  support.kind = t.choice("type",
                          directions      ? Kind::Prescribed
                          : support.point ? Kind::Pinned
                                          : Kind::Clamped,
                          {{"clamped", Kind::Clamped},
                           {"pinned", Kind::Pinned},
                           {"symmetric", Kind::Symmetric},
                           {"prescribed", Kind::Prescribed}});
  if ((support.point && support.kind == Kind::Clamped) ||
      (support.line.text.empty() && support.kind == Kind::Symmetric))
    t.fail("type", "\"" + t.text("type") + "\" without a curve", "\"pinned\" or \"prescribed\"");
  if (directions != (support.kind == Kind::Prescribed))
    t.fail("directions",
           directions ? "'directions' with another type of support"
                      : "a prescribed support without 'directions'",
           "type = \"prescribed\" and directions = [[x, y, z], …]");
  if (t.has("normal") != (support.kind == Kind::Symmetric))
    t.fail("normal",
           t.has("normal") ? "'normal' with another type of support"
                           : "a symmetry support without 'normal'",
           "type = \"symmetric\" and normal = [x, y, z]");
  if (t.has("origin") && !t.has("axis")) t.fail("origin", "'origin' without 'axis'", "both");
  if (t.has("axis")) {
    if (support.kind != Kind::Prescribed)
      t.fail("axis", "'axis' without directions",
             "directions = [\"radial\", \"hoop\", \"axial\"], or some of them");
    support.axis = t.direction("axis");
    if (t.has("origin")) support.origin = t.vector("origin");
    support.directions = cylindrical_directions(t);
  } else if (directions) {
    support.directions = t.points("directions");
  }
  if (t.has("normal")) support.directions = {t.direction("normal")};
  for (const Vec3& d : support.directions)
    if (d.isZero(0)) t.fail("directions", "a direction of length zero", "a nonzero vector");
  support.rotation =
      t.boolean("rotation", support.kind == Kind::Clamped || support.kind == Kind::Symmetric);
  if (t.has("rotation") && support.line.text.empty())
    t.fail("rotation", "'rotation' without a curve",
           "'rotation' only with 'curve': a point has no edge direction, and a fixed area cannot "
           "rotate");
  if (t.has("displacement")) support.displacement = t.vector("displacement");
  return support;
}

Formula formula(const TomlTable& t, const std::string& key, const std::string& text,
                const NamedFields& fields) {
  try {
    return Formula(text, fields);
  } catch (const InputError& e) {
    throw InputError(t.at(key) + e.what());
  }
}

/// A number or a formula, if the key is there.
std::optional<Formula> optional_formula(const TomlTable& t, const std::string& key,
                                        const NamedFields& fields) {
  if (!t.has(key)) return {};
  return formula(t, key, t.is_text(key) ? t.text(key) : exact_number(t.number(key)), fields);
}

/// A pressure that is a number or a formula.
void read_pressure(const TomlTable& t, const NamedFields& fields, SceneStress::Load& load) {
  if (t.is_text("pressure"))
    load.formulas = {formula(t, "pressure", t.text("pressure"), fields)};
  else
    load.value = t.number("pressure");
}

SceneStress::Load read_load(const TomlTable& t, const NamedFields& fields) {
  using Type = SceneStress::Load::Type;
  SceneStress::Load load;
  load.location = t.location();
  load.load_case = t.text("case", kDefaultLoadCase);
  const std::vector<std::string> kinds = {
      "pressure",         "force",       "moment",
      "gravity",          "hydrostatic", "traction",
      "edge_force",       "total_force", "total_moment",
      "angular_velocity", "temperature", "temperature_difference"};
  std::vector<std::string> stated;
  for (const std::string& kind : kinds)
    if (t.has(kind) && !(kind == "total_moment" && t.has("total_force")) &&
        !(kind == "temperature_difference" && t.has("temperature")))
      stated.push_back(kind);
  if (stated.size() != 1)
    t.fail(stated.empty() ? "case" : stated[1],
           stated.empty() ? "a load without a value" : "two types of load in one entry",
           "one of: " + comma_separated(kinds));
  const std::string& kind = stated[0];
  const auto needs = [&](const char* key, bool needed, const std::string& what) {
    if (t.has(key) != needed)
      t.fail(t.has(key) ? key : kind,
             t.has(key) ? "'" + std::string(key) + "' beside '" + kind + "'"
                        : "'" + kind + "' without a location",
             what);
  };
  const bool total = kind == "total_force" || kind == "total_moment",
             spin = kind == "angular_velocity",
             thermal = kind == "temperature" || kind == "temperature_difference";
  const bool at_line = kind == "moment" || kind == "edge_force" ||
                       (kind == "force" && !t.has("point")) || (total && t.has("curve"));
  const bool at_point = kind == "force" && t.has("point");
  needs("curve", at_line,
        kind == "moment"       ? "moment = M, curve = \"…\""
        : kind == "edge_force" ? "edge_force = F, curve = \"…\""
        : kind == "force"      ? "force = [x, y, z] with point = [x, y, z], or with curve = \"…\""
                               : "no curve");
  needs("point", at_point, "force = [x, y, z], point = [x, y, z]");
  needs("level", kind == "hydrostatic", "hydrostatic = WEIGHT, level = Z");
  needs("axis", spin, "angular_velocity = OMEGA, axis = [x, y, z]");
  if (t.has("origin") && !spin) t.fail("origin", "'origin' beside '" + kind + "'", "no origin");
  if (t.has("face") && (at_line || at_point || kind == "gravity" || spin))
    t.fail("face", "'face' beside '" + (at_line ? "curve" : kind) + "'", "no face");
  if (t.has("box") && (at_point || kind == "gravity" || spin || thermal))
    t.fail("box", "'box' beside '" + kind + "'", "no box");
  load.box = read_box(t);
  if (t.has("face")) load.region = {t.text("face"), t.location("face")};
  if (at_line) load.line = {t.text("curve"), t.location("curve")};
  if (at_point) load.point = t.vector("point");
  if (thermal) {
    load.type = Type::Temperature;
    load.temperature = optional_formula(t, "temperature", fields);
    load.temperature_difference = optional_formula(t, "temperature_difference", fields);
  } else if (total) {
    load.type = Type::Total;
    if (t.has("total_force")) load.vector = t.vector("total_force");
    if (t.has("total_moment")) load.moment = t.vector("total_moment");
  } else if (spin) {
    load.type = Type::Spin;
    load.value = t.number(kind);
    load.axis = t.direction("axis").normalized();
    if (t.has("origin")) load.origin = t.vector("origin");
  } else if (kind == "pressure" || kind == "moment" || kind == "hydrostatic" ||
             kind == "edge_force") {
    load.type = kind == "pressure"     ? Type::Pressure
                : kind == "moment"     ? Type::LineMoment
                : kind == "edge_force" ? Type::EdgeForce
                                       : Type::Hydrostatic;
    if (kind != "hydrostatic" && t.is_text(kind))
      load.formulas = {formula(t, kind, t.text(kind), fields)};
    else
      load.value = t.number(kind);
    load.level = t.number("level", 0);
  } else {
    load.type = kind == "gravity"    ? Type::Gravity
                : kind == "traction" ? Type::AreaForce
                : at_point           ? Type::Point
                                     : Type::LineForce;
    const bool varies = kind == "traction" || (kind == "force" && !at_point);
    const auto texts = varies ? t.mixed_texts(kind, "x, y, z") : std::vector<std::string>();
    for (const std::string& text : texts) load.formulas.push_back(formula(t, kind, text, fields));
    if (texts.empty()) load.vector = t.vector(kind);
  }
  return load;
}

struct StiffenerShape {
  const char *key, *dimensions;
  SceneStress::Stiffener::Shape shape;
};
constexpr StiffenerShape kStiffenerShapes[] = {
    {"rectangle", "width, height", SceneStress::Stiffener::Shape::Rectangle},
    {"circle", "radius", SceneStress::Stiffener::Shape::Circle},
    {"tube", "radius, wall", SceneStress::Stiffener::Shape::Tube},
    {"tee", "height of the web, thickness of the web, width of the flange, thickness of the flange",
     SceneStress::Stiffener::Shape::Tee}};

/// Shape and dimensions from the keys `rectangle`, `circle`, `tube`, `tee` and `section`.
void read_stiffener_section(const TomlTable& t, SceneStress::Stiffener& stiffener) {
  int found = t.has("section") ? 1 : 0;
  for (const StiffenerShape& of : kStiffenerShapes) {
    if (!t.has(of.key)) continue;
    ++found;
    stiffener.shape = of.shape;
    if (of.shape == SceneStress::Stiffener::Shape::Circle) {
      stiffener.dimensions = {t.positive(of.key)};
      continue;
    }
    const VecX numbers = t.numbers(of.key, of.dimensions);
    stiffener.dimensions.assign(numbers.begin(), numbers.end());
    if (!(numbers.minCoeff() > 0))
      t.fail(of.key, "a dimension that is not above 0", std::string("[") + of.dimensions + "]");
  }
  if (found != 1)
    t.fail(
        "curve", found == 0 ? "a stiffener without a section" : "several sections of a stiffener",
        "one of rectangle = [width, height], circle = radius, tube = [radius, wall], tee = [height "
        "and thickness of the web, width and thickness of the flange], section = {area = …, …}");
  if (!t.has("section")) {
    stiffener.side = t.choice("side", 1.0, {{"top", 1.0}, {"bottom", -1.0}, {"middle", 0.0}});
    return;
  }
  if (t.has("side")) t.fail("side", "'side' beside 'section'", "the eccentricity in the section");
  const TomlTable s =
      t.table("section", {"area", "inertia", "lateral_inertia", "torsion", "eccentricity"}).at(0);
  stiffener.shape = SceneStress::Stiffener::Shape::Numbers;
  stiffener.dimensions = {s.positive("area"), s.positive("inertia", 0),
                          s.positive("lateral_inertia", 0), s.positive("torsion", 0),
                          s.number("eccentricity", 0)};
}

void read_stiffeners(const TomlTable& table, const std::string& unit, SceneStress& stress) {
  for (const TomlTable& t : table.tables(
           "stiffeners", {"curve", "name", "rectangle", "circle", "tube", "tee", "section", "side",
                          "material", "young", "poisson", "density", "expansion"})) {
    SceneStress::Stiffener stiffener;
    stiffener.line = {t.text("curve"), t.location("curve")};
    stiffener.name = t.text("name", stiffener.line.text);
    read_stiffener_section(t, stiffener);
    if (t.has("material") || t.has("young"))
      stiffener.material = read_material(t, unit);
    else if (stress.plies.empty() && !stress.material.is_orthotropic())
      stiffener.material = stress.material;
    else
      t.fail("curve", "a stiffener without a material", "material = \"…\", or young = …");
    if (stiffener.material.is_orthotropic()) t.fail("young", "two moduli of a stiffener", "one");
    stress.stiffeners.push_back(std::move(stiffener));
  }
}

void read_harmonic(const TomlTable& table, SceneStress& stress) {
  for (const TomlTable& t : table.table("harmonic", {"from", "to", "steps", "damping"})) {
    SceneStress::Harmonic harmonic;
    harmonic.from = t.number("from", 0);
    harmonic.to = t.positive("to");
    if (!(harmonic.from >= 0 && harmonic.from < harmonic.to))
      t.fail("from", format_number(harmonic.from), "a frequency of 0 or more, below 'to'");
    harmonic.damping = t.positive("damping");
    if (harmonic.damping >= 1)
      t.fail("damping", format_number(harmonic.damping),
             "a damping ratio below 1: 0.02 is 2 % of the critical damping");
    constexpr int usual = 200;
    harmonic.steps = t.integer("steps", 1, usual);
    if (!stress.has_density()) table.fail("harmonic", "harmonic without 'density'", "both");
    stress.harmonic = harmonic;
  }
}

void read_spectrum(const TomlTable& table, SceneStress& stress) {
  for (const TomlTable& t : table.table("spectrum", {"direction", "points", "damping"})) {
    SceneStress::Spectrum spectrum;
    spectrum.direction = t.direction("direction");
    for (const VecX& row : t.rows("points", "frequency, acceleration")) {
      const bool ascends = spectrum.points.empty() || row[0] > spectrum.points.back().first;
      if (!(row[0] > 0 && row[1] > 0 && ascends))
        t.fail("points", "[" + format_number(row[0]) + ", " + format_number(row[1]) + "]",
               "ascending frequencies and accelerations, all above 0");
      spectrum.points.emplace_back(row[0], row[1]);
    }
    spectrum.damping = t.positive("damping");
    if (spectrum.damping >= 1)
      t.fail("damping", format_number(spectrum.damping),
             "a damping ratio below 1: 0.05 is 5 % of the critical damping");
    if (!stress.has_density()) table.fail("spectrum", "spectrum without 'density'", "both");
    stress.spectrum = spectrum;
  }
}

void read_results(const TomlTable& table, SceneStress& stress) {
  for (const TomlTable& t :
       table.tables("results", {"name", "point", "curve", "face", "axis", "origin"})) {
    if (t.has("point") + t.has("curve") + t.has("face") != 1)
      t.fail("name", "a result without a location, or with several",
             "one of point, curve and face");
    SceneStress::Result result;
    result.location = t.location();
    if (t.has("point")) result.point = t.vector("point");
    if (t.has("curve")) result.line = {t.text("curve"), t.location("curve")};
    if (t.has("face")) result.region = {t.text("face"), t.location("face")};
    if (t.has("axis")) result.axis = t.direction("axis").normalized();
    if (t.has("origin")) result.origin = t.vector("origin");
    if (t.has("origin") && !result.axis) t.fail("origin", "'origin' without 'axis'", "both");
    if (result.axis && !result.region.text.empty())
      t.fail("axis", "an axis for a face", "one for a point or a curve");
    const std::string usual = result.point ? "point " + std::to_string(stress.results.size() + 1)
                                           : result.line.text + result.region.text;
    result.name = t.text("name", usual);
    for (const SceneStress::Result& other : stress.results)
      if (other.name == result.name)
        t.fail("name", "a second result '" + result.name + "'", "another name");
    stress.results.push_back(std::move(result));
  }
}

SceneStress::Thickness read_thickness(const TomlTable& t) {
  SceneStress::Thickness thickness;
  thickness.thickness = t.positive("thickness");
  if (t.has("face")) {
    thickness.region = {t.text("face"), t.location("face")};
    for (const char* key : {"near", "paint", "faces"})
      if (t.has(key)) t.fail(key, "'" + std::string(key) + "' beside 'face'", "one of the two");
  } else if (!t.has("near") && !t.has("paint")) {
    t.fail("thickness", "a thickness without a location",
           "one of: face = \"…\"; near = \"…\", radius = R; paint = [{at = […], radius = R}]");
  }
  thickness.area = read_area(t);
  return thickness;
}

// Reads the short forms `pressure`, `pressures` and `gravity`: loads of the default load case.
void read_short_loads(const TomlTable& table, const NamedFields& fields, SceneStress& stress) {
  using Load = SceneStress::Load;
  const auto add = [&](Load::Type type, const SourceLocation& location) -> Load& {
    stress.loads.emplace_back();
    stress.loads.back().type = type;
    stress.loads.back().load_case = kDefaultLoadCase;
    stress.loads.back().location = location;
    return stress.loads.back();
  };
  if (table.has("pressure"))
    read_pressure(table, fields, add(Load::Type::Pressure, table.location("pressure")));
  for (const TomlTable& t : table.tables("pressures", {"face", "pressure"})) {
    Load& load = add(Load::Type::Pressure, t.location());
    load.region = {t.text("face"), t.location("face")};
    read_pressure(t, fields, load);
  }
  if (table.has("gravity"))
    add(Load::Type::Gravity, table.location("gravity")).vector = table.vector("gravity");
}

void read_combinations(const TomlTable& table, SceneStress& stress) {
  std::vector<std::string> names = stress.cases();
  for (const TomlTable& t : table.tables("combinations", {"name", "cases", "factors"})) {
    SceneStress::Combination sum;
    sum.name = t.text("name");
    if (std::find(names.begin(), names.end(), sum.name) != names.end())
      t.fail("name", "the name '" + sum.name + "' again", "each case and combination once");
    const std::vector<LocatedString> cases = t.strings("cases");
    const std::vector<double> factors = t.list("factors");
    if (cases.empty() || cases.size() != factors.size())
      t.fail("factors", std::to_string(factors.size()) + " factors",
             "one for each of the " + std::to_string(cases.size()) + " cases");
    const std::vector<std::string> known = stress.cases();
    for (size_t i = 0; i < cases.size(); ++i) {
      if (std::find(known.begin(), known.end(), cases[i].text) == known.end())
        t.fail("cases", "the case '" + cases[i].text + "'", expected_one_of(cases[i].text, known));
      sum.parts.emplace_back(cases[i], factors[i]);
    }
    names.push_back(sum.name);
    stress.combinations.push_back(std::move(sum));
  }
}

}  // namespace

// A shell without supports is free: it has natural modes, and responds to loads by inertia relief.
void require_supports(const TomlTable& table, const SceneStress& stress) {
  if (stress.inertia_relief && !stress.supports.empty())
    table.fail("inertia_relief", "supports and inertia_relief", "one of them");
  if (stress.inertia_relief && !stress.has_density())
    table.fail("inertia_relief", "inertia_relief without 'density'", "both");
  if (stress.spectrum && stress.supports.empty())
    table.fail("spectrum", "spectrum without supports", "supports");
  if (stress.harmonic && stress.supports.empty())
    table.fail("harmonic", "harmonic without supports", "supports");
  if (stress.inertia_relief && stress.sensitivities)
    table.fail("inertia_relief", "sensitivities and inertia_relief", "one of them");
  if (!stress.supports.empty() || stress.inertia_relief) return;
  if (stress.modes > 0 && stress.loads.empty()) return;
  table.fail(
      "supports", "no supports",
      "one or more: supports = [{curve = \"…\"}], or inertia_relief = true for a free shell, "
      "or only modes, without loads");
}

SceneStress read_stress(const TomlTable& table, const std::string& unit,
                        const NamedFields& fields) {
  SceneStress stress;
  stress.fields = fields;
  read_section(table, unit, stress);
  stress.yield = table.positive("yield", 0);
  for (const TomlTable& t :
       table.tables("thicknesses", {"face", "thickness", "near", "radius", "paint", "faces"}))
    stress.thicknesses.push_back(read_thickness(t));
  read_short_loads(table, fields, stress);
  for (const TomlTable& t : table.tables("loads", {"case",
                                                   "pressure",
                                                   "force",
                                                   "moment",
                                                   "gravity",
                                                   "hydrostatic",
                                                   "traction",
                                                   "edge_force",
                                                   "total_force",
                                                   "total_moment",
                                                   "angular_velocity",
                                                   "temperature",
                                                   "temperature_difference",
                                                   "axis",
                                                   "origin",
                                                   "face",
                                                   "curve",
                                                   "point",
                                                   "level",
                                                   "box"}))
    stress.loads.push_back(read_load(t, fields));
  for (const SceneStress::Load& load : stress.loads) {
    using Type = SceneStress::Load::Type;
    if (load.type == Type::Temperature && !stress.has_expansion())
      table.fail("loads", "a temperature of a material without 'expansion'", "both");
    if (load.type == Type::Spin && !stress.has_density())
      table.fail("loads", "angular_velocity without 'density'", "both");
    if (load.type == Type::Gravity && !stress.has_density())
      table.fail(table.has("gravity") ? "gravity" : "loads", "gravity without 'density'", "both");
  }
  read_combinations(table, stress);
  for (const auto& item : table.tables_or_names(
           "supports", {"curve", "point", "type", "directions", "normal", "rotation",
                        "displacement", "foundation", "spring", "face", "box", "axis", "origin"})) {
    if (item.table) {
      stress.supports.push_back(read_support(*item.table));
      continue;
    }
    SceneStress::Support& clamped = stress.supports.emplace_back();
    clamped.line = item.name;
    clamped.location = item.name.location;
    clamped.rotation = true;
  }
  stress.hinges = table.names("hinges");
  stress.rigid_curves = table.names("rigid_curves");
  read_stiffeners(table, unit, stress);
  for (const TomlTable& t : table.tables("masses", {"point", "mass"}))
    stress.masses.push_back({t.vector("point"), t.positive("mass"), t.location()});
  read_results(table, stress);
  read_harmonic(table, stress);
  read_spectrum(table, stress);
  stress.modes = table.integer("modes", 1, 0);
  stress.inertia_relief = table.boolean("inertia_relief", false);
  if (stress.modes > 0 && !stress.has_density())
    table.fail("modes", "modes without 'density'", "both");
  stress.sensitivities = table.boolean("sensitivities", false);
  require_supports(table, stress);
  stress.buckling = table.integer("buckling", 1, 0);
  stress.follower_pressure = table.boolean("follower_pressure", true);
  return stress;
}

SceneArea read_area(const TomlTable& table) {
  SceneArea area;
  if (table.has("near") && table.has("paint"))
    table.fail("paint", "both 'near' and 'paint'", "one of them");
  if (table.has("near")) {
    area.line = {table.text("near"), table.location("near")};
    area.area.where = Area::NearLine{area.line.text, table.positive("radius")};
  } else if (table.has("radius")) {
    table.fail("radius", "'radius' without 'near'", "both, or 'paint'");
  }
  if (table.has("paint")) {
    Area::Painted painted;
    for (const TomlTable& t : table.tables("paint", {"at", "radius", "strength"}))
      painted.strokes.push_back({t.vector("at"), t.positive("radius"), t.number("strength", 1)});
    if (painted.strokes.empty())
      table.fail("paint", "no strokes", "one or more: paint = [{at = […], radius = …}]");
    area.area.where = painted;
  }
  if (table.has("faces")) {
    area.regions = table.strings("faces");
    if (area.regions.empty())
      table.fail("faces", "no faces", "names: faces = [\"a\", \"b\"]; without the key, all faces");
  }
  return area;
}

}  // namespace batten
