// Scenes from what Python gives: files, texts, and lines as arrays.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/apps/python/bindings.h"
#include "batten/io/scene/scene.h"

namespace batten::python {

/// Lines as arrays, and what is said of them.
struct SkinArguments {
  std::string name, unit, words;
  py::object tolerance, edge_length, corner_angle;  ///< numbers above 0, or None
  py::iterable inner, holes, smooth, crease;        ///< names of lines
};

/// A scene of lines by their names: points n×3, or a Curve. `words`: text of a scene, which says
/// everything but lines and the unit. Throws InputError.
Scene scene_of_arrays(const py::dict& lines, const SkinArguments& words);

/// A scene of a file: a scene's, or the curves of a file.
Scene scene_of_file(const std::string& file);

/// Parameters by name, from a dict or None. Throws InputError on what is no number.
std::vector<std::pair<std::string, double>> values_from(const py::object& given);

/// Sets these in any kind of scene.
template <class AnyScene>
void set_values(AnyScene& scene, const py::object& given) {
  for (const auto& [name, value] : values_from(given)) scene.set(name, value, "");
}

/// A JSON text as Python's dicts and lists.
py::object json_object(const std::string& text);

/// The file's name of a str or an os.PathLike. Throws InputError.
std::string path_from(const py::object& given);

}  // namespace batten::python
