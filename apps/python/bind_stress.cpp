// Binds stress analyses: of models in memory, and of scene files.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/stress_data.h"

namespace batten::python {
namespace {

using namespace py::literals;

// Settings as TOML text.

[[noreturn]] void refuse_setting(py::handle given, const std::string& what,
                                 const std::string& expected) {
  throw InputError(what + ": found " + std::string(py::repr(given)) + ", expected " + expected);
}

std::string toml_key(py::handle given, const std::string& what) {
  if (!py::isinstance<py::str>(given)) refuse_setting(given, what, "a key that is a text");
  const std::string key = py::str(given);
  const bool bare = !key.empty() && key.find_first_not_of(
                                        "abcdefghijklmnopqrstuvwxyz"
                                        "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                        "0123456789_-") == std::string::npos;
  return bare ? key : SceneText::toml_value(key);
}

/// TOML text, on one line, of numbers, texts, lists and dicts of Python and NumPy. `what`: name of
/// the value in messages.
std::string toml_from(py::handle given, const std::string& what, int depth = 0) {
  constexpr int deepest = 16;
  if (depth > deepest) throw InputError(what + ": found too many nested lists, expected fewer");
  if (py::isinstance<py::bool_>(given)) return given.ptr() == Py_True ? "true" : "false";
  if (py::isinstance<py::int_>(given)) {
    int overflow = 0;
    const long long value = PyLong_AsLongLongAndOverflow(given.ptr(), &overflow);
    if (overflow) refuse_setting(given, what, "a number of at most 64 bits");
    return std::to_string(value);
  }
  if (py::isinstance<py::float_>(given)) {
    const double value = PyFloat_AsDouble(given.ptr());
    if (!std::isfinite(value)) refuse_setting(given, what, "a finite number");
    return SceneText::toml_value(value);
  }
  if (py::isinstance<py::str>(given)) return SceneText::toml_value(std::string(py::str(given)));
  if (py::isinstance<py::dict>(given)) {
    std::string text;
    for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(given)) {
      const std::string key = toml_key(name, what);
      text +=
          (text.empty() ? "" : ", ") + key + " = " + toml_from(value, what + "." + key, depth + 1);
    }
    return text.empty() ? "{}" : "{ " + text + " }";
  }
  if (py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given)) {
    std::vector<std::string> texts;
    for (const py::handle item : py::reinterpret_borrow<py::sequence>(given))
      texts.push_back(toml_from(item, what + "[" + std::to_string(texts.size()) + "]", depth + 1));
    return SceneText::list(texts);
  }
  if (py::hasattr(given, "dtype") && py::hasattr(given, "tolist"))
    return toml_from(given.attr("tolist")(), what, depth + 1);
  refuse_setting(given, what, "a number, a text, a list or a dict");
}

/// The entries of `supports` or `loads`: one, or a list of them. `names`: the name of a curve is an
/// entry.
std::vector<std::string> entries_from(const py::object& given, const std::string& what,
                                      bool names) {
  const auto entry = [&](py::handle one, const std::string& label) {
    if (names && py::isinstance<py::str>(one)) return "{ curve = " + toml_from(one, label) + " }";
    if (!py::isinstance<py::dict>(one))
      refuse_setting(one, label,
                     names ? "the name of a curve, or a dict such as {'curve': 'rim', 'type': "
                             "'pinned'}"
                           : "a dict such as {'pressure': 0.01}");
    return toml_from(one, label);
  };
  if (given.is_none()) return {};
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given))
    return {entry(given, what)};
  std::vector<std::string> entries;
  for (const py::handle one : py::reinterpret_borrow<py::sequence>(given))
    entries.push_back(entry(one, what + "[" + std::to_string(entries.size()) + "]"));
  return entries;
}

/// The name of a material, or its constants as a dict.
void add_material(const py::object& material, detail::StressTable& table) {
  if (py::isinstance<py::str>(material)) {
    table.values.emplace_back("material", toml_from(material, "material"));
    return;
  }
  if (!py::isinstance<py::dict>(material))
    refuse_setting(material, "material",
                   "a name such as 'steel', or a dict such as {'young': 210e3, 'poisson': 0.3}");
  const std::vector<std::string> known = {"young", "poisson", "density", "shear_modulus",
                                          "material_direction"};
  for (const auto& [name, value] : material.cast<py::dict>()) {
    const std::string key = toml_key(name, "material");
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError("material: found the key '" + key +
                       "', expected young, poisson, density, shear_modulus or material_direction" +
                       did_you_mean(key, known));
    table.values.emplace_back(key, toml_from(value, "material." + key));
  }
}

