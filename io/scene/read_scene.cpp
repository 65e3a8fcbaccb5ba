#include "batten/io/scene/read_scene.h"

#include <utility>

#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_lines.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/io/scene/scene_sculpting.h"

namespace batten {
namespace {

using Refusals = std::vector<std::pair<const char*, const char*>>;

void refuse(const TomlTable& table, const std::string& what, const Refusals& refusals) {
  for (const auto& [key, reason] : refusals)
    if (table.has(key)) table.fail(key, "'" + std::string(key) + "' " + what, reason);
}

void check_compatible_keys(const TomlTable& root) {
  for (const TomlTable& t : root.table("skin", skin_keys())) {
    constexpr const char* each =
        "none: each of several regions has the domain that suits it, or its [[region]]'s";
    refuse(t, "beside [[region]] or [[join]]",
           {{"domain", each}, {"settle", each}, {"mesher", each}, {"refine", "edge_length"}});
    for (const char* key : {"alpha", "beta"})
      if (t.has(key) && t.is_array(key))
        t.fail(key, "three numbers beside [[region]] or [[join]]",
               "one number: regions have no direction of u in common (a [[weight]] with along = "
               "\"LINE\" resists along a line)");
  }
}

std::vector<std::string> loop_of(const TomlTable& table, const std::vector<LocatedString>& words) {
  if (words.empty())
    table.fail("loops", "a loop without lines", "names of lines: loops = [[\"a\", \"b\", \"c\"]]");
  std::vector<std::string> names;
  for (const LocatedString& word : words) names.push_back(word.text);
  return names;
}

SkinOptions::Domain read_domain(const TomlTable& table) {
  using Domain = SkinOptions::Domain;
  return table.choice("domain", Domain::Auto,
                      {{"auto", Domain::Auto},
                       {"polygon", Domain::Polygon},
                       {"plane", Domain::Projected},
                       {"sheet", Domain::Developable},
                       {"ring", Domain::Annulus}});
}

/// How a region of a network is to be made. Throws InputError for a ring by its domain.
RegionOptions read_region_options(const TomlTable& table) {
  if (table.has("domain") && (table.text("domain") == "ring" || table.boolean("ring", false)))
    table.fail(
        "domain",
        "the domain '" + table.text("domain") + "'" + (table.has("ring") ? " of a ring" : ""),
        "ring = true alone");
  return {read_domain(table), table.positive("edge_length", 0)};
}

RegionSpec read_region(const TomlTable& table, UniqueNames& names) {
  RegionSpec word;
  word.where = table.at("loops");
  word.kind =
      table.boolean("surface", true) ? RegionSpec::Kind::Surface : RegionSpec::Kind::NoSurface;
  for (const auto& loop : table.string_lists("loops")) word.loops.push_back(loop_of(table, loop));
  if (word.loops.empty())
    table.fail("loops", "no loop", "one or more: loops = [[\"a\", \"b\", \"c\"]]");
  word.annulus = table.boolean("ring", false);
  word.skin = read_region_options(table);
  for (const LocatedString& inner : table.words("inner")) word.inner.push_back(inner.text);
  if (word.kind == RegionSpec::Kind::NoSurface) {
    refuse(table, "of a loop without surface",
           {{"name", "none: what is not there has no name"},
            {"ring", "none"},
            {"domain", "none: there is nothing to make"},
            {"edge_length", "none: there is nothing to make"},
            {"inner", "none: nothing lies on it"}});
    if (word.loops.size() > 1)
      table.fail("loops", std::to_string(word.loops.size()) + " loops beside surface = false",
                 "one; a [[region]] for each");
    return word;
  }
  if (table.has("name")) {
    word.name = table.text("name");
    if (word.name.empty()) table.fail("name", "an empty name", "one with letters");
    names.add(table, "name", word.name);
  }
  if (word.annulus && word.loops.size() != 2)
    table.fail("ring", "ring = true with " + std::to_string(word.loops.size()) + " loops",
               "2, its rims");
  return word;
}

/// The keys of one table that say how surfaces are found and joined. `tolerance`, `angle`: the keys of the gap tolerance
/// and of the crease angle.
void read_network_keys(const TomlTable& table, const char* tolerance, const char* crease,
                       SceneNetwork& network) {
  network.location = table.location();
  network.tolerance = table.positive(tolerance, network.tolerance);
  const auto angle = [&](const std::string& key, double& degrees, double most) {
    degrees = table.has(key) ? table.number(key) : degrees;
    if (!(degrees >= 0 && degrees <= most))
      table.fail(key, format_number(degrees), "0 to " + format_number(most) + " degrees");
  };
  angle("straight_angle", network.tangent_angle, 45);
  angle(crease, network.crease_angle, 180);
  network.join_tolerance = table.positive("join_tolerance", network.join_tolerance);
  if (table.has("trembling"))
    network.fair_noisy_lines = table.choice<bool>("trembling", {{"fair", true}, {"keep", false}});
  if (table.has("symmetry"))
    network.symmetry = table.choice<int>("symmetry", {{"x", 0}, {"y", 1}, {"z", 2}});
  network.max_faces_per_edge = table.integer("most_at_line", 1, network.max_faces_per_edge);
  if (network.max_faces_per_edge > 16)
    table.fail("most_at_line", std::to_string(network.max_faces_per_edge), "1 to 16");
}

/// What to write instead of the table [network] of older scenes.
std::string network_required_message(const Scene& scene, const TomlTable& table,
                                     const std::vector<std::string>& keys) {
  std::string moved;
  for (const std::string& key : keys) {
    if (!table.has(key)) continue;
    const std::string now = key == "tolerance"      ? "gap_tolerance"
                            : key == "smooth_below" ? "crease_angle"
                                                    : key;
    moved +=
        (moved.empty() ? "" : ", ") + (now == key ? "'" + key + "'" : "'" + key + "' as " + now);
  }
  return scene.at(table.location()) +
         "[network] is not needed any more, since every scene finds what its curves bound: delete "
         "it" +
         (moved.empty() ? "" : ", and write " + moved + " in [skin]");
}

/// Reads how surfaces are found and joined: keys of [skin], [[region]] and [[join]]; the table [network] of older scenes
/// is read, too, with a note that says what to write. Throws InputError for a mistake in the tables.
void read_network(const TomlTable& root, Scene& scene) {
  SceneNetwork network;
  const std::vector<std::string> old = {"tolerance",    "straight_angle", "most_at_line",
                                        "smooth_below", "join_tolerance", "trembling",
                                        "symmetry"};
  for (const TomlTable& table : root.table("network", old)) {
    read_network_keys(table, "tolerance", "smooth_below", network);
    scene.notes.push_back(network_required_message(scene, table, old));
  }
  for (const TomlTable& table : root.table("skin", skin_keys()))
    read_network_keys(table, "gap_tolerance", "crease_angle", network);
  if (root.has("region") || root.has("join")) check_compatible_keys(root);
  UniqueNames names("region name");
  for (const TomlTable& t : root.tables(
           "region", {"name", "loops", "inner", "ring", "surface", "domain", "edge_length"}))
    network.regions.push_back(read_region(t, names));
  for (const TomlTable& t : root.tables("join", {"lines", "kind"})) {
    const auto kind = t.choice<JoinSpec::Kind>("kind", {{"crease", JoinSpec::Kind::Crease},
                                                        {"smooth", JoinSpec::Kind::Smooth},
                                                        {"tangent", JoinSpec::Kind::Tangent},
                                                        {"curvature", JoinSpec::Kind::Curvature}});
    const auto lines = t.words("lines");
    if (lines.empty()) t.fail("lines", "no lines", "names: lines = [\"a\", \"b\"]");
    for (const LocatedString& line : lines)
      network.joins.push_back({line.text, kind, scene.at(line.location)});
  }
  scene.network = std::move(network);
}

void read_skin(const TomlTable& table, SceneSkin& skin) {
  using Mesher = SkinOptions::Mesher;
  using FixedBoundary = SceneSkin::FixedBoundary;
  skin.options.element =
      table.choice("element", TriangleElement::HCT,
                   {{"hct", TriangleElement::HCT}, {"z12", TriangleElement::Z12}});
  skin.options.mesher = table.choice("mesher", Mesher::Delaunay,
                                     {{"delaunay", Mesher::Delaunay}, {"fan", Mesher::Fan}});
  skin.options.domain = read_domain(table);
  skin.options.minimize_distortion = table.boolean("settle", false);
  skin.options.edge_length = table.positive("edge_length", 0);
  if (table.has("refine")) {
    if (skin.options.mesher != Mesher::Fan)
      table.fail("refine", "'refine' with the Delaunay mesher",
                 "it only with mesher = \"fan\" (edge_length says how fine a mesh is)");
    if (table.has("edge_length"))
      table.fail("refine", "both 'refine' and 'edge_length'", "one of them");
    skin.options.fan_refinements = table.integer("refine", 0, 0);
    if (skin.options.fan_refinements > 10)
      table.fail("refine", std::to_string(skin.options.fan_refinements), "0 to 10");
  }
  skin.units = table.choice("units", LoadUnits::Relative,
                            {{"relative", LoadUnits::Relative}, {"absolute", LoadUnits::Absolute}});
  skin.boundary =
      table.choice("hold", FixedBoundary::Lines,
                   {{"lines", FixedBoundary::Lines}, {"corners", FixedBoundary::Corners}});
  skin.fair = table.choice("fair", SceneSkin::Fair::Auto,
                           {{"auto", SceneSkin::Fair::Auto},
                            {"bending", SceneSkin::Fair::Bending},
                            {"variation", SceneSkin::Fair::Variation},
                            {"loft", SceneSkin::Fair::Loft}});
  for (const char* key : {"strength", "largest_move"})
    if (table.has(key) && skin.fair != SceneSkin::Fair::Variation)
      table.fail(key, std::string("'") + key + "' without variation",
                 "it only with fair = \"variation\"");
  skin.strength = table.positive("strength", 1);
  if (skin.strength > 1) table.fail("strength", format_number(skin.strength), "above 0, at most 1");
  skin.max_displacement = table.positive("largest_move", 0);
  if (table.has("sections")) {
    if (skin.fair != SceneSkin::Fair::Loft)
      table.fail("sections", "sections without a loft", "them only with fair = \"loft\"");
    skin.sections = table.names("sections");
  }
  if (skin.fair == SceneSkin::Fair::Variation && skin.options.element != TriangleElement::HCT)
    table.fail("fair", "\"variation\" with element \"z12\"", "element = \"hct\"");
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
    table.fail(key, "a material without a stable shape", expected);
  }
}

SceneTarget read_target(const TomlTable& table, const std::filesystem::path& folder,
                        const SceneSkin& skin) {
  SceneTarget target;
  target.location = table.location("file");
  target.file = folder / table.text("file");
  if (table.has("unit")) target.unit = read_unit(table, "unit");
  target.cage = table.choice("cage", false, {{"catmull-clark", true}, {"none", false}});
  target.tolerance = table.positive("tolerance", 0);
  if (skin.is_faired() || skin.boundary != SceneSkin::FixedBoundary::Lines)
    table.fail("file", "a target beside [skin] fair or hold = \"corners\"",
               "one of them: the shape is that of the target within its lines");
  return target;
}

// What [skin] fair makes impossible or leaves without effect.
void check_fair_keys(const TomlTable& root, const SceneSkin& skin) {
  using Fair = SceneSkin::Fair;
  if (skin.is_faired() && skin.boundary == SceneSkin::FixedBoundary::Corners)
    for (const TomlTable& t : root.table("skin", skin_keys()))
      t.fail("fair", "\"" + skin.fair_name() + "\" with hold = \"corners\"",
             "hold = \"lines\": a fair shape is that of its lines");
  if (skin.fair == Fair::Variation) return;
  for (const TomlTable& t : root.tables("join", {"lines", "kind"}))
    if (const std::string kind = t.text("kind"); kind == "tangent" || kind == "curvature")
      t.fail("kind", "\"" + kind + "\" where nothing is faired",
             "\"smooth\" or \"crease\", or fair = \"variation\" in [skin]");
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

ScenePicture scene_picture(const TomlTable& table, UniqueNames& files) {
  using Field = PictureScene::Field;
  ScenePicture picture;
  PictureScene& look = picture.look;
  picture.file = output_file(table, "file", files, {".png"});
  look.title = table.text("title", "");
  look.field = table.choice("show", Field::None,
                            {{"shaded", Field::None},
                             {"mean_curvature", Field::Mean},
                             {"gauss_curvature", Field::Gauss},
                             {"regions", Field::Regions}});
  look.contours = table.integer("contours", 0, 0);
  look.parameter_lines = table.integer("parameter_lines", 0, 0);
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
  look.lines = table.boolean("lines", true);
  look.mesh = table.boolean("mesh", false);
  read_view(table, look.azimuth, look.elevation, picture.size);
  return picture;
}

SceneSweep read_sweep(const TomlTable& table, const Scene& scene, UniqueNames& files) {
  SceneSweep sweep;
  sweep.parameter = table.text("parameter");
  sweep.values = table.list("values");
  sweep.columns = table.integer("columns", 1, 0);
  sweep.picture = scene_picture(table, files);
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

Scene scene_of(const toml::table& root_table, const std::filesystem::path& file,
               bool lines_required) {
  const TomlTable root(file.string(), root_table, "the scene",
                       {"name",       "unit",    "tolerance", "corner_angle", "line",      "lines",
                        "fair",       "network", "region",    "join",         "skin",      "target",
                        "constraint", "load",    "weight",    "move",         "parameter", "motion",
                        "stress",     "output",  "compare",   "picture",      "sweep"});
  const std::filesystem::path folder = file.parent_path();
  Scene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = read_unit(root, "unit");
  scene.skin.options.tolerance = root.positive("tolerance", 0);
  scene.skin.options.corner_angle = root.positive("corner_angle", 20);
  if (scene.skin.options.corner_angle >= 180)
    root.fail("corner_angle", format_number(scene.skin.options.corner_angle),
              "less than 180 degrees");

  read_network(root, scene);
  scene.lines = read_scene_lines(root, folder, true, lines_required);
  scene.fairing = read_fair_stages(root);

  for (const TomlTable& t : root.table("skin", skin_keys())) read_skin(t, scene.skin);

  for (const TomlTable& t : root.tables("target", {"file", "unit", "cage", "tolerance"}))
    scene.targets.push_back(read_target(t, folder, scene.skin));

  read_sculpting(root, folder, scene);
  check_fair_keys(root, scene.skin);

  for (const TomlTable& t : root.table("stress", stress_keys()))
    scene.stress = read_stress(t, scene.unit);

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
    scene.step_lines = t.boolean("step_lines", false);
    scene.step_ap242 = t.choice("step_schema", false, {{"ap214", false}, {"ap242", true}});
    for (const char* key : {"step_form", "step_tolerance", "step_lines", "step_schema"})
      if (t.has(key) && scene.step.empty())
        t.fail(key, "'" + std::string(key) + "' without 'step'", "both");
    if (t.has("vtu")) scene.vtu = output_file(t, "vtu", files, {".vtu"});
    if (t.has("vtp")) scene.vtp = output_file(t, "vtp", files, {".vtp"});
    if (t.has("calculix")) scene.calculix = output_file(t, "calculix", files, {".inp"});
    if (t.has("calculix") && !scene.stress)
      t.fail("calculix", "a CalculiX deck", "a section [stress] with material and supports for it");
  }
  for (const TomlTable& t : root.tables("picture", kPictureKeys))
    scene.pictures.push_back(scene_picture(t, files));
  std::vector<std::string> sweep_keys = {"parameter", "values", "columns"};
  sweep_keys.insert(sweep_keys.end(), kPictureKeys.begin(), kPictureKeys.end());
  for (const TomlTable& t : root.tables("sweep", sweep_keys))
    scene.sweeps.push_back(read_sweep(t, scene, files));
  return scene;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::filesystem::path& file, bool lines_required) {
  return scene_of(parse_toml(text, file, "a scene (unit, [[line]] …)"), file, lines_required);
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_input_file(file, "a scene (.toml)"), file);
}

}  // namespace batten
