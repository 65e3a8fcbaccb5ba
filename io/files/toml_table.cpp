// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/toml_table.h"

#include <toml++/toml.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "batten/core/containers.h"

namespace batten {
namespace {

SourceLocation location_of(const toml::source_region& source) {
  return {static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)};
}

/// A short description of a value, for messages.
std::string describe(const toml::node& node) {
  if (const auto* s = node.as_string()) return "the text \"" + s->get() + "\"";
  if (const auto* b = node.as_boolean()) return b->get() ? "true" : "false";
  if (const auto* i = node.as_integer()) return std::to_string(i->get());
  if (const auto* d = node.as_floating_point()) {
    if (std::isnan(d->get())) return "nan (not a number)";
    if (std::isinf(d->get())) return "an infinite number";
    return batten::format_number(d->get());
  }
  if (const auto* a = node.as_array())
    return a->empty()
               ? "an empty list"
               : "a list of " + std::to_string(a->size()) + (a->size() == 1 ? " value" : " values");
  if (node.is_table()) return "a table";
  return "a date or time";
}

int count_names(const std::string& shape) {
  return 1 + static_cast<int>(std::count(shape.begin(), shape.end(), ','));
}

}  // namespace

std::string format_location(const std::string& file, const SourceLocation& location) {
  if (location.line == 0) return file.empty() ? "" : file + ": ";
  return file + ":" + std::to_string(location.line) + ":" + std::to_string(location.column) + ": ";
}

std::string quoted_excerpt(std::string_view found) {
  std::string text = "'";
  for (const char c : found.substr(0, 32))
    text += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  return text + (found.size() > 32 ? "…'" : "'");
}

std::string comma_separated(const std::vector<std::string>& strings) {
  std::string text;
  for (const auto& s : strings) text += (text.empty() ? "" : ", ") + s;
  return text;
}

std::string expected_one_of(const std::string& found, const std::vector<std::string>& choices) {
  return "one of: " + comma_separated(choices) + did_you_mean(found, choices);
}

TomlTable::TomlTable(std::string file, const toml::table& table, std::string what,
                     std::vector<std::string> keys)
    : file_(std::move(file)), table_(&table), what_(std::move(what)) {
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (std::find(keys.begin(), keys.end(), name) == keys.end())
      throw InputError(format_location(file_, location_of(key.source())) + "found key '" + name +
                       "' in " + what_ + ", expected " + expected_one_of(name, keys));
  }
}

bool TomlTable::has(const std::string& key) const { return table_->contains(key); }

SourceLocation TomlTable::location() const {
  SourceLocation location = location_of(table_->source());
  if (location.line == 0) location = {1, 1};
  return location;
}

SourceLocation TomlTable::location(const std::string& key) const {
  const toml::node* node = table_->get(key);
  const SourceLocation location = node ? location_of(node->source()) : SourceLocation{};
  return location.line ? location : this->location();
}

const toml::node& TomlTable::node(const std::string& key, const std::string& expected) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, "no '" + key + "' in " + what_, "'" + key + "', " + expected);
  return *node;
}

void TomlTable::fail(const std::string& key, const std::string& found,
                     const std::string& expected) const {
  throw InputError(at(key) + "found " + found + ", expected " + expected);
}

void TomlTable::fail_node(const toml::node& node, const std::string& found,
                          const std::string& expected) const {
  throw InputError(format_location(file_, location_of(node.source())) + "found " + found +
                   ", expected " + expected);
}

void TomlTable::fail_choice(const std::string& key, const std::string& found,
                            const std::vector<std::string>& names) const {
  throw InputError(at(key) + "found the word '" + found + "' for '" + key + "' in " + what_ +
                   ", expected " + expected_one_of(found, names));
}

std::string TomlTable::text(const std::string& key) const {
  const std::string expected = "a text in quotes";
  const toml::node& value = node(key, expected);
  const auto* text = value.as_string();
  if (!text) fail_node(value, describe(value) + " for '" + key + "'", expected);
  if (text->get().empty()) fail_node(value, "an empty text for '" + key + "'", expected);
  return text->get();
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) const {
  return has(key) ? text(key) : fallback;
}

double TomlTable::finite(const toml::node& node, const std::string& expected) const {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value)) fail_node(node, describe(node), expected);
  return *value;
}

double TomlTable::number(const std::string& key) const {
  const std::string expected = "a number for '" + key + "'";
  return finite(node(key, "a number"), expected);
}

