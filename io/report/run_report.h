// What the reports of several commands have in common.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// A promise that a result does not keep.
struct FailedCheck {
  std::string what;    ///< name of the number in the report: "surface.min_jacobian_ratio"
  std::string detail;  ///< how it is broken: "is 0.01, promised at least 0.05"
};

/// What every report says.
struct RunReport {
  std::string name, unit;
  std::vector<Parameter> parameters;
  std::vector<std::pair<std::string, double>> timings;  ///< seconds
  std::vector<std::string> warnings, files;
  std::vector<FailedCheck> failed_checks;
};

/// A faired line, measured on the curve that is written. Lengths are in model units.
struct FairedLine {
  std::string name;
  int points = 0, segments = 0;  ///< points of the input (of CAD curves: samples); segments of the
                                 ///< result
  bool closed = false;
  bool faired = false;  ///< false: no stage acted on it, or it cannot be faired
  double size = 0;      ///< diagonal of the box around the points
  Deviation deviation;  ///< deviation of the result from the input, less outliers
  double wavelength = 0, effective_dofs = 0;  ///< FairCurve's, of the last stage of the whole line
  double noise = 0;                           ///< FairCurve's, of the first stage of the whole line
  std::vector<int> outliers;  ///< likewise: points of the input that were passed over
  int rounds = 0;
  bool converged = true;
  double max_residual = 0;  ///< largest residual of the conditions, over the size
  /// A deviation that a stage stated and did not keep: the stated one, and the one reached.
  std::optional<std::pair<double, double>> exceeded_deviation;
  std::optional<Fairness> before, after;  ///< none for a line without length
  double seconds = 0;
};

}  // namespace batten
