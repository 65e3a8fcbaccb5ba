// Functions that write the common parts of all reports as JSON. Internal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/io/report/faired_line.h"
#include "batten/io/report/missed_promise.h"
#include "batten/io/scene/scene.h"

namespace batten {

using Json = nlohmann::ordered_json;

/// Replaces numbers that are not finite by the words "nan" and "inf", and adds them to `failed` by
/// their names. `path`: the name of `json` itself, "" for the whole report.
void name_failed_numbers(Json& json, const std::string& path, std::vector<MissedPromise>& failed);

/// The text of a report, with the promises it missed at its end.
std::string report_text(Json json, const std::vector<MissedPromise>& missed);

/// Adds the keys timings_s, files and warnings of any kind of report.
template <class AnyReport>
void add_ending(Json& json, const AnyReport& report) {
  json["timings_s"] = Json::object();
  for (const auto& [stage, seconds] : report.timings) json["timings_s"][stage] = seconds;
  json["files"] = report.files;
  json["warnings"] = report.warnings;
}

/// A list with the name and value of each parameter, and its range where it has one.
Json json_of(const std::vector<Parameter>& parameters);
Json json_of(const Fairness& fairness);
/// The section "curves" of a report.
Json json_of(const std::vector<FairedLine>& curves);

}  // namespace batten
