// Creates scenes from Python arguments: files, TOML texts, and curves as arrays.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/apps/python/bindings.h"
#include "batten/io/scene/scene.h"

namespace batten::python {

/// Arguments of a scene whose curves are given as arrays.
struct SkinArguments {
  std::string name, unit, settings;
  py::object fit_tolerance, edge_length, corner_angle;  ///< numbers above 0, or None
  py::iterable inner, holes, smooth, crease;            ///< curve names
};

/// Creates a scene from a dict of curves by name, each an n×3 array of points or a Curve.
/// `arguments`: further settings; its text is TOML with everything but curves and the unit. Throws
/// InputError.
Scene scene_of_arrays(const py::dict& curves, const SkinArguments& arguments);

/// Reads a scene file, or makes a scene of the curves in a curve file.
Scene scene_of_file(const std::string& file);

/// Parameter values by name, from a dict or None. Throws InputError for values that are not
/// numbers.
std::vector<std::pair<std::string, double>> values_from(const py::object& given);

/// Sets the parameter values in any kind of scene.
template <class AnyScene>
void set_values(AnyScene& scene, const py::object& given) {
  for (const auto& [name, value] : values_from(given)) scene.set(name, value, "");
}

/// Converts a JSON text to Python dicts and lists.
py::object json_object(const std::string& text);

/// Converts a str or an os.PathLike to a file name. Throws InputError.
std::string path_from(const py::object& given);

}  // namespace batten::python
