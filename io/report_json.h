// What all reports share as JSON. Internal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/io/report.h"

namespace batten {

using Json = nlohmann::ordered_json;

/// Replaces numbers that are not finite by words and collects their names.
void name_failed_numbers(Json& json, const std::string& path, std::vector<MissedPromise>& failed);

/// The text of a report, with the promises it missed at its end.
std::string report_text(Json json, const std::vector<MissedPromise>& missed);

/// "name", "value", and the range where there is one.
Json json_of(const std::vector<Parameter>& parameters);

}  // namespace batten