/// Refuses arguments of the other kind of call. `given`: whether each argument was given.
void refuse_arguments(const std::vector<std::pair<std::string, bool>>& given,
                      const std::string& expected) {
  for (const auto& [name, is_given] : given)
    if (is_given) throw InputError(name + ": found a value, expected none " + expected);
}

py::object analyse(const py::object& source, const py::object& out, const py::object& material,
                   const py::object& thickness, const py::object& supports, const py::object& loads,
                   const py::object& yield_stress, int modes, int buckling,
                   const std::string& settings, const py::object& values, double accuracy,
                   const py::object& progress) {
  if (!py::isinstance<Model>(source)) {
    refuse_arguments({{"material", !material.is_none()},
                      {"thickness", !thickness.is_none()},
                      {"supports", !supports.is_none()},
                      {"loads", !loads.is_none()},
                      {"yield_stress", !yield_stress.is_none()},
                      {"modes", modes != 0},
                      {"buckling", buckling != 0},
                      {"settings", !settings.empty()}},
                     "with a scene file, whose [stress] is used; or load() the file");
    if (out.is_none()) throw InputError("out: found None, expected a folder for the files");
    return run_stress_file(source, out, values, accuracy, progress);
  }
  refuse_arguments({{"out", !out.is_none()}}, "with a model: no files are written");
  refuse_arguments({{"accuracy", accuracy != 0}},
                   "with a model; use a smaller edge_length, or a scene file");
  detail::StressTable table;
  if (!material.is_none()) add_material(material, table);
  if (!thickness.is_none())
    table.values.emplace_back("thickness", toml_from(thickness, "thickness"));
  if (!yield_stress.is_none())
    table.values.emplace_back("yield", toml_from(yield_stress, "yield_stress"));
  if (modes != 0) table.values.emplace_back("modes", std::to_string(modes));
  if (buckling != 0) table.values.emplace_back("buckling", std::to_string(buckling));
  table.supports = entries_from(supports, "supports", true);
  table.loads = entries_from(loads, "loads", false);
  table.settings = settings;
  const auto numbers = values_from(values);
  auto model = source.cast<Model>();
  return py::cast(KernelCall(progress)([&](const Progress& hook) {
    if (!numbers.empty()) model = model.with_values({numbers.begin(), numbers.end()}, hook);
    return detail::stress_of_table(model, table, hook);
  }));
}

// Results.

py::array stress_vector(const Vec3& v) { return array_of(std::vector<double>{v[0], v[1], v[2]}); }

py::array rows_of_three(std::vector<double> numbers) {
  const auto owner = std::make_shared<const std::vector<double>>(std::move(numbers));
  return rows_view(owner, owner->data(), static_cast<py::ssize_t>(owner->size() / 3), 3);
}

py::array stress_tensor(const Mat3& tensor) {
  return rows_of_three({tensor.data(), tensor.data() + tensor.size()});  // symmetric
}

py::array von_mises_field(const Stress& stress, const std::string& load_case) {
  const std::vector<double>& field =
      *KernelCall()([&](const Progress&) { return &stress.von_mises(load_case); });
  return array_view(stress.shared_data(), field.data(), {static_cast<py::ssize_t>(field.size())},
                    {sizeof(double)});
}

py::array displacement_field(const Stress& stress, const std::string& load_case) {
  const std::vector<double>& field =
      *KernelCall()([&](const Progress&) { return &stress.displacement(load_case); });
  return rows_view(stress.shared_data(), field.data(), static_cast<py::ssize_t>(field.size() / 3),
                   3);
}

py::dict reactions_of(const StressCase& c) {
  py::dict reactions;
  for (const ShellReaction& r : c.reactions)
    reactions[py::str(r.support)] = py::make_tuple(stress_vector(r.force), stress_vector(r.moment));
  return reactions;
}

std::string stress_repr(const Stress& stress) {
  return "<batten.Stress of '" + stress.model().name() + "': von Mises " +
         format_number(stress.max_von_mises()) + " in case '" + stress.load_case().name +
         "', displacement " + format_number(stress.max_displacement()) + " " +
         stress.model().unit() + ">";
}

