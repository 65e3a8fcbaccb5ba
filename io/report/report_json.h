// SPDX-License-Identifier: MPL-2.0
// JSON output of the parts that all reports share.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

using Json = nlohmann::ordered_json;

/// Replaces numbers that are not finite by the strings "nan" and "inf". The result lists their JSON
/// paths.
std::vector<FailedCheck> replace_non_finite_numbers(Json& json);

/// The text of a report, with its failed checks at the end.
std::string report_text(Json json, const RunReport& report);

/// Writes the leading keys of a report: name, unit.
Json report_header(const RunReport& report);
/// Appends the closing keys of a report: timings_s, files, warnings.
void add_report_footer(Json& json, const RunReport& report);

/// A point as a JSON array [x, y, z].
inline Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
/// A list with the name, value and (if finite) range of each parameter.
Json json_of(const std::vector<Parameter>& parameters);
/// Curve fairness measures as a JSON object.
Json json_of(const Fairness& fairness);
/// The section "faired_curves" of a report.
Json json_of(const std::vector<FairedLine>& curves);

}  // namespace batten
