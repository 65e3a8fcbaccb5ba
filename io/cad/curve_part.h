// Curves as a part of a CAD document. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/cubic_splines.h"
#include "batten/io/cad/cad_parts.h"

namespace batten {

/// A part of edges without faces: one for each spline, in their order and by their names, closed
/// ones with one vertex. STEP has it as a product with a set of curves, which programs show as
/// wires.
CadPart part_of_curves(const std::string& name, const std::vector<CubicSpline>& splines);

}  // namespace batten
