// SPDX-License-Identifier: MPL-2.0
// JSON serialisation of the entities in a session log: loads, stiffness fields, constraints, curve
// offsets, curves, parameters.
#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

// JSON access with error messages that state the file and its line.

/// JSON that keeps the order of keys.
using LogJson = nlohmann::ordered_json;

/// A number as JSON. Throws InputError if it is not finite, because JSON cannot represent it.
inline LogJson json_number(double value) {
  if (!std::isfinite(value))
    throw InputError("session log: found " + format_number(value) +
                     ", expected finite numbers only");
  return value;
}
inline LogJson json_vector(const Vec3& v) {
  return {json_number(v[0]), json_number(v[1]), json_number(v[2])};
}

/// A JSON object of the log. Its functions read the value of a key. They throw InputError with the
/// line of the log, the value found and the value expected.
class LogObject {
 public:
  /// Keeps a reference to `json`. `where`: "FILE:LINE: "; `what`: name of the object in messages.
  /// Throws InputError if it is not an object, or has a key that is not in `keys`.
  LogObject(const LogJson& json, std::string where, std::string what,
            const std::vector<std::string>& keys)
      : json_(json), where_(std::move(where)), what_(std::move(what)) {
    if (!json.is_object()) fail(what_ + " that is not {…}", "an object");
    for (const auto& [key, value] : json.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end())
        fail("'" + key + "' in " + what_, expected_one_of(key, keys));
  }

  bool has(const std::string& key) const { return json_.contains(key); }
  const std::string& where() const { return where_; }

  const LogJson& at(const std::string& key) const {
    if (!has(key)) fail("no '" + key + "' in " + what_, "it");
    return json_[key];
  }
  std::vector<std::string> strings(const std::string& key) const {
    const LogJson& value = at(key);
    const bool strings =
        value.is_array() && std::all_of(value.begin(), value.end(),
                                        [](const LogJson& item) { return item.is_string(); });
    if (!strings) fail(value.dump() + " for '" + key + "'", "a list of texts in quotes");
    return value;
  }
  std::string text(const std::string& key) const {
    const LogJson& value = at(key);
    if (!value.is_string()) fail(value.dump() + " for '" + key + "'", "a text in quotes");
    return value;
  }
  double number(const std::string& key) const { return number_of(at(key), key); }
  double number(const std::string& key, double fallback) const {
    return has(key) ? number(key) : fallback;
  }
  int integer(const std::string& key, int least) const {
    const LogJson& value = at(key);
    if (!value.is_number_integer() || value.get<long long>() < least ||
        value.get<long long>() > 2'000'000'000)
      fail(value.dump() + " for '" + key + "'", "a whole number from " + std::to_string(least));
    return value;
  }
  bool boolean(const std::string& key) const {
    const LogJson& value = at(key);
    if (!value.is_boolean()) fail(value.dump() + " for '" + key + "'", "true or false");
    return value;
  }
  VecX numbers(const std::string& key, int count) const { return row(at(key), key, count); }
  Vec3 vector(const std::string& key) const { return numbers(key, 3); }
  std::vector<double> list(const std::string& key) const {
    std::vector<double> values;
    for (const LogJson& item : array(key)) values.push_back(number_of(item, key));
    return values;
  }
  std::vector<Vec3> points(const std::string& key) const {
    std::vector<Vec3> values;
    for (const LogJson& item : array(key)) values.emplace_back(row(item, key, 3));
    return values;
  }
  const LogJson& array(const std::string& key) const {
    const LogJson& value = at(key);
    if (!value.is_array()) fail(value.dump() + " for '" + key + "'", "a list");
    return value;
  }
  LogObject object(const std::string& key, const std::vector<std::string>& keys) const {
    return {at(key), where_, "'" + key + "'", keys};
  }
  std::vector<LogObject> objects(const std::string& key,
                                 const std::vector<std::string>& keys) const {
    std::vector<LogObject> list;
    for (const LogJson& item : array(key)) list.emplace_back(item, where_, "'" + key + "'", keys);
    return list;
  }
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(where_ + "found " + found + ", expected " + expected);
  }

 private:
  double number_of(const LogJson& value, const std::string& key) const {
    if (!value.is_number()) fail(value.dump() + " for '" + key + "'", "a number");
    return value;
  }
  VecX row(const LogJson& value, const std::string& key, int count) const {
    if (!value.is_array() || isize(value) != count)
      fail(value.dump() + " for '" + key + "'", std::to_string(count) + " numbers");
    VecX v(count);
    for (int i = 0; i < count; ++i) v[i] = number_of(value[i], key);
    return v;
  }

  const LogJson& json_;
  std::string where_, what_;
};

}  // namespace batten

namespace batten::session_log {

/// Combines one function object per alternative into a visitor for std::visit.
template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

// Serialise the entities of a session as JSON.
LogJson json_of(const std::vector<Area::Painted::Stroke>& strokes);
LogJson json_of(const HermiteCurve& curve);
LogJson json_of(const Load& load);
LogJson json_of(const StiffnessField& weight);
LogJson json_of(const Constraint& constraint);
LogJson json_of(const LineOffset& offset);
/// Throws InputError for a curve that is not piecewise cubic and C1.
LogJson json_of(const CharacterLine& line);
LogJson json_of(const std::vector<ScalarParameter::Term>& terms);
LogJson json_of(const ScalarParameter& parameter);

// Parse the value of `key` in `parent`, or of the key named in the trailing comment. They throw
// InputError with the line of the log.
std::vector<Area::Painted::Stroke> strokes_of(const LogObject& parent, const std::string& key);
std::vector<ScalarParameter::Term> terms_of(const LogObject& parent, const std::string& key);
HermiteCurve curve_of(const LogObject& parent, const std::string& key);
Load load_of(const LogObject& parent);                     // "load"
StiffnessField stiffness_of(const LogObject& parent);      // "stiffness"
Constraint constraint_of(const LogObject& parent);         // "constraint"
LineOffset offset_of(const LogObject& parent);             // "offset"
CharacterLine character_line_of(const LogObject& parent);  // "curve"
ScalarParameter parameter_of(const LogObject& parent);     // "parameter"
/// Parses "parameters"; empty if the key is missing.
std::vector<ScalarParameter> parameters_of(const LogObject& parent);

}  // namespace batten::session_log