std::string case_repr(const StressCase& c) {
  return "<batten.StressCase '" + c.name + "': von Mises " + format_number(c.max_von_mises) +
         " on '" + c.stress_face + "', displacement " + format_number(c.max_displacement) +
         " on '" + c.displacement_face + "'>";
}

void bind_case(py::module_& m) {
  py::class_<StressCase> c(m, "StressCase",
                           "Results of a load case, or of a combination, named as in report.json.");
  const auto vector = [&](const char* name, Vec3 StressCase::*member, const char* words) {
    c.def_property_readonly(
        name, [member](const StressCase& of) { return stress_vector(of.*member); }, words);
  };
  vector("force", &StressCase::force, "Resultant force of all loads, array of 3.");
  vector("displacement", &StressCase::displacement,
         "Displacement vector at its maximum, array of 3.");
  vector("displacement_at", &StressCase::displacement_at,
         "Point of the largest displacement, array of 3.");
  vector("stress_at", &StressCase::stress_at,
         "Point of the middle surface with the largest stress, array of 3.");
  c.def_readonly("name", &StressCase::name)
      .def_readonly("combination", &StressCase::combination, "Whether it combines load cases.")
      .def_readonly("max_displacement", &StressCase::max_displacement,
                    "Largest displacement, model units.")
      .def_readonly("max_displacement_error", &StressCase::max_displacement_error,
                    "Estimated error of max_displacement.")
      .def_readonly("displacement_face", &StressCase::displacement_face)
      .def_readonly("max_von_mises", &StressCase::max_von_mises, "Largest von Mises stress.")
      .def_readonly("stress_face", &StressCase::stress_face)
      .def_readonly("stress_side", &StressCase::stress_side,
                    "'top', to which the normal points, or 'bottom'.")
      .def_readonly("stress_spread", &StressCase::stress_spread,
                    "Largest difference between max_von_mises and the stresses of the surrounding "
                    "elements.")
      .def_readonly("near_singularity", &StressCase::near_singularity,
                    "Whether the largest stress is next to a point load or point support.")
      .def_readonly("safety_factor", &StressCase::safety_factor,
                    "yield_stress / max_von_mises; 0: no yield stress.")
      .def_readonly("strain_energy", &StressCase::strain_energy)
      .def_readonly("error_estimate", &StressCase::error_estimate,
                    "Estimated relative error in the energy norm.")
      .def_readonly("equilibrium_residual", &StressCase::equilibrium_residual)
      .def_property_readonly(
          "buckling_factors", [](const StressCase& of) { return array_of(of.buckling_factors); },
          "Load factors at which the shell buckles, ascending, array.")
      .def_property_readonly("reactions", &reactions_of,
                             "{support: (force, moment about the origin)}, arrays of 3, on the "
                             "shell.")
      .def("__repr__", &case_repr);
}

void bind_stress_point(py::module_& m) {
  py::class_<StressPoint> c(m, "StressPoint", "Stresses and displacement at a point of a shell.");
  c.def_property_readonly(
       "position", [](const StressPoint& p) { return stress_vector(p.position); },
       "Point of the middle surface, array of 3, model units.")
      .def_property_readonly(
          "normal", [](const StressPoint& p) { return stress_vector(p.normal); },
          "Unit normal, which points to the top, array of 3.")
      .def_property_readonly(
          "displacement", [](const StressPoint& p) { return stress_vector(p.displacement); },
          "Array of 3, model units.")
      .def_readonly("face", &StressPoint::face)
      .def_readonly("distance", &StressPoint::distance, "Distance from the query point.")
      .def_readonly("von_mises_top", &StressPoint::von_mises_top)
      .def_readonly("von_mises_middle", &StressPoint::von_mises_middle)
      .def_readonly("von_mises_bottom", &StressPoint::von_mises_bottom)
      .def_property_readonly(
          "forces", [](const StressPoint& p) { return stress_tensor(p.forces); },
          "Membrane forces per length, symmetric 3×3 in space coordinates.")
      .def_property_readonly(
          "moments", [](const StressPoint& p) { return stress_tensor(p.moments); },
          "Bending moments per length, symmetric 3×3; positive: tension at the top.");
}

