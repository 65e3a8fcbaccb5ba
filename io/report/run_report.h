// Members that the reports of all commands have in common.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/staged_fairing.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// A check of a result that failed: a measured number violates its tolerance.
struct FailedCheck {
  std::string what;  ///< JSON path of the number, for example "surface.min_jacobian_ratio"
  /// Value found and value expected, for example "is 0.01, expected at least 0.05".
  std::string detail;
};

/// Base class of the reports of all commands.
struct RunReport {
  std::string name, unit;
  std::vector<Parameter> parameters;
  /// Name and duration (seconds) of each phase of the run.
  std::vector<std::pair<std::string, double>> timings;
  std::vector<std::string> warnings, files;
  std::vector<FailedCheck> failed_checks;
};

}  // namespace batten
