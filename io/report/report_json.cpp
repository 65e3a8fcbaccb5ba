#include "batten/io/report/report_json.h"

#include <cmath>

namespace batten {

void name_failed_numbers(Json& json, const std::string& path, std::vector<MissedPromise>& failed) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    const std::string word = std::isnan(json.get<double>()) ? "nan" : "inf";
    failed.push_back({path, "could not be computed (" + word + ")"});
    json = word;
  } else if (json.is_object()) {
    for (auto& [key, value] : json.items())
      name_failed_numbers(value, path.empty() ? key : path + "." + key, failed);
  } else if (json.is_array()) {
    for (size_t i = 0; i < json.size(); ++i) {
      const bool named = json[i].is_object() && json[i].contains("name");
      const std::string name = named ? json[i]["name"].get<std::string>() : std::to_string(i);
      name_failed_numbers(json[i], path + "." + name, failed);
    }
  }
}

std::string report_text(Json json, const std::vector<MissedPromise>& missed) {
  std::vector<MissedPromise> failed;
  name_failed_numbers(json, "", failed);
  json["missed_promises"] = Json::array();
  for (const auto& m : missed)
    json["missed_promises"].push_back({{"what", m.what}, {"detail", m.detail}});
  // Names come from files of any encoding: what is not UTF-8 is replaced.
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
