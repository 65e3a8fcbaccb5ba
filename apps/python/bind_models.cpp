// Binds models: curves as arrays, or scenes, and the surfaces that they produce.
#include <cmath>
#include <set>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/model.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/scene/scene.h"

namespace batten::python {
namespace {

using ModelPtr = std::shared_ptr<const Model>;
using namespace py::literals;

// Scenes whose curves are given as arrays.

/// Arguments of a scene whose curves are given as arrays.
struct SkinArguments {
  std::string name, unit, settings;
  py::object fit_tolerance, edge_length, corner_angle;  ///< numbers above 0, or None
  py::iterable inner, holes, smooth, crease;            ///< curve names
};

const std::string kSkin = "skin()";

double number_above_0(const py::object& given, const std::string& what) {
  const double value = PyFloat_AsDouble(given.ptr());
  if (PyErr_Occurred())
    PyErr_Clear();
  else if (std::isfinite(value) && value > 0)
    return value;
  throw InputError(what + ": found " + std::string(py::repr(given)) +
                   ", expected a number above 0");
}

/// TOML text of a scene without curves: the unit, then the user's text. Line numbers in messages
/// are those of the user's text if it begins with an empty line, as triple-quoted strings usually
/// do.
std::string text_of(const SkinArguments& arguments) {
  if (arguments.unit.find_first_of("\"\\\n") != std::string::npos)
    throw InputError("unit: found '" + arguments.unit + "', expected mm, cm, m, in or ft");
  const std::string text = "unit = \"" + arguments.unit + "\"";
  return arguments.settings.starts_with('\n') ? text + arguments.settings
                                              : text + "\n" + arguments.settings;
}

std::vector<std::string> names_from(const py::iterable& given, const std::string& what,
                                    const std::set<std::string>& lines) {
  if (py::isinstance<py::str>(given))
    throw InputError(what + ": found a single text, expected a list of curve names");
  std::vector<std::string> names;
  for (const py::handle name : given) {
    names.push_back(py::str(name));
    if (!lines.count(names.back())) {
      const std::string near = closest_match(names.back(), {lines.begin(), lines.end()});
      throw InputError(what + ": found the curve name '" + names.back() +
                       "', expected one of curves" +
                       (near.empty() ? "" : "; did you mean '" + near + "'?"));
    }
  }
  return names;
}

SceneLine line_of(const std::string& name, const py::handle& given) {
  SceneLine line;
  line.name = name;
  if (py::isinstance<HermiteCurve>(given)) {
    line.curve = curve_from_hermite(given.cast<HermiteCurve>());
    return line;
  }
  line.points = rows_of(points_from(given, "curve '" + name + "'"));
  constexpr size_t fewest = 2;
  if (line.points.size() < fewest)
    throw InputError("curve '" + name + "': found " + std::to_string(line.points.size()) +
                     " points, expected 2 or more");
  return line;
}

void give_roles(Scene& scene, const std::vector<std::string>& names, CharacterLine::Role role) {
  for (SceneLine& line : scene.lines)
    for (const std::string& name : names)
      if (line.name == name) line.role = role;
}

void join_names(SceneNetwork& network, const std::vector<std::string>& lines, JoinSpec::Kind kind) {
  for (const std::string& line : lines) network.joins.push_back({line, kind, kSkin + ": "});
}

/// Creates a scene from a dict of curves by name, each an n×3 array of points or a Curve.
/// `arguments`: further settings; its text is TOML with everything but curves and the unit. Throws
/// InputError.
Scene scene_of_arrays(const py::dict& curves, const SkinArguments& arguments) {
  if (curves.empty()) throw InputError("curves: found none, expected one or more");
  Scene scene = parse_scene(text_of(arguments), kSkin, false);
  if (!scene.lines.empty())
    throw InputError("settings: found a [[curve]], expected none: curves are given as arrays");
  if (!arguments.name.empty()) scene.name = arguments.name;
  std::set<std::string> names;
  for (const auto& [name, given] : curves) {
    const std::string text = py::str(name);
    if (text.empty()) throw InputError("curves: found an empty name, expected one with letters");
    if (!names.insert(text).second)
      throw InputError("curves: found the name '" + text + "' twice, expected different names");
    scene.lines.push_back(line_of(text, given));
  }
  const auto inner = names_from(arguments.inner, "inner", names),
             holes = names_from(arguments.holes, "holes", names),
             smooth = names_from(arguments.smooth, "smooth", names),
             crease = names_from(arguments.crease, "crease", names);
  give_roles(scene, inner, CharacterLine::Role::Inner);
  give_roles(scene, holes, CharacterLine::Role::Hole);
  join_names(scene.network, smooth, JoinSpec::Kind::Smooth);
  join_names(scene.network, crease, JoinSpec::Kind::Crease);
  SkinOptions& options = scene.skin.options;
  if (!arguments.fit_tolerance.is_none())
    options.tolerance = number_above_0(arguments.fit_tolerance, "fit_tolerance");
  if (!arguments.edge_length.is_none())
    options.edge_length = number_above_0(arguments.edge_length, "edge_length");
  if (!arguments.corner_angle.is_none())
    options.corner_angle = number_above_0(arguments.corner_angle, "corner_angle");
  return scene;
}

// Models.

ModelPtr made(const Scene& scene, const py::object& progress) {
  return KernelCall(progress)([&](const Progress& hook) { return Model::of_scene(scene, hook); });
}

std::shared_ptr<const FacetArrays> facets_of(const Model& model) {
  require_surface(model);
  return KernelCall()([&](const Progress&) { return model.facets(); });
}

py::array points_of(const Model& model) {
  const auto facets = facets_of(model);
  return rows_view(facets, facets->points.data(),
                   static_cast<py::ssize_t>(facets->points.size() / 3), 3);
}

py::array normals_of(const Model& model) {
  const auto facets = facets_of(model);
  return rows_view(facets, facets->normals.data(),
                   static_cast<py::ssize_t>(facets->normals.size() / 3), 3);
}

py::array triangles_of(const Model& model) {
  const auto facets = facets_of(model);
  return rows_view(facets, facets->triangles.front().data(),
                   static_cast<py::ssize_t>(facets->triangles.size()), 3);
}

py::array triangle_faces_of(const Model& model) {
  const auto facets = facets_of(model);
  return array_view(facets, facets->regions.data(),
                    {static_cast<py::ssize_t>(facets->regions.size())}, {sizeof(int)});
}

py::dict parameters_of(const Model& model) {
  py::dict values;
  for (const Parameter& p : model.scene().parameters()) values[py::str(p.name)] = p.value;
  return values;
}

py::list face_names(const Model& model) {
  py::list names;
  for (const SkinnedRegion& region : model.shape().regions) names.append(region.name);
  return names;
}

py::list curve_names(const Model& model) {
  py::list names;
  for (const CharacterLine& line : model.lines()) names.append(line.name);
  return names;
}

py::array curve_points(const Model& model, const std::string& name, int count) {
  std::vector<std::string> names;
  for (const CharacterLine& line : model.lines()) {
    names.push_back(line.name);
    if (line.name != name) continue;
    if (count < 2)
      throw InputError("count: found " + std::to_string(count) + ", expected 2 or more");
    Points points(count, 3);
    const InputCurve& curve = *line.curve;
    for (int i = 0; i < count; ++i)
      points.row(i) =
          curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / (count - 1));
    return array_of(std::move(points));
  }
  const std::string near = closest_match(name, names);
  throw InputError("found the curve name '" + name + "', expected a curve of the model" +
                   (near.empty() ? "" : "; did you mean '" + near + "'?"));
}

py::object report_of(const Model& model) {
  return json_object(
      KernelCall()([&](const Progress& hook) { return to_json(model.report(hook)); }));
}

py::list failed_check_list(const Report& report) {
  py::list failed_checks;
  for (const FailedCheck& one : report.failed_checks)
    failed_checks.append(one.what + ": " + one.detail);
  return failed_checks;
}

py::list failed_checks_of(const Model& model) {
  return failed_check_list(
      *KernelCall()([&](const Progress& hook) { return &model.report(hook); }));
}

py::list save(const Model& model, const py::object& path, const py::object& progress) {
  require_surface(model);
  const std::string file = path_from(path);
  return failed_check_list(KernelCall(progress)([&](const Progress& hook) {
    return export_shape(model.scene(), *model.made(), model.shape(), file, hook);
  }));
}

PictureScene::Field field_from(const std::string& word) {
  if (word == "none") return PictureScene::Field::None;
  if (word == "mean") return PictureScene::Field::Mean;
  if (word == "gauss") return PictureScene::Field::Gauss;
  if (word == "faces") return PictureScene::Field::Regions;
  throw InputError("field: found '" + word + "', expected none, mean, gauss or faces");
}

void picture(const Model& model, const py::object& path, int width, int height, double azimuth,
             double elevation, const std::string& field, int contours, int zebra, bool mesh,
             const std::string& title) {
  require_surface(model);
  PictureScene look;
  look.azimuth = azimuth;
  look.elevation = elevation;
  look.field = field_from(field);
  look.contours = contours;
  look.zebra = zebra;
  look.mesh = mesh;
  look.title = title;
  const std::string file = path_from(path);
  KernelCall()([&](const Progress&) {
    draw_picture(file, shape_picture(look, *model.made(), model.shape()), {width, height});
  });
}

std::string model_repr(const Model& model) {
  size_t triangles = 0;
  for (const SkinnedRegion& region : model.shape().regions)
    triangles += static_cast<size_t>(region.surface.mesh().triangle_count());
  return "<batten.Model '" + model.scene().name +
         "': " + std::to_string(model.shape().regions.size()) + " faces, " +
         std::to_string(triangles) + " elements, in " + model.scene().unit + ">";
}

py::dict curves_of_file(const py::object& path, const std::string& unit, double corner_angle) {
  const std::string file = path_from(path);
  const auto lines = KernelCall()([&](const Progress&) {
    std::vector<std::pair<std::string, std::vector<Vec3>>> read;
    for (const SourceLine& line : read_source_file(file, unit, unit.empty() ? "mm" : unit))
      read.emplace_back(line.name, sample_line(line, corner_angle).points);
    return read;
  });
  py::dict result;
  for (const auto& [name, points] : lines) {
    Points rows(static_cast<long>(points.size()), 3);
    for (long i = 0; i < rows.rows(); ++i) rows.row(i) = points[static_cast<size_t>(i)];
    std::string free = name;
    for (int n = 2; result.contains(free); ++n) free = name + " " + std::to_string(n);
    result[py::str(free)] = array_of(std::move(rows));
  }
  return result;
}

void bind_making(py::module_& m) {
  m.def(
      "skin",
      [](const py::dict& curves, const py::object& fit_tolerance, const py::object& edge_length,
         const py::object& corner_angle, const py::iterable& inner, const py::iterable& holes,
         const py::iterable& smooth, const py::iterable& crease, const std::string& name,
         const std::string& unit, const std::string& settings, const py::object& progress) {
        return made(scene_of_arrays(curves, {name, unit, settings, fit_tolerance, edge_length,
                                             corner_angle, inner, holes, smooth, crease}),
                    progress);
      },
      "curves"_a, py::kw_only(), "fit_tolerance"_a = py::none(), "edge_length"_a = py::none(),
      "corner_angle"_a = py::none(), "inner"_a = py::tuple(), "holes"_a = py::tuple(),
      "smooth"_a = py::tuple(), "crease"_a = py::tuple(), "name"_a = "surface", "unit"_a = "mm",
      "settings"_a = "", "progress"_a = py::none(),
      R"(Fits surfaces through curves, {name: points n×3, or a Curve}, and finds the faces they bound.

Curves in `inner` lie on a face, those in `holes` trim one. `fit_tolerance`, `edge_length`: model
units (defaults: 1e-4 and 1/20 of the size). `corner_angle`: degrees. `smooth`, `crease`: names of
curves along which faces meet smoothly, or with a crease (G0). `settings`: text of a scene without
curves and unit, for everything else (docs/scenes.md). `progress(stage, fraction)`: an exception that
it raises stops the computation. Raises InputError, ConflictError, NoSolutionError.
Reference: Celniker, Gossard 1991: K q = F with the curves as constraints (docs/theory/domains.md).)");
  m.def(
      "load",
      [](const py::object& path, const py::object& values, const py::object& progress) {
        Scene scene = scene_of_file(path_from(path));
        set_values(scene, values);
        return made(scene, progress);
      },
      "path"_a, py::kw_only(), "values"_a = py::none(), "progress"_a = py::none(),
      R"(The model of a scene file (.toml), or of a curve file.

`values`: parameters {name: value} that replace those of the scene. Raises InputError,
"FILE:LINE:COLUMN: found …, expected …", ConflictError, NoSolutionError.)");
  m.def(
      "parse",
      [](const std::string& text, const py::object& folder, const py::object& values,
         const py::object& progress) {
        Scene scene = parse_scene(text, std::filesystem::path(path_from(folder)) / "scene");
        set_values(scene, values);
        return made(scene, progress);
      },
      "text"_a, py::kw_only(), "folder"_a = ".", "values"_a = py::none(), "progress"_a = py::none(),
      "The model of a scene given as text; paths in it are relative to `folder`. Raises the "
      "exceptions of load().");
  m.def(
      "read_curves", &curves_of_file, "path"_a, py::kw_only(), "unit"_a = "",
      "corner_angle"_a = 20.0,
      R"(The curves of a file, {name: points n×3}: tables of points, CAD curves, drawings, sketches.

Points are those of the file; CAD curves are sampled uniformly by arc length between their corners,
where they turn by more than `corner_angle` degrees. `unit`: length unit of a file that states none.)");
}

}  // namespace

