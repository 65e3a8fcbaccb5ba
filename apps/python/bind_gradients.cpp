// SPDX-License-Identifier: MPL-2.0
// Binds quantities with their derivatives with respect to the parameters of a model.
#include "batten/apps/python/bindings.h"
#include "batten/apps/python/conversions.h"
#include "batten/core/errors.h"
#include "batten/scenes/gradients.h"

namespace batten::python {

void bind_gradients(py::module_& m) {
  py::class_<ValueWithGradient>(m, "ValueWithGradient", R"(A quantity and its derivatives.

    >>> gradients = model.gradients()
    >>> gradients.area.value == model.area
    True
    >>> gradients.area.gradient.keys() <= model.parameters.keys()
    True)")
      .def_readonly("value", &ValueWithGradient::value, "The quantity.")
      .def_property_readonly(
          "gradient", [](const ValueWithGradient& of) { return of.gradient; },
          "Derivative with respect to each parameter, {name: number}: all parameters except driven "
          "ones and those of [[fair]], which change the mesh.")
      .def("__repr__", [](const ValueWithGradient& of) {
        return "<batten.ValueWithGradient " + format_number(of.value) + ", " +
               std::to_string(of.gradient.size()) + " derivatives>";
      });
  py::class_<ModelGradients>(m, "ModelGradients", R"(Result of Model.gradients().

    >>> model.gradients().volume is None  # an open surface
    True)")
      .def_readonly("area", &ModelGradients::area, "Total area of all faces, model units².")
      .def_readonly("volume", &ModelGradients::volume,
                    "Enclosed volume, model units³; None if the surface is open.");
  py::class_<LoadEffect>(m, "LoadEffect",
                         R"(Effect of a load, a curve offset or a slider on the shape.

    >>> effect = batten.load("examples/06-goblet-bowl/scene.toml").load_effects()["swell"]
    >>> effect.displacement > 0 and effect.visible > 0
    True)")
      .def_readonly("displacement", &LoadEffect::displacement,
                    "Largest displacement of the surface per unit of the parameter, model units.")
      .def_property_readonly(
          "at", [](const LoadEffect& of) { return array_of(of.at); }, "Where it is.")
      .def_readonly("face", &LoadEffect::face, "Name of the face that contains that point.")
      .def_readonly("visible", &LoadEffect::visible,
                    "The change of the parameter that displaces the surface by about 1 % of its "
                    "size; 0: it has no effect.");
  py::class_<StressGradients>(m, "StressGradients",
                              R"(Result of Stress.gradients(), for one load case.

    >>> gradients = stress.gradients(norm_exponent=8)
    >>> gradients.mass.value > 0
    True
    >>> gradients.von_mises_norm.value > 0
    True
    >>> gradients.max_displacement.gradient.keys() == model.gradients().area.gradient.keys()
    True)")
      .def_readonly("max_displacement", &StressGradients::max_displacement,
                    "Displacement of the point with the largest one, along its direction.")
      .def_readonly("compliance", &StressGradients::compliance, "Work of the loads, Fᵀu.")
      .def_readonly("von_mises_norm", &StressGradients::von_mises_norm,
                    "P-norm of the von Mises stress over both sides, a smooth measure of the "
                    "largest stress.")
      .def_readonly("mass", &StressGradients::mass, "Mass of the shell; 0: no density.");
}

}  // namespace batten::python
