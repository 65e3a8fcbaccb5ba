#include "batten/apps/python/scenes.h"

#include <cmath>
#include <set>

#include "batten/apps/commands/info.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/apps/python/arrays.h"
#include "batten/core/errors.h"
#include "batten/io/scene/read_scene.h"

namespace batten::python {
namespace {

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

}  // namespace

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

Scene scene_of_file(const std::string& file) {
  switch (file_kind(file)) {
    case FileKind::Cad:
    case FileKind::Lines:
      return scene_of_lines({file}, {}, "mm");
    default:
      return read_scene(file);
  }
}

std::vector<std::pair<std::string, double>> values_from(const py::object& given) {
  std::vector<std::pair<std::string, double>> values;
  if (given.is_none()) return values;
  if (!py::isinstance<py::dict>(given))
    throw InputError("found " + std::string(py::repr(given)) +
                     ", expected a dict of parameter values, as {\"swell\": 250}");
  for (const auto& [name, value] : given.cast<py::dict>()) {
    const std::string text = py::str(name);
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred()) {
      PyErr_Clear();
      throw InputError(text + ": found " + std::string(py::repr(value)) + ", expected a number");
    }
    values.emplace_back(text, number);
  }
  return values;
}

py::object json_object(const std::string& text) {
  return py::module_::import("json").attr("loads")(text);
}

std::string path_from(const py::object& given) {
  try {
    return py::str(py::module_::import("os").attr("fspath")(given));
  } catch (const py::error_already_set&) {
    throw InputError("found " + std::string(py::repr(given)) + ", expected a file name");
  }
}

}  // namespace batten::python
