// Options of fitted faces in STEP files.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

// What STEP files of surfaces say and hold beside the faces.

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


/// How near a fitted face must be to its surface, and how large it may become.
struct StepFaceOptions {
  double tolerance = 0;  ///< largest distance from the surface, model units; above 0
  /// Largest angle between neighbouring faces where their surfaces are tangent, degrees; above 0.
  double join_deg = 0.1;
  StepFileOptions file = {};
  /// Whether regions that are planes, cylinders, spheres, cones or tori within the tolerance are written as these.
  bool analytic = true;
  int max_poles = 400;           ///< most poles in one direction, 16 or more
  int max_poles_total = 60'000;  ///< most poles of one face, 256 or more; 60,000 are about 6 MB
  /// Most poles of a face for each triangle of its surface, beyond 2,000 in all. A surface that
  /// splines follow needs about one, few need more than five; a flawed one would take them all.
  int max_poles_per_triangle = 20;
};

}  // namespace batten
