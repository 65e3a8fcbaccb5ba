// The parts that the reports of all commands have in common.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// A violated acceptance check of a result.
struct FailedCheck {
  std::string what;    ///< JSON path of the number: "surface.min_jacobian_ratio"
  std::string detail;  ///< violation as text: "is 0.01, expected at least 0.05"
};

/// Base of all reports.
struct RunReport {
  std::string name, unit;
  std::vector<Parameter> parameters;
  std::vector<std::pair<std::string, double>> timings;  ///< seconds
  std::vector<std::string> warnings, files;
  std::vector<FailedCheck> failed_checks;
};

/// A faired curve, measured on the curve that is written. Lengths are in model units.
struct FairedLine {
  std::string name;
  int points = 0, segments = 0;  ///< input points (for CAD curves: samples); segments of the result
  bool closed = false;
  bool faired = false;  ///< false: no stage applied to it, or it cannot be faired
  double size = 0;      ///< diagonal of the bounding box of the points
  Deviation deviation;  ///< distance of the result from the input, without outliers
  double wavelength = 0, effective_dofs = 0;  ///< from FairCurve, for the last stage of the whole
                                              ///< curve
  double noise = 0;                           ///< from FairCurve, for the first stage of the whole
                                              ///< curve
  std::vector<int> outliers;                  ///< likewise: ignored input points
  int rounds = 0;
  bool converged = true;
  double max_residual = 0;  ///< largest residual of the conditions, relative to the size
  /// Set if a stage exceeded its requested deviation: the requested and the reached value.
  std::optional<std::pair<double, double>> exceeded_deviation;
  std::optional<Fairness> before, after;  ///< empty for a curve without length
  double seconds = 0;
};

}  // namespace batten
