// The parts that the reports of all commands have in common.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/staged_fairing.h"
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

}  // namespace batten
