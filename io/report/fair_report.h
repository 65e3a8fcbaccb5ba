// report.json of faired curves: measured on the curves that are written.
#pragma once

#include <string>
#include <vector>

#include "batten/io/report/report_parts.h"

namespace batten {

struct FairReport : RunReport {
  std::vector<FairedLine> curves;
};

/// Conditions that hold by more than 1e-12 of the size, and numbers that are not finite.
std::vector<MissedPromise> broken_promises(const FairReport& report);
/// The conditions alone.
std::vector<MissedPromise> broken_conditions(const std::vector<FairedLine>& curves);

/// JSON text; numbers that are not finite become the words "nan" and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
