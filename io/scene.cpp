#include "batten/io/scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "batten/io/scene_lines.h"
#include "batten/io/scene_words.h"

namespace batten {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const std::vector<std::pair<std::string, double>> kUnits = {
    {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};

/// "" when energies with this material have a minimum, else what is expected of it.
std::string expected_of(const SurfaceStiffness& material) {
  const double scale = material.alpha.norm();
  const Vec2 eigenvalues = Eigen::SelfAdjointEigenSolver<Mat2>(material.alpha).eigenvalues();
  if (eigenvalues[0] < -1e-12 * scale)
    return "alpha ≥ 0: alpha_uu ≥ 0, alpha_vv ≥ 0, alpha_uv² ≤ alpha_uu·alpha_vv";
  if (material.beta.minCoeff() < 0) return "beta ≥ 0";
  if (scale == 0 && material.beta.maxCoeff() == 0) return "alpha or beta above 0";
  return "";
}

/// The one list of what can be set: calls f(name, value, min, max) with a reference to each value.
template <class AnyScene, class Function>
void for_each_parameter(AnyScene& scene, const Function& f) {
  for (auto& load : scene.loads) f(load.name, load.value, load.min, load.max);
  for (auto& c : scene.constraints)
    for (int i = 0; i < 3; ++i)
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

std::string range_text(double min, double max) {
  if (min > -kInfinity && max < kInfinity) return "from " + number(min) + " to " + number(max);
  if (min > -kInfinity) return "from " + number(min) + " up";
  return "up to " + number(max);
}

void read_skin(const TomlTable& table, SceneSkin& skin) {
  using Mesher = SkinOptions::Mesher;
  using Hold = SceneSkin::Hold;
  skin.options.element =
      table.choice("element", TriangleElement::HCT,
                   {{"hct", TriangleElement::HCT}, {"z12", TriangleElement::Z12}});
  skin.options.mesher = table.choice("mesher", Mesher::Delaunay,
                                     {{"delaunay", Mesher::Delaunay}, {"fan", Mesher::Fan}});
  using Domain = SkinOptions::Domain;
  skin.options.domain = table.choice("domain", Domain::Auto,
                                     {{"auto", Domain::Auto},
                                      {"polygon", Domain::Polygon},
                                      {"plane", Domain::Plane},
                                      {"ring", Domain::Ring}});
  skin.options.settle = table.boolean("settle", false);
  skin.options.edge_length = table.positive("edge_length", 0);
  if (table.has("refine")) {
    if (skin.options.mesher != Mesher::Fan)
      table.fail("refine", "'refine' with the Delaunay mesher",
                 "it only with mesher = \"fan\" (edge_length says how fine a mesh is)");
    if (table.has("edge_length"))
      table.fail("refine", "both 'refine' and 'edge_length'", "one of them");
    skin.options.fan_refinements = table.whole_number("refine", 0, 0);
    if (skin.options.fan_refinements > 10)
      table.fail("refine", std::to_string(skin.options.fan_refinements), "0 to 10");
  }
  skin.units = table.choice("units", LoadUnits::Relative,
                            {{"relative", LoadUnits::Relative}, {"absolute", LoadUnits::Absolute}});
  skin.hold =
      table.choice("hold", Hold::Lines, {{"lines", Hold::Lines}, {"corners", Hold::Corners}});
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
  const std::string expected = expected_of(skin.material);
  if (!expected.empty()) {
    const std::string key = expected.starts_with("beta") || !table.has("alpha") ? "beta" : "alpha";
    table.fail(key, "a material without a stable shape", expected);
  }
}

SceneConstraint read_constraint(const TomlTable& table) {
  using Type = SceneConstraint::Type;
  SceneConstraint c;
  c.name = table.text("name");
  c.place = table.place("name");
  c.type = table.choice<Type>(
      "type", {{"point", Type::Point}, {"normal", Type::Normal}, {"tangent", Type::Tangent}});
  c.at = table.vector("at");
  const auto only_for = [&](const std::string& key, const std::string& type, bool allowed) {
    if (table.has(key) && !allowed)
      table.fail(key, "'" + key + "' for the constraint '" + c.name + "'",
                 "it only where type = \"" + type + "\"");
  };
  only_for("to", "point", c.type == Type::Point);
  only_for("range", "point", c.type == Type::Point);
  only_for("direction", "normal\" or \"tangent", c.type != Type::Point);
  only_for("along", "tangent", c.type == Type::Tangent);
  c.goal = c.type == Type::Point ? table.vector("to") : table.direction("direction");
  c.middle = c.goal;
  if (table.has("range")) c.range = table.positive("range");
  if (c.type == Type::Tangent) {
    c.along = table.numbers("along", "su, sv");
    if (c.along.norm() == 0) table.fail("along", "[0, 0]", "a direction [su, sv]");
    c.along.normalize();
  }
  return c;
}

SceneLoad read_load(const TomlTable& table, const std::filesystem::path& folder) {
  using Type = SceneLoad::Type;
  SceneLoad load;
  load.name = table.text("name");
  load.type = table.choice<Type>("type", {{"pressure", Type::Pressure},
                                          {"uniform", Type::Uniform},
                                          {"point", Type::Point},
                                          {"springs", Type::Springs}});
  load.value = table.number("value");
  load.min = table.number("min", -kInfinity);
  load.max = table.number("max", kInfinity);
  if (load.min > load.max)
    table.fail("max", number(load.max), "not less than min = " + number(load.min));
  if (load.value < load.min || load.value > load.max)
    table.fail("value", number(load.value),
               "a value " + range_text(load.min, load.max) + ", as 'min' and 'max' say");
  if (load.type == Type::Pressure && table.has("direction"))
    table.fail("direction", "'direction' for the pressure '" + load.name + "'",
               "none: pressure acts along the surface's normal");
  if (load.type == Type::Springs) {
    if (table.has("direction"))
      table.fail("direction", "'direction' for the springs '" + load.name + "'",
                 "none: springs pull towards their points");
    load.file = folder / table.text("file");
    load.place = table.place("file");
    if (table.has("unit")) load.unit = unit_word(table, "unit");
    if (load.value < 0) table.fail("value", number(load.value), "a stiffness not below 0");
    load.min = std::max(load.min, 0.0);
  } else {
    for (const char* key : {"file", "unit"})
      if (table.has(key))
        table.fail(key, "'" + std::string(key) + "' for the load '" + load.name + "'",
                   "it only where type = \"springs\"");
  }
  if (load.type != Type::Point && table.has("at"))
    table.fail("at", "'at' for the load '" + load.name + "'", "it only where type = \"point\"");
  if (load.type == Type::Uniform || load.type == Type::Point)
    load.direction = table.direction("direction");
  if (load.type == Type::Point) load.at = table.vector("at");
  return load;
}

SceneStress read_stress(const TomlTable& table) {
  SceneStress stress;
  stress.thickness = table.positive("thickness");
  stress.young = table.positive("young");
  stress.poisson = table.number("poisson", 0.3);
  if (stress.poisson <= -1 || stress.poisson >= 0.5)
    table.fail("poisson", number(stress.poisson), "a number above -1 and below 0.5");
  stress.density = table.positive("density", 0);
  stress.pressure = table.number("pressure", 0);
  if (table.has("gravity")) {
    stress.gravity = table.vector("gravity");
    if (stress.density == 0) table.fail("gravity", "gravity without 'density'", "both");
  }
  for (const TomlTable& t : table.tables("supports", {"line", "kind"}))
    stress.supports.push_back({{t.text("line"), t.place("line")},
                               t.choice("kind", true, {{"clamped", true}, {"pinned", false}})});
  if (stress.supports.empty())
    table.fail("supports", "no supports", "one or more: supports = [{line = \"…\"}]");
  return stress;
}

const std::vector<std::string> kPictureKeys = {"file",
                                               "title",
                                               "show",
                                               "contours",
                                               "contour_direction",
                                               "zebra",
                                               "zebra_direction",
                                               "parameter_lines",
                                               "lines",
                                               "mesh",
                                               "view",
                                               "size"};

ScenePicture read_picture(const TomlTable& table, Names& files) {
  using Field = PictureScene::Field;
  ScenePicture picture;
  PictureScene& look = picture.look;
  picture.file = output_file(table, "file", files, {".png"});
  look.title = table.text("title", "");
  look.field = table.choice("show", Field::None,
                            {{"shaded", Field::None},
                             {"mean_curvature", Field::Mean},
                             {"gauss_curvature", Field::Gauss}});
  look.contours = table.whole_number("contours", 0, 0);
  look.parameter_lines = table.whole_number("parameter_lines", 0, 0);
  if (table.has("contour_direction")) {
    if (look.contours == 0)
      table.fail("contour_direction", "'contour_direction' without 'contours'", "both");
    look.contour_direction = table.direction("contour_direction");
  }
  look.zebra = table.whole_number("zebra", 1, 0);
  if (look.zebra > 0 && look.field != Field::None)
    table.fail("zebra", "'zebra' beside show = \"" + table.text("show") + "\"", "one of them");
  if (table.has("zebra_direction")) {
    if (look.zebra == 0) table.fail("zebra_direction", "'zebra_direction' without 'zebra'", "both");
    look.zebra_direction = table.direction("zebra_direction");
  }
  look.lines = table.boolean("lines", true);
  look.mesh = table.boolean("mesh", false);
  read_view(table, look.azimuth, look.elevation, picture.size);
  return picture;
}

SceneSweep read_sweep(const TomlTable& table, const Scene& scene, Names& files) {
  SceneSweep sweep;
  sweep.parameter = table.text("parameter");
  sweep.values = table.list("values");
  sweep.columns = table.whole_number("columns", 1, 0);
  sweep.picture = read_picture(table, files);
  // The panels of a sheet share their lines.
  for_each_fair_parameter(scene.fairing, [&](const std::string& name, double) {
    if (name == sweep.parameter)
      table.fail("parameter", "'" + name + "', which changes the lines",
                 "a parameter of loads, constraints or [skin]");
  });
  double present = 0;
  for (const Parameter& p : scene.parameters())
    if (p.name == sweep.parameter) present = p.value;
  Scene(scene).set(sweep.parameter, present, table.at("parameter"));  // is there such a one?
  for (const double value : sweep.values)
    Scene(scene).set(sweep.parameter, value, table.at("values"));
  return sweep;
}

Scene read(const toml::table& root_table, const std::filesystem::path& file) {
  const TomlTable root(
      file.string(), root_table, "the scene",
      {"name", "unit", "tolerance", "corner_angle", "line", "lines", "fair", "skin", "constraint",
       "load", "stress", "output", "compare", "picture", "sweep"});
  const std::filesystem::path folder = file.parent_path();
  Scene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = unit_word(root, "unit");
  scene.skin.options.tolerance = root.positive("tolerance", 0);
  scene.skin.options.corner_angle = root.positive("corner_angle", 20);
  if (scene.skin.options.corner_angle >= 180)
    root.fail("corner_angle", number(scene.skin.options.corner_angle), "less than 180 degrees");

  scene.lines = read_scene_lines(root, folder, true);
  scene.fairing = read_fair_stages(root);

  for (const TomlTable& t :
       root.table("skin", {"element", "domain", "settle", "mesher", "edge_length", "refine",
                           "alpha", "beta", "units", "hold"}))
    read_skin(t, scene.skin);

  Names names("name");
  for (const TomlTable& t :
       root.tables("constraint", {"name", "type", "at", "to", "range", "direction", "along"})) {
    scene.constraints.push_back(read_constraint(t));
    names.add(t, "name", scene.constraints.back().name);
  }
  for (const TomlTable& t : root.tables(
           "load", {"name", "type", "value", "min", "max", "direction", "at", "file", "unit"})) {
    scene.loads.push_back(read_load(t, folder));
    names.add(t, "name", scene.loads.back().name);
    for (const char* taken :
         {"alpha", "alpha_uu", "alpha_uv", "alpha_vv", "beta", "beta_uu", "beta_uv", "beta_vv"})
      if (scene.loads.back().name == taken)
        t.fail("name", "the load name '" + std::string(taken) + "'",
               "another one: that is a parameter of [skin]");
  }

  for (const TomlTable& t : root.table("stress", {"thickness", "young", "poisson", "density",
                                                  "pressure", "gravity", "supports"}))
    scene.stress = read_stress(t);

  Names files("file name");
  for (const TomlTable& t : root.table("compare", {"file"}))
    scene.compare = folder / t.text("file");
  for (const TomlTable& t :
       root.table("output", {"step", "step_form", "step_tolerance", "vtu", "vtp", "calculix"})) {
    if (t.has("step")) scene.step = output_file(t, "step", files, {".step", ".stp"});
    using Form = Scene::StepForm;
    scene.step_form =
        t.choice("step_form", Form::Auto,
                 {{"auto", Form::Auto}, {"face", Form::Face}, {"exact", Form::Exact}});
    scene.step_tolerance = t.positive("step_tolerance", 0);
    for (const char* key : {"step_form", "step_tolerance"})
      if (t.has(key) && scene.step.empty())
        t.fail(key, "'" + std::string(key) + "' without 'step'", "both");
    if (t.has("vtu")) scene.vtu = output_file(t, "vtu", files, {".vtu"});
    if (t.has("vtp")) scene.vtp = output_file(t, "vtp", files, {".vtp"});
    if (t.has("calculix")) scene.calculix = output_file(t, "calculix", files, {".inp"});
    if (t.has("calculix") && !scene.stress)
      t.fail("calculix", "a CalculiX deck", "a section [stress] with material and supports for it");
  }
  for (const TomlTable& t : root.tables("picture", kPictureKeys))
    scene.pictures.push_back(read_picture(t, files));
  std::vector<std::string> sweep_keys = {"parameter", "values", "columns"};
  sweep_keys.insert(sweep_keys.end(), kPictureKeys.begin(), kPictureKeys.end());
  for (const TomlTable& t : root.tables("sweep", sweep_keys))
    scene.sweeps.push_back(read_sweep(t, scene, files));
  return scene;
}

}  // namespace

Load SceneLoad::load(std::vector<Vec3> points) const {
  if (type == Type::Springs) return {name, SpringLoad{std::move(points), value}};
  if (type == Type::Pressure) return {name, PressureLoad{value}};
  if (type == Type::Uniform) return {name, UniformLoad{value * direction}};
  return {name, PointLoad{at, value * direction}};
}

std::vector<Parameter> Scene::parameters() const {
  std::vector<Parameter> list;
  for_each_parameter(*this, [&](const std::string& n, double value, double min, double max) {
    list.push_back({n, value, min, max});
  });
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
      throw InputError(where + "found " + number(value) + " for '" + n + "', expected a number " +
                       (min == -kInfinity && max == kInfinity ? "" : range_text(min, max)));
    slot = value;
  });
  if (!known)
    throw InputError(where + "found parameter '" + parameter +
                     "', expected one of: " + listed(names) + did_you_mean(parameter, names));
  SurfaceStiffness& material = changed.skin.material;
  if (parameter == "alpha") material.alpha = value * Mat2::Identity();
  if (parameter == "beta") material.beta = Vec3::Constant(value);
  if (parameter == "alpha_uv") material.alpha(1, 0) = value;
  const std::string expected = expected_of(material);
  if (!expected.empty())
    throw InputError(where + "found " + number(value) + " for '" + parameter + "', expected " +
                     expected);
  for_each_fair_parameter(changed.fairing, [&](const std::string& name, double number_above_0) {
    if (!(number_above_0 > 0))
      throw InputError(where + "found 0 for '" + name + "', expected a number above 0");
  });
  for (const auto& c : changed.constraints)
    if (c.type != SceneConstraint::Type::Point && c.goal.norm() == 0)
      throw InputError(where + "found 0 for '" + parameter + "', expected a direction of '" +
                       c.name + "' that is not [0, 0, 0]");
  *this = std::move(changed);
}

Scene parse_scene(const std::string& text, const std::filesystem::path& file) {
  return read(parse_toml(text, file, "a scene (unit, [[line]] …)"), file);
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(text_of_file(file, "a scene (.toml)"), file);
}

const std::vector<std::string>& length_units() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> list;
    for (const auto& unit : kUnits) list.push_back(unit.first);
    return list;
  }();
  return words;
}

double unit_in_metres(const std::string& unit) {
  for (const auto& [word, metres] : kUnits)
    if (word == unit) return metres;
  throw InputError("found the unit '" + unit + "', expected one of: " + listed(length_units()) +
                   did_you_mean(unit, length_units()));
}

}  // namespace batten
