// report.json of faired curves: measured on the curves that are written.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/io/report/faired_line.h"
#include "batten/io/report/report.h"

namespace batten {

struct FairReport {
  std::string name, unit;
  std::vector<FairedLine> curves;
  std::vector<Parameter> parameters;
  std::vector<std::pair<std::string, double>> timings;  ///< seconds
  std::vector<std::string> warnings, files;
  std::vector<MissedPromise> missed;
};

/// Conditions that hold by more than 1e-12 of the size, and numbers that are not finite.
std::vector<MissedPromise> broken_promises(const FairReport& report);
/// The conditions alone.
std::vector<MissedPromise> broken_conditions(const std::vector<FairedLine>& curves);

/// JSON text; numbers that are not finite become the words "nan" and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