double TomlTable::number(const std::string& key, double fallback) const {
  return has(key) ? number(key) : fallback;
}

double TomlTable::positive(const std::string& key) const {
  const double value = number(key);
  if (value <= 0) fail(key, batten::format_number(value), "a number above 0 for '" + key + "'");
  return value;
}

double TomlTable::positive(const std::string& key, double fallback) const {
  return has(key) ? positive(key) : fallback;
}

bool TomlTable::boolean(const std::string& key, bool fallback) const {
  if (!has(key)) return fallback;
  const toml::node& value = *table_->get(key);
  const auto* flag = value.as_boolean();
  if (!flag) fail_node(value, describe(value), "true or false for '" + key + "'");
  return flag->get();
}

int TomlTable::integer(const std::string& key, int least, int fallback) const {
  if (!has(key)) return fallback;
  const toml::node& value = *table_->get(key);
  const auto* number = value.as_integer();
  constexpr int most = 1'000'000;
  if (!number || number->get() < least || number->get() > most)
    fail_node(value, describe(value),
              "a whole number from " + std::to_string(least) + " to " + std::to_string(most) +
                  " for '" + key + "'");
  return static_cast<int>(number->get());
}

VecX TomlTable::numbers(const std::string& key, const std::string& shape) const {
  const std::string expected = "[" + shape + "] for '" + key + "'";
  const toml::node& value = node(key, "[" + shape + "]");
  const auto* array = value.as_array();
  if (!array || isize(*array) != count_names(shape)) fail_node(value, describe(value), expected);
  VecX result(array->size());
  for (size_t i = 0; i < array->size(); ++i)
    result[static_cast<int>(i)] = finite(*array->get(i), "a number, " + expected);
  return result;
}

Vec3 TomlTable::vector(const std::string& key) const { return numbers(key, "x, y, z"); }

Vec3 TomlTable::direction(const std::string& key) const {
  const Vec3 value = vector(key);
  if (value.norm() == 0) fail(key, "[0, 0, 0]", "a direction [x, y, z] for '" + key + "'");
  return value.normalized();
}

bool TomlTable::is_array(const std::string& key) const {
  const toml::node* value = table_->get(key);
  return value && value->is_array();
}

bool TomlTable::is_text(const std::string& key) const {
  const toml::node* value = table_->get(key);
  return value && value->is_string();
}

std::vector<std::string> TomlTable::mixed_texts(const std::string& key,
                                                const std::string& shape) const {
  const toml::node* value = table_->get(key);
  const auto* array = value ? value->as_array() : nullptr;
  if (!array || std::none_of(array->begin(), array->end(),
                             [](const toml::node& item) { return item.is_string(); }))
    return {};
  const std::string expected = "[" + shape + "] for '" + key + "'";
  if (isize(*array) != count_names(shape)) fail_node(*value, describe(*value), expected);
  std::vector<std::string> texts;
  for (const toml::node& item : *array) {
    char digits[32];
    texts.push_back(
        item.is_string()
            ? item.as_string()->get()
            : std::string(digits, std::to_chars(digits, digits + sizeof digits,
                                                finite(item, "a number or a formula, " + expected))
                                      .ptr));
  }
  return texts;
}

std::vector<VecX> TomlTable::rows(const std::string& key, const std::string& shape) const {
  const std::string list =
      (shape == "x, y, z" ? "a list of points [[" : "a list [[") + shape + "], …]";
  const std::string expected = list + " for '" + key + "'";
  const toml::node& value = node(key, list);
  const auto* array = value.as_array();
  if (!array) fail_node(value, describe(value), expected);
  std::vector<VecX> rows;
  for (const toml::node& item : *array) {
    const auto* numbers = item.as_array();
    if (!numbers || isize(*numbers) != count_names(shape))
      fail_node(item, describe(item), expected);
    VecX row(numbers->size());
    for (size_t i = 0; i < numbers->size(); ++i)
      row[static_cast<int>(i)] = finite(*numbers->get(i), "a number, " + expected);
    rows.push_back(row);
  }
  return rows;
}

std::vector<Vec3> TomlTable::points(const std::string& key) const {
  std::vector<Vec3> points;
  for (const VecX& row : rows(key, "x, y, z")) points.emplace_back(row);
  return points;
}

std::vector<double> TomlTable::list(const std::string& key) const {
  const std::string expected = "a list of numbers for '" + key + "'";
  const toml::node& value = node(key, "a list of numbers");
  const auto* array = value.as_array();
  if (!array || array->empty()) fail_node(value, describe(value), expected);
  std::vector<double> list;
  for (const toml::node& item : *array) list.push_back(finite(item, expected));
  return list;
}

