#include "batten/io/files/text.h"

#include <cctype>
#include <cmath>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"

namespace batten {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

std::string format_count(long count, const std::string& noun, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? noun : many.empty() ? noun + "s" : many);
}

namespace {

const std::vector<std::pair<std::string, double>> kUnits = {
    {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};

}  // namespace

const std::vector<std::string>& length_units() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& unit : kUnits) list.push_back(unit.first);
    return list;
  }();
  return names;
}

double unit_in_metres(const std::string& unit) {
  for (const auto& [name, metres] : kUnits)
    if (name == unit) return metres;
  throw InputError("found the unit '" + unit + "', expected " +
                   expected_one_of(unit, length_units()));
}

std::string format_unit(double unit_in_metres) {
  static constexpr std::pair<const char*, double> units[] = {
      {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1},         {"in", 0.0254},   {"ft", 0.3048},
      {"um", 1e-6}, {"km", 1e3},  {"mi", 1609.344}, {"mil", 2.54e-5}, {"uin", 2.54e-8}};
  for (const auto& [name, metres] : units)
    if (std::abs(unit_in_metres - metres) <= 1e-9 * metres) return name;
  return format_number(unit_in_metres) + " m";
}

}  // namespace batten
