// SPDX-License-Identifier: MPL-2.0
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

/// Failed checks as sentences: "surface.min_jacobian_ratio: is 0.01, expected at least 0.05".
inline std::vector<std::string> sentences(const std::vector<FailedCheck>& checks) {
  std::vector<std::string> all;
  for (const FailedCheck& check : checks) all.push_back(check.what + ": " + check.detail);
  return all;
}
/// The same sentences as one text, each followed by the end of a line.
inline std::string sentence_lines(const std::vector<FailedCheck>& checks) {
  std::string text;
  for (const std::string& sentence : sentences(checks)) text += sentence + "\n";
  return text;
}

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
