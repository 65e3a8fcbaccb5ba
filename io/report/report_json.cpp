// SPDX-License-Identifier: MPL-2.0
#include "batten/io/report/report_json.h"

#include <cmath>

namespace batten {
namespace {

void replace_non_finite(Json& json, const std::string& path, std::vector<FailedCheck>& failed) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    const std::string text = std::isnan(json.get<double>()) ? "nan" : "inf";
    failed.push_back({path, "could not be computed (" + text + ")"});
    json = text;
  } else if (json.is_object()) {
    for (auto& [key, value] : json.items())
      replace_non_finite(value, path.empty() ? key : path + "." + key, failed);
  } else if (json.is_array()) {
    for (size_t i = 0; i < json.size(); ++i) {
      const bool named = json[i].is_object() && json[i].contains("name");
      const std::string name = named ? json[i]["name"].get<std::string>() : std::to_string(i);
      replace_non_finite(json[i], path + "." + name, failed);
    }
  }
}

}  // namespace

std::vector<FailedCheck> replace_non_finite_numbers(Json& json) {
  std::vector<FailedCheck> failed;
  replace_non_finite(json, "", failed);
  return failed;
}

Json report_header(const RunReport& report) {
  return {{"name", report.name}, {"unit", report.unit}};
}

void add_report_footer(Json& json, const RunReport& report) {
  json["timings_s"] = Json::object();
  for (const auto& [stage, seconds] : report.timings) json["timings_s"][stage] = seconds;
  json["files"] = report.files;
  json["warnings"] = report.warnings;
}

std::string report_text(Json json, const RunReport& report) {
  replace_non_finite_numbers(json);
  json["failed_checks"] = Json::array();
  for (const auto& m : report.failed_checks)
    json["failed_checks"].push_back({{"check", m.what}, {"detail", m.detail}});
  // Names come from files of any encoding: invalid UTF-8 is replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json json_of(const std::vector<Parameter>& parameters) {
  Json list = Json::array();
  for (const auto& p : parameters) {
    Json parameter = {{"name", p.name}, {"value", p.value}};
    if (std::isfinite(p.min)) parameter["min"] = p.min;
    if (std::isfinite(p.max)) parameter["max"] = p.max;
    list.push_back(parameter);
  }
  return list;
}

}  // namespace batten
