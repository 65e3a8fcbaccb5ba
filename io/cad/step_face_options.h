// Options of fitted faces in STEP files.
#pragma once

#include "batten/io/cad/step_file_options.h"

namespace batten {

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
