// Functions that write the common parts of all reports as JSON. Internal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

using Json = nlohmann::ordered_json;

/// Replaces numbers that are not finite by the words "nan" and "inf", and returns their names.
std::vector<FailedCheck> replace_non_finite_numbers(Json& json);

/// The text of a report, with the promises it missed at its end.
std::string report_text(Json json, const RunReport& report);

/// The keys name and unit; timings_s, files and warnings.
Json report_header(const RunReport& report);
void add_report_footer(Json& json, const RunReport& report);

inline Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
/// A list with the name and value of each parameter, and its range where it has one.
Json json_of(const std::vector<Parameter>& parameters);
Json json_of(const Fairness& fairness);
/// The section "curves" of a report.
Json json_of(const std::vector<FairedLine>& curves);

}  // namespace batten
