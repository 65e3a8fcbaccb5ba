// SPDX-License-Identifier: MPL-2.0
// Binds complete runs of scenes, like the commands of the program, with the report as a dict.
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"

namespace batten::python {
namespace {

using namespace py::literals;

/// Reads a scene file, or makes a scene of the curves in a curve file.
Scene scene_of_file(const std::string& file) {
  const FileKind kind = file_kind(file);
  if (kind == FileKind::Cad || kind == FileKind::Lines) return scene_of_lines({file}, {}, "mm");
  return read_scene(file);
}

/// Runs a scene with the given parameter values and returns its report.
template <class AnyScene>
py::object report_of(AnyScene& scene, const py::object& out, const py::object& values,
                     const py::object& progress) {
  if constexpr (requires { scene.set("", 0.0, ""); })
    set_values(scene, values);
  else if (!values_from(values).empty())
    throw InputError("values: found parameter values, expected none: this scene has no parameters");
  const std::string folder = path_from(out);
  return json_object(KernelCall(progress)(
      [&](const Progress& hook) { return to_json(run_any_scene(scene, folder, hook)); }));
}

py::object run_scene_file(const py::object& path, const py::object& out, const py::object& values,
                          const py::object& progress) {
  const std::string file = path_from(path);
  const FileKind kind = file_kind(file);
  if (kind != FileKind::Cad && kind != FileKind::Lines)
    return visit_scene(file, [&](auto& scene) { return report_of(scene, out, values, progress); });
  Scene scene = scene_of_file(file);
  return report_of(scene, out, values, progress);
}

py::object run_mesh(const py::object& path, const py::object& out, const py::object& values,
                    const py::object& derivatives, const py::object& doe, const py::dict& ranges,
                    const py::object& progress) {
  DeformScene scene = read_deform_scene(path_from(path));
  set_values(scene, values);
  MorphTask task;
  if (py::isinstance<py::list>(derivatives) || py::isinstance<py::tuple>(derivatives))
    for (const auto& file : derivatives)
      task.derivatives.emplace_back(path_from(py::reinterpret_borrow<py::object>(file)));
  else if (!derivatives.is_none())
    task.derivatives.emplace_back(path_from(derivatives));
  if (!doe.is_none()) task.doe = path_from(doe);
  for (const auto& [name, range] : ranges) {
    std::string text = std::string(py::str(name)) + "=";
    const std::vector<double> numbers = numbers_from(range, "ranges");
    for (size_t i = 0; i < numbers.size(); ++i)
      text += (i > 0 ? ":" : "") + std::string(py::repr(py::float_(numbers[i])));
    task.ranges.push_back(text);
  }
  const std::string folder = path_from(out);
  return json_object(KernelCall(progress)(
      [&](const Progress& hook) { return to_json(run_deform(scene, folder, task, hook)); }));
}

py::object run_frames(const py::object& path, const py::object& out, const py::object& progress) {
  SequenceScene scene = read_sequence_scene(path_from(path));
  return report_of(scene, out, py::none(), progress);
}

py::list run_conversion(const py::object& from, const py::object& to, double chord,
                        const std::string& unit, const std::string& from_unit,
                        const py::object& progress) {
  ConvertTask task;
  task.from = path_from(from);
  task.to = path_from(to);
  task.chord = chord;
  task.unit = unit;
  task.from_unit = from_unit;
  const ConvertReport report =
      KernelCall(progress)([&](const Progress& hook) { return run_convert(task, hook); });
  return py::cast(sentences(report.failed_checks));
}

}  // namespace

py::object run_stress_file(const py::object& path, const py::object& out, const py::object& values,
                           std::optional<double> accuracy, const py::object& progress) {
  Scene scene = scene_of_file(path_from(path));
  set_values(scene, values);
  const std::string folder = path_from(out);
  StressTask task;
  task.accuracy = accuracy;
  return json_object(KernelCall(progress)(
      [&](const Progress& hook) { return to_json(run_stress(scene, folder, task, hook)); }));
}

void bind_runs(py::module_& m) {
  m.def(
      "run", &run_scene_file, "path"_a, "out"_a, py::kw_only(), "values"_a = py::none(),
      "progress"_a = py::none(),
      R"(Same as `batten run`: writes all outputs of a scene into a folder. Returns the report, a dict.

`values`: parameters {name: value}. Raises the exceptions of load(), FileError.

    >>> report = batten.run("examples/05-door/scene.toml", "out/door", values={"swell": 250})
    >>> "door.step" in report["files"]
    True)");
  m.def(
      "deform", &run_mesh, "path"_a, "out"_a, py::kw_only(), "values"_a = py::none(),
      "derivatives"_a = py::none(), "doe"_a = py::none(), "ranges"_a = py::dict(),
      "progress"_a = py::none(),
      R"(Same as `batten deform`: applies the edits of a deform scene and writes its outputs into a folder.

`values`: parameters {name: value}. `derivatives`: a file or files (.csv, .npz, .bdf). `doe`: "lhs:N",
"grid" or a CSV file; `ranges`: {name: (from, to) or (from, to, count)}. Returns the report, a dict.
Raises InputError, ConflictError, NoSolutionError, FileError.

    >>> report = batten.deform("examples/11-panel/edit.toml", "out/panel")
    >>> "panel-longer.bdf" in report["files"]
    True)");
  m.def(
      "sequence", &run_frames, "path"_a, "out"_a, py::kw_only(), "progress"_a = py::none(),
      R"(Same as `batten sequence`: applies the operations of a sequence scene to an animated mesh.

Writes its outputs into a folder. Returns the report, a dict. Raises InputError, NoSolutionError,
FileError.

    >>> report = batten.sequence("examples/29-forming/forming.toml", "out/forming")
    >>> len(report["files"]) > 0
    True)");
  m.def(
      "convert", &run_conversion, "source"_a, "target"_a, py::kw_only(), "chord"_a = 0.0,
      "unit"_a = "", "from_unit"_a = "", "progress"_a = py::none(),
      R"(Same as `batten convert`: converts CAD files, meshes and curves; extensions select the formats.

`chord`: maximum distance of triangles from CAD faces, in the target's unit; 0: 1e-3 of the size.
Returns the failed checks, as sentences. Raises InputError, FileError.

    >>> batten.convert("examples/30-refit/scan.obj", "scan.stl")
    [])");
}

}  // namespace batten::python
