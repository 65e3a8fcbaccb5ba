// What all reports share as JSON. Internal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/io/report/report_parts.h"

namespace batten {

using Json = nlohmann::ordered_json;

/// Replaces numbers that are not finite by words and returns their names.
std::vector<MissedPromise> name_failed_numbers(Json& json);

/// The text of a report, with the promises it missed at its end.
std::string report_text(Json json, const RunReport& report);

/// name and unit; timings_s, files, warnings.
Json beginning_of(const RunReport& report);
void add_ending(Json& json, const RunReport& report);

inline Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
/// "name", "value", and the range where there is one.
Json json_of(const std::vector<Parameter>& parameters);
Json json_of(const Fairness& fairness);
/// The section "curves".
Json json_of(const std::vector<FairedLine>& curves);

}  // namespace batten
