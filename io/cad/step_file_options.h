// What STEP files of surfaces say and hold beside the faces.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/cubic_splines.h"

namespace batten {

/// Names, schema and lines of a STEP file of surfaces.
struct StepFileOptions {
  std::string name = "surface";  ///< of the product
  std::string author = "";
  bool ap242 = false;  ///< AP242 instead of AP214
  /// Curves that the file holds beside the faces, by their names, in a product "lines" of their
  /// own: programs show it as wires that can be hidden. The faces are the same with them and
  /// without; programs that mesh all that a file holds mesh the curves too, without a node in
  /// common with the faces. None: no such product.
  std::vector<CubicSpline> lines = {};
};

}  // namespace batten
