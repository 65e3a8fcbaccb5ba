// SPDX-License-Identifier: MPL-2.0
// Binds stress analyses: of models in memory, and of scene files.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/stress_settings.h"
#include "batten/apps/python/toml_values.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/stress_data.h"

namespace batten::python {
namespace {

using namespace py::literals;

// Settings as TOML text.

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
  const std::vector<std::string> known = {
      "young",    "poisson", "density", "shear_modulus", "material_direction", "expansion",
      "strength", "plies",   "layup",   "ply_thickness", "materials",          "reference_surface"};
  for (const auto& [name, value] : material.cast<py::dict>()) {
    const std::string key = toml_key(name, "material");
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError("material: found the key '" + key + "', expected " +
                       expected_one_of(key, known));
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
                   const std::string& settings, const py::object& values,
                   std::optional<double> accuracy, const py::object& progress) {
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
  detail::StressTable table = stress_table_from(material, thickness, supports, loads, yield_stress,
                                                modes, buckling, settings);
  table.accuracy = accuracy.value_or(0);
  const auto numbers = values_from(values);
  auto model = source.cast<Model>();
  return py::cast(KernelCall(progress)([&](const Progress& hook) {
    if (!numbers.empty()) model = model.with_values({numbers.begin(), numbers.end()}, hook);
    return detail::stress_of_table(model, table, hook);
  }));
}

}  // namespace

detail::StressTable stress_table_from(const py::object& material, const py::object& thickness,
                                      const py::object& supports, const py::object& loads,
                                      const py::object& yield_stress, int modes, int buckling,
                                      const std::string& settings) {
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
  return table;
}

// Results.

namespace {

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

py::array von_mises_of(const Stress& stress, const std::string& load_case,
                       const std::string& side) {
  if (side.empty()) return von_mises_field(stress, load_case);
  return array_of(KernelCall()([&](const Progress&) { return stress.von_mises(load_case, side); }));
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

std::string stress_point_repr(const StressPoint& p) {
  return "<batten.StressPoint " + format_point(p.position) + " of '" + p.face + "': von Mises " +
         format_number(p.von_mises_top) + " at the top, " + format_number(p.von_mises_middle) +
         " in the middle, " + format_number(p.von_mises_bottom) + " at the bottom>";
}

void bind_case(py::module_& m) {
  py::class_<StressCase> c(
      m, "StressCase",
      R"(Results of a load case, or of a combination, named as in report.json: Stress.load_case().

    >>> case = stress.load_case("loads")
    >>> case.max_von_mises == stress.max_von_mises
    True
    >>> sorted(case.reactions)
    ['clamped back', 'clamped front'])");
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
  c.def_readonly("name", &StressCase::name, "Name of the load case.")
      .def_readonly("combination", &StressCase::combination, "Whether it combines load cases.")
      .def_readonly("max_displacement", &StressCase::max_displacement,
                    "Largest displacement, model units.")
      .def_readonly("max_displacement_error", &StressCase::max_displacement_error,
                    "Estimated error of max_displacement.")
      .def_readonly("displacement_face", &StressCase::displacement_face,
                    "Face with the largest displacement.")
      .def_readonly("max_von_mises", &StressCase::max_von_mises, "Largest von Mises stress.")
      .def_readonly("stress_face", &StressCase::stress_face, "Face with the largest stress.")
      .def_readonly("stress_side", &StressCase::stress_side,
                    "'top', to which the normal points, or 'bottom'.")
      .def_readonly("stress_spread", &StressCase::stress_spread,
                    "Largest difference between max_von_mises and the stresses of the surrounding "
                    "elements.")
      .def_readonly("near_singularity", &StressCase::near_singularity,
                    "Whether the largest stress is next to a point load or point support.")
      .def_property_readonly(
          "singular_places",
          [](const StressCase& of) {
            py::list places;
            for (const StressSingularity& place : of.singular_places)
              places.append(py::make_tuple(stress_vector(place.at), place.radius));
            return places;
          },
          "[(point, radius)]: places where the stress grows without limit as the elements become "
          "smaller; max_von_mises is the largest stress outside of these radii. Found if "
          "`accuracy` "
          "is given.")
      .def_readonly("stress_ply", &StressCase::stress_ply,
                    "Ply of a laminate with the largest stress, from 1, from the bottom; 0: none.")
      .def_readonly("reserve_factors", &StressCase::reserve_factors,
                    "{criterion: smallest factor by which the stress of a ply can grow until it "
                    "fails}, 'Tsai-Hill' and 'Hoffman', if the material has strengths.")
      .def_readonly("safety_factor", &StressCase::safety_factor,
                    "yield_stress / max_von_mises; 0: no yield stress.")
      .def_readonly("strain_energy", &StressCase::strain_energy, "Strain energy, force · length.")
      .def_readonly("error_estimate", &StressCase::error_estimate,
                    "Estimated relative error in the energy norm.")
      .def_readonly("equilibrium_residual", &StressCase::equilibrium_residual,
                    "Sum of the forces of loads and supports, relative to the sum of their "
                    "magnitudes, or the same for their moments, whichever is larger.")
      .def_property_readonly(
          "buckling_factors", [](const StressCase& of) { return array_of(of.buckling_factors); },
          "Load factors at which the shell buckles, ascending, array.")
      .def_property_readonly("reactions", &reactions_of,
                             "{support: (force, moment about the origin)}, arrays of 3, on the "
                             "shell.")
      .def("__repr__", &case_repr);
}

void bind_stress_point(py::module_& m) {
  py::class_<StressPoint> c(m, "StressPoint",
                            R"(Stresses and displacement at a point of a shell: Stress.at().

    >>> p = stress.at([50, 50, 20])
    >>> p.displacement.shape, p.moments.shape
    ((3,), (3, 3)))");
  c.def_property_readonly(
       "position", [](const StressPoint& p) { return stress_vector(p.position); },
       "Point of the middle surface, array of 3, model units.")
      .def_property_readonly(
          "normal", [](const StressPoint& p) { return stress_vector(p.normal); },
          "Unit normal, which points to the top, array of 3.")
      .def_property_readonly(
          "displacement", [](const StressPoint& p) { return stress_vector(p.displacement); },
          "Array of 3, model units.")
      .def_readonly("face", &StressPoint::face, "Name of the face.")
      .def_readonly("distance", &StressPoint::distance, "Distance from the query point.")
      .def_readonly("von_mises_top", &StressPoint::von_mises_top,
                    "Von Mises stress on the side to which the normal points.")
      .def_readonly("von_mises_middle", &StressPoint::von_mises_middle,
                    "Von Mises stress of the middle surface.")
      .def_readonly("von_mises_bottom", &StressPoint::von_mises_bottom,
                    "Von Mises stress on the other side.")
      .def_property_readonly(
          "forces", [](const StressPoint& p) { return stress_tensor(p.forces); },
          "Membrane forces per length, symmetric 3×3 in space coordinates.")
      .def_property_readonly(
          "moments", [](const StressPoint& p) { return stress_tensor(p.moments); },
          "Bending moments per length, symmetric 3×3; positive: tension at the top.")
      .def_property_readonly(
          "ply_stresses",
          [](const StressPoint& p) {
            std::vector<double> numbers;
            for (const Vec3& stress : p.ply_stresses)
              numbers.insert(numbers.end(), stress.begin(), stress.end());
            return rows_of_three(std::move(numbers));
          },
          "Stresses σ1, σ2, τ12 at the bottom and top of each ply, from the bottom, in the "
          "directions of its material: two rows per ply.")
      .def("__repr__", &stress_point_repr);
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
      .def("von_mises", &von_mises_of, py::kw_only(), "case"_a = "", "side"_a = "",
           R"(Von Mises stress at each of model.points, n float64: the larger one of top and bottom.

`side`: "top", "middle" or "bottom" for that of one side. Raises InputError.

    >>> stress.von_mises(side="middle").max() <= stress.von_mises().max()
    True)")
      .def_property_readonly(
          "thickness",
          [](const Stress& stress) {
            return array_of(KernelCall()([&](const Progress&) { return stress.thickness(); }));
          },
          "Thickness of the shell at each of model.points, n float64, model units.")
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
the default is the governing one, with the largest von Mises stress.

    >>> stress.failed_checks
    []
    >>> stress.von_mises().shape == (len(stress.model.points),)
    True
    >>> stress.displacement().shape == stress.model.points.shape
    True)");
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
      .def(
          "gradients",
          [](const Stress& stress, double exponent, const std::string& load_case,
             const py::object& progress) {
            return KernelCall(progress)(
                [&](const Progress& hook) { return stress.gradients(exponent, load_case, hook); });
          },
          py::kw_only(), "norm_exponent"_a = 8.0, "case"_a = "", "progress"_a = py::none(),
          R"(Largest displacement, compliance, P-norm of the von Mises stress and mass, with their
derivatives with respect to the parameters of the model: StressGradients.

`norm_exponent`: P of the norm (1/(2A) ∬ (σ_top^P + σ_bottom^P) dA)^(1/P), from 2 to 100.
`case`: name of a load case; default: the governing one. Adjoint method; costs one analysis, the
derivatives of the shape, and two stiffness matrices per parameter. Raises InputError.)")
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
      "settings"_a = "", "values"_a = py::none(), "accuracy"_a = py::none(),
      "progress"_a = py::none(),
      R"(Analyses a Model as a linear thin shell, in memory; or runs `batten stress` of a scene file.

stress(model, …) returns a Stress. `material`: a name such as "steel", or the keys of a material,
{"young": …, "poisson": …, "density": …}, or of a laminate, {"young": [E1, E2], "shear_modulus": …,
"material_direction": [x, y, z], "layup": "[0/±45/90]s", "ply_thickness": …}. `supports`: names of curves (clamped), or dicts such as {"curve": "rim", "type":
"pinned"}. `loads`: dicts such as {"pressure": 0.01}, {"pressure": "0.01 * x"} (a formula) or
{"force": [x, y, z], "point": [x, y, z]} or {"temperature": 80}. All keys: docs/stress.md. `settings`: further keys of
[stress] as TOML text. These arguments replace the [stress] of the model; without them, its own
[stress] is used. `modes`, `buckling`: numbers of natural frequencies, and of buckling factors per
load case. `values`: parameters of the model.

stress(path, out) writes the files of `batten stress` into a folder and returns the report.

`accuracy`: estimated relative error of the displacements and of the largest stresses down to which
the elements are refined, on the same surface; Stress.model is the model on these elements. 0: no
refinement. None: the elements of the model, with a warning if stresses are uncertain on them; of a
file, the default of the command.

Raises InputError, ConflictError for contradictory supports, NoSolutionError that names an
unconstrained motion. Reference: docs/theory/shells.md (Kirchhoff-Love theory).)");
}

}  // namespace batten::python
