// A curve through given points, such as the vertices of a mesh, that is faired and shaped by loads.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/sculpting/curves/deformable_curve.h"

namespace batten {

/// Options of sculpt_curve().
struct SculptedCurveOptions {
  /// Support of the ends of an open curve against the loads.
  enum class Ends {
    Clamped,  ///< position and tangent are fixed
    Pinned,   ///< the position is fixed
    Free      ///< no constraints; springs must support the curve
  };
  bool closed = false;
  bool faired = true;  ///< false: the curve interpolates the points before the loads act
  /// Fairing options; `closed`, `fix_ends` and `reject_outliers` are ignored: ends of open curves
  /// stay, and no point is an outlier.
  FairOptions fair;
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;    ///< stretch and bending stiffness, LoadUnits::Relative
  std::vector<CurveLoad> loads;  ///< empty: the curve is only faired
};

/// A faired curve under its loads. Lengths are in the unit of the points.
struct SculptedCurve {
  HermiteCurve curve;
  std::vector<Vec3>
      /// Position of each point on the curve: the point of the faired curve that is closest to it,
      /// moved by the loads.
      targets;
  Deviation fairing;         ///< deviation of the points from the curve without loads
  double wavelength = 0;     ///< fairing wavelength
  double largest_shift = 0;  ///< largest displacement of a target by the loads
  Fairness before, after;    ///< fairness of the interpolating spline, and of `curve`
};

/// Fairs the curve through some points (fair_points()) and lets loads deform it (DeformableCurve).
/// With `targets` as constraints of the vertices that gave the points, the curve drives a mesh (see
/// position_constraints() in mesh/deform/deform_problem.h).
///
/// `points`: in their order along the curve; a closed one does not repeat the first point. `name`
/// appears in messages. Throws InputError (too few points, invalid options or loads), ConflictError,
/// and NoSolutionError if neither ends nor springs support the curve.
SculptedCurve sculpt_curve(const std::string& name, const std::vector<Vec3>& points,
                           const SculptedCurveOptions& options = {});

}  // namespace batten