void bind_fields(py::class_<Stress>& c) {
  c.def(
       "at",
       [](const Stress& stress, const py::object& point, const std::string& load_case) {
         const Vec3 p = vector_from(point, "point");
         return KernelCall()([&](const Progress&) { return stress.at(p, load_case); });
       },
       "point"_a, py::kw_only(), "case"_a = "",
       "The StressPoint of the surface nearest to a point in space. `case`: name of a load case; "
       "default: the governing one.")
      .def("von_mises", &von_mises_field, py::kw_only(), "case"_a = "",
           "Larger von Mises stress of top and bottom at each of model.points, n float64. A view.")
      .def("displacement", &displacement_field, py::kw_only(), "case"_a = "",
           "Displacement at each of model.points, n×3 float64, model units. A view.")
      .def(
          "mode_shape",
          [](const Stress& stress, int index) {
            return rows_of_three(
                KernelCall()([&](const Progress&) { return stress.mode_shape(index); }));
          },
          "index"_a,
          "Mode shape of frequencies[index] at each of model.points, n×3; the largest displacement "
          "has length 1.")
      .def(
          "buckling_shape",
          [](const Stress& stress, int index, const std::string& load_case) {
            return rows_of_three(KernelCall()(
                [&](const Progress&) { return stress.buckling_shape(index, load_case); }));
          },
          "index"_a, py::kw_only(), "case"_a = "",
          "Mode shape of buckling_factors[index] at each of model.points, n×3; the largest "
          "displacement has length 1.");
}

}  // namespace

void bind_stress(py::module_& m) {
  bind_case(m);
  bind_stress_point(m);
  py::class_<Stress> c(m, "Stress",
                       R"(Stresses and displacements of a model as a thin shell. Immutable.

The unit of stresses follows from that of Young's modulus. Functions of a load case take its name;
the default is the governing one, with the largest von Mises stress.)");
  c.def_property_readonly("max_von_mises", &Stress::max_von_mises,
                          "Largest von Mises stress over all load cases.")
      .def_property_readonly("max_displacement", &Stress::max_displacement,
                             "Largest displacement over all load cases, model units.")
      .def_property_readonly("cases", &Stress::cases,
                             "A list of StressCase: the load cases, then their combinations.")
      .def("load_case", &Stress::load_case, "name"_a = "",
           "The StressCase of this name; default: the governing one.")
      .def_property_readonly(
          "frequencies", [](const Stress& stress) { return array_of(stress.frequencies()); },
          "Natural frequencies, ascending, 1/time, array; empty unless `modes` is given.")
      .def_property_readonly("warnings", &Stress::warnings, "Warnings, as sentences.")
      .def_property_readonly("failed_checks", &Stress::failed_checks,
                             "The failed checks, as sentences with the amount.")
      .def_property_readonly(
          "report", [](const Stress& stress) { return json_object(stress.report()); },
          "All results, as in the section \"stress\" of report.json.")
      .def_property_readonly("model", &Stress::model, "The model that was analysed.")
      .def_property_readonly("scene", &Stress::scene,
                             "The scene of the model with this [stress], as text; `batten stress` "
                             "gives the same results.")
      .def("__repr__", &stress_repr);
  bind_fields(c);
  m.def(
      "stress", &analyse, "source"_a, "out"_a = py::none(), py::kw_only(),
      "material"_a = py::none(), "thickness"_a = py::none(), "supports"_a = py::none(),
      "loads"_a = py::none(), "yield_stress"_a = py::none(), "modes"_a = 0, "buckling"_a = 0,
      "settings"_a = "", "values"_a = py::none(), "accuracy"_a = 0.0, "progress"_a = py::none(),
      R"(Analyses a Model as a linear thin shell, in memory; or runs `batten stress` of a scene file.

stress(model, …) returns a Stress. `material`: a name such as "steel", or {"young": …, "poisson": …,
"density": …}. `supports`: names of curves (clamped), or dicts such as {"curve": "rim", "type":
"pinned"}. `loads`: dicts such as {"pressure": 0.01} or {"force": [x, y, z], "point": [x, y, z]}. All
keys: docs/stress.md. `settings`: further keys of [stress] as TOML text. These arguments replace the
[stress] of the model; without them, its own [stress] is used. `modes`, `buckling`: numbers of
natural frequencies, and of buckling factors per load case. `values`: parameters of the model.

stress(path, out) writes the files of `batten stress` into a folder and returns the report.
`accuracy`: relative error of the displacements below which the mesh is refined; 0: no refinement.

Raises InputError, ConflictError for contradictory supports, NoSolutionError that names an
unconstrained motion. Reference: docs/theory/shells.md (Kirchhoff-Love theory).)");
}

}  // namespace batten::python
