// SPDX-License-Identifier: MPL-2.0
// Curves of OpenCASCADE as input curves.
#pragma once

#include <Geom_Curve.hxx>
#include <memory>

#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// The part of an OpenCASCADE curve between two parameters, as read_cad_lines() describes it.
/// `scale`: converts lengths of the curve to model units.
std::shared_ptr<const InputCurve> cad_curve(Handle(Geom_Curve) curve, double start, double end,
                                            double scale);

/// Factor from millimetres to model units. Throws InputError if the unit is not positive.
double millimetres_in(double model_unit_in_metres);

}  // namespace batten