std::vector<LocatedString> TomlTable::strings(const std::string& key) const {
  std::vector<LocatedString> strings;
  if (!has(key)) return strings;
  const std::string expected = "a list of names for '" + key + "'";
  const toml::node& value = *table_->get(key);
  const auto* array = value.as_array();
  if (!array || array->empty()) fail_node(value, describe(value), expected);
  for (const toml::node& item : *array) {
    const auto* text = item.as_string();
    if (!text) fail_node(item, describe(item), expected);
    strings.push_back({text->get(), location_of(item.source())});
  }
  return strings;
}

std::vector<std::vector<LocatedString>> TomlTable::string_lists(const std::string& key) const {
  const std::string expected = "a list of lists of names for '" + key + "'";
  const toml::node& value = node(key, "a list of lists of names [[\"…\", …], …]");
  const auto* array = value.as_array();
  if (!array || array->empty()) fail_node(value, describe(value), expected);
  std::vector<std::vector<LocatedString>> rows;
  for (const toml::node& item : *array) {
    const auto* names = item.as_array();
    if (!names || names->empty()) fail_node(item, describe(item), expected);
    rows.emplace_back();
    for (const toml::node& name : *names) {
      const auto* text = name.as_string();
      if (!text) fail_node(name, describe(name), expected);
      rows.back().push_back({text->get(), location_of(name.source())});
    }
  }
  return rows;
}

std::vector<std::vector<int>> TomlTable::index_lists(const std::string& key) const {
  const std::string expected = "a list of lists of integers from 0 for '" + key + "'";
  const toml::node& value = node(key, "a list of lists of integers [[0, 1, 2], …]");
  const auto* array = value.as_array();
  if (!array || array->empty()) fail_node(value, describe(value), expected);
  std::vector<std::vector<int>> rows;
  for (const toml::node& item : *array) {
    const auto* numbers = item.as_array();
    if (!numbers || numbers->empty()) fail_node(item, describe(item), expected);
    rows.emplace_back();
    for (const toml::node& number : *numbers) {
      const auto* index = number.as_integer();
      if (!index || index->get() < 0 || index->get() > std::numeric_limits<int>::max())
        fail_node(number, describe(number), expected);
      rows.back().push_back(static_cast<int>(index->get()));
    }
  }
  return rows;
}

std::vector<LocatedString> TomlTable::names(const std::string& key) const {
  if (has(key) && !is_array(key)) return {{text(key), location(key)}};
  return strings(key);
}

std::vector<TomlTable> TomlTable::table(const std::string& key,
                                        std::vector<std::string> keys) const {
  if (!has(key)) return {};
  const toml::node& value = *table_->get(key);
  const auto* table = value.as_table();
  if (!table) fail_node(value, describe(value) + " for '" + key + "'", "one table [" + key + "]");
  return {TomlTable(file_, *table, "[" + key + "]", std::move(keys))};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key,
                                         std::vector<std::string> keys) const {
  if (!has(key)) return {};
  const toml::node& value = *table_->get(key);
  const auto* array = value.as_array();
  const std::string expected = "tables [[" + key + "]] (double brackets)";
  if (!array) fail_node(value, describe(value) + " for '" + key + "'", expected);
  std::vector<TomlTable> tables;
  for (const toml::node& item : *array) {
    if (!item.is_table()) fail_node(item, describe(item), expected);
    tables.emplace_back(file_, *item.as_table(), "[[" + key + "]]", keys);
  }
  return tables;
}

std::vector<TomlTable::TableOrName> TomlTable::tables_or_names(
    const std::string& key, const std::vector<std::string>& keys) const {
  std::vector<TableOrName> items;
  if (!has(key)) return items;
  const toml::node& value = *table_->get(key);
  const auto* array = value.as_array();
  if (!array) fail_node(value, describe(value) + " for '" + key + "'", "a list of tables or names");
  for (const toml::node& item : *array) {
    if (const auto* name = item.as_string())
      items.push_back({std::nullopt, {name->get(), location_of(item.source())}});
    else if (item.is_table())
      items.push_back({TomlTable(file_, *item.as_table(), "[[" + key + "]]", keys), {}});
    else
      fail_node(item, describe(item), "a table or a name");
  }
  return items;
}

}  // namespace batten
