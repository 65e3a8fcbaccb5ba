// report.json of faired curves: measured on the curves that are written.
#pragma once

#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

/// What `batten fair` did.
struct FairReport : RunReport {
  std::vector<FairedLine> curves;
};

/// The promises that the report's own numbers break: those of failed_fairing_checks(), and numbers that
/// are not finite.
std::vector<FailedCheck> failed_checks(const FairReport& report);
/// Deviations that a stage states and does not keep, and conditions with a residual above 1e-12 of
/// the line's size.
std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves);

/// The report as JSON text. Numbers that are not finite become the words "nan" and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
