// Options for writing STEP files of surfaces and of fitted faces.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

// Header data and additional contents of STEP files.

/// Names, schema and curves of a STEP file of surfaces.
struct StepFileOptions {
  std::string name = "surface";  ///< product name
  std::string author = "";
  bool ap242 = false;  ///< AP242 instead of AP214
  /// Named curves to write in addition to the faces, in a separate product "curves". CAD programs
  /// show them as wires that can be hidden. The faces do not depend on them. Programs that mesh the
  /// whole file mesh these curves too, without common nodes with the faces. Empty: no such product.
  std::vector<CubicSpline> lines = {};
};

/// Accuracy and size limits of fitted faces.
struct StepFaceOptions {
  double tolerance = 0;  ///< largest distance from the surface, model units; above 0
  /// Largest angle between adjacent faces along joins where their surfaces are tangent, degrees;
  /// above 0.
  double join_deg = 0.1;
  StepFileOptions file = {};
  /// Write faces that are planes, cylinders, spheres, cones or tori within the tolerance as
  /// analytic faces.
  bool analytic = true;
  int max_poles = 400;  ///< maximum number of poles in one direction, 16 or more
  /// Maximum number of poles of a face, 256 or more; 60,000 are about 6 MB.
  int max_poles_total = 60'000;
  /// Maximum number of poles of a face per triangle of its surface; 6,000 poles are always allowed.
  /// A surface that splines can follow needs about one per triangle, seldom more than five. A
  /// defective surface would use up any limit.
  int max_poles_per_triangle = 20;
};

}  // namespace batten
