#include "batten/io/scene/scene_parsing.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <locale>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/nesting.h"

namespace batten {

const std::vector<std::string>& skin_keys() {
  static const std::vector<std::string> keys = {
      "element",        "domain",       "settle",         "mesher",       "edge_length",
      "refine",         "alpha",        "beta",           "units",        "hold",
      "fair",           "sections",     "strength",       "largest_move", "gap_tolerance",
      "straight_angle", "crease_angle", "join_tolerance", "most_at_line", "trembling",
      "symmetry"};
  return keys;
}
const std::vector<std::string>& output_keys() {
  static const std::vector<std::string> keys = {
      "step", "step_form", "step_tolerance", "step_lines", "step_schema", "vtu", "vtp", "calculix"};
  return keys;
}

std::string read_unit(const TomlTable& table, const std::string& key) {
  const std::string word = table.text(key);
  if (std::find(length_units().begin(), length_units().end(), word) == length_units().end())
    table.fail(key, "the unit '" + word + "'", expected_one_of(word, length_units()));
  return word;
}

std::string output_file(const TomlTable& table, const std::string& key, UniqueNames& files,
                        const std::vector<std::string>& endings) {
  const std::filesystem::path name = table.text(key);
  if (name.is_absolute() || name.has_parent_path())
    table.fail(key, "'" + name.string() + "'", "a file name without folders (files go to --out)");
  if (std::find(endings.begin(), endings.end(), name.extension()) == endings.end())
    table.fail(key, "'" + name.string() + "'",
               "a file name that ends in " + comma_separated(endings));
  files.add(table, key, name.string());
  return name.string();
}

void read_view(const TomlTable& table, double& azimuth, double& elevation, PictureSize& size) {
  if (table.has("view")) {
    const VecX view = table.numbers("view", "azimuth, elevation");
    if (std::abs(view[1]) > 90)
      table.fail("view", "elevation " + format_number(view[1]), "-90 to 90 degrees");
    azimuth = view[0];
    elevation = view[1];
  }
  if (table.has("size")) {
    const VecX pixels = table.numbers("size", "width, height");
    if (pixels.minCoeff() < 64 || pixels.maxCoeff() > 4096)
      table.fail("size", format_number(pixels[0]) + " by " + format_number(pixels[1]),
                 "64 to 4096 pixels each");
    size = {static_cast<int>(pixels[0]), static_cast<int>(pixels[1])};
  }
}

std::string format_range(double min, double max) {
  if (min > -kInfinity && max < kInfinity)
    return "from " + format_number(min) + " to " + format_number(max);
  if (min > -kInfinity) return "from " + format_number(min) + " up";
  return "up to " + format_number(max);
}

toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       const std::string& expected) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(format_location(file.string(), {1, 1}) + "found an empty file, expected " +
                     expected);
  check_nesting_depth(text, file.string());
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& e) {
    const auto begin = e.source().begin;
    throw InputError(format_location(file.string(), {static_cast<int>(begin.line),
                                                     static_cast<int>(begin.column)}) +
                     "not TOML: " + std::string(e.description()));
  }
}

namespace {

/// A number with as few digits as it takes; other values as toml++ writes them.
template <class Value>
std::string value_to_toml(const Value& value) {
  if constexpr (std::is_same_v<Value, toml::value<double>>)
    if (std::isfinite(value.get())) {
      char digits[32];
      return {digits, std::to_chars(digits, digits + sizeof digits, value.get()).ptr};
    }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

std::string key_to_toml(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-';
  });
  return bare ? std::string(key) : value_to_toml(toml::value<std::string>(key));
}

}  // namespace

std::string to_toml(const toml::node& part) {
  std::string words;
  const auto add = [&](const std::string& one) { words += (words.empty() ? "" : ", ") + one; };
  if (const toml::table* table = part.as_table()) {
    for (const auto& [key, value] : *table) add(key_to_toml(key.str()) + " = " + to_toml(value));
    return words.empty() ? "{}" : "{ " + words + " }";
  }
  if (const toml::array* list = part.as_array()) {
    for (const toml::node& one : *list) add(to_toml(one));
    return "[" + words + "]";
  }
  part.visit([&](const auto& value) { words = value_to_toml(value); });
  return words;
}

}  // namespace batten
