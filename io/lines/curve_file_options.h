// Options of curve files for CAD.
#pragma once

namespace batten {

/// What STEP and IGES files of curves declare; other files have no place for it.
struct CurveFileOptions {
  double unit_in_metres = 1e-3;  ///< the model's unit, which the file declares
  bool ap242 = false;            ///< of STEP, instead of AP214
};

}  // namespace batten