void bind_models(py::module_& m) {
  py::class_<Model, std::shared_ptr<Model>>(m, "Model",
                                            "Curves and the surface through them. Immutable.")
      .def_property_readonly("name", [](const Model& model) { return model.scene().name; })
      .def_property_readonly(
          "unit", [](const Model& model) { return model.scene().unit; }, "Length unit.")
      .def_property_readonly("faces", &face_names, "Names of the faces that have a surface.")
      .def_property_readonly("curves", &curve_names, "Names of the curves.")
      .def_property_readonly(
          "fit_tolerance", [](const Model& model) { return model.made()->fit_tolerance; },
          "Maximum distance of the fitted curves from the input curves, model units.")
      .def_property_readonly("parameters", &parameters_of,
                             "Values of the scene's parameters, {name: value}.")
      .def_property_readonly("points", &points_of,
                             "Points of the surface's triangles, n×3 float64, model units. A view.")
      .def_property_readonly("normals", &normals_of,
                             "Exact unit normals x_u × x_v at the points, n×3 float64. A view.")
      .def_property_readonly(
          "triangles", &triangles_of,
          "Point indices of the triangles, m×3 int32, counter-clockwise. A view.")
      .def_property_readonly("triangle_faces", &triangle_faces_of,
                             "Index into `faces` of each triangle, m int32. A view.")
      .def("curve", &curve_points, "name"_a, "count"_a = 97,
           "Points along a curve, uniform in its parameter, count×3, model units.")
      .def_property_readonly("report", &report_of,
                             "All measured values, as in report.json (docs/scenes.md).")
      .def_property_readonly(
          "failed_checks", &failed_checks_of,
          "The failed checks, as sentences with the amount; [] if all checks passed.")
      .def(
          "with_values",
          [](const Model& model, const py::dict& values, const py::object& progress) {
            const auto numbers = values_from(values);
            return KernelCall(progress)(
                [&](const Progress& hook) { return model.with_values(numbers, hook); });
          },
          "values"_a, py::kw_only(), "progress"_a = py::none(),
          "The shape of the same curves for other parameter values. Raises the exceptions of "
          "load().")
      .def(
          "save", &save, "path"_a, py::kw_only(), "progress"_a = py::none(),
          R"(Writes the surface to a file; the extension selects the format. The file is complete or absent.

.step .iges .brep .glb .stl .obj .ply .off .3mf .vtp .vtu .inp. Returns the failed checks, as sentences.
Raises InputError for another extension, FileError if the file cannot be written.)")
      .def(
          "picture", &picture, "path"_a, py::kw_only(), "width"_a = 1600, "height"_a = 1000,
          "azimuth"_a = -30.0, "elevation"_a = 30.0, "field"_a = "none", "contours"_a = 0,
          "zebra"_a = 0, "mesh"_a = false, "title"_a = "",
          R"(Draws the surface to a PNG file. Needs an X server (xvfb-run); call it on the main thread.

`width`, `height`: pixels. `azimuth`, `elevation`: degrees. `field`: none, mean, gauss, faces.
`contours`: number of height contours. `zebra`: number of zebra stripes.)")
      .def("__repr__", &model_repr);
  bind_making(m);
}

}  // namespace batten::python
