#include "batten/io/files/length_units.h"

#include <utility>

#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

const std::vector<std::pair<std::string, double>> kUnits = {
    {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};

}  // namespace

const std::vector<std::string>& length_units() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> list;
    for (const auto& unit : kUnits) list.push_back(unit.first);
    return list;
  }();
  return words;
}

double unit_in_metres(const std::string& unit) {
  for (const auto& [word, metres] : kUnits)
    if (word == unit) return metres;
  throw InputError("found the unit '" + unit + "', expected " + one_of(unit, length_units()));
}

}  // namespace batten
