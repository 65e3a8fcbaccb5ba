// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/loads/parameters.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

std::string range_of(const ScalarParameter& p) {
  const bool low = std::isfinite(p.min), high = std::isfinite(p.max);
  if (low && high) return "a number from " + format_number(p.min) + " to " + format_number(p.max);
  if (low) return "a number of " + format_number(p.min) + " or more";
  if (high) return "a number of " + format_number(p.max) + " or less";
  return "a number";
}

void expect_in_range(const ScalarParameter& p, double value) {
  if (!std::isfinite(value) || value < p.min || value > p.max)
    throw InputError("parameter '" + p.name + "': found " + format_number(value) + ", expected " +
                     range_of(p));
}

void check(const ScalarParameter& p) {
  const std::string who = "parameter '" + p.name + "': ";
  if (p.name.empty()) throw InputError("found a parameter without a name, expected a name");
  if (std::isnan(p.min) || std::isnan(p.max) || p.min > p.max)
    throw InputError(who + "found the range from " + format_number(p.min) + " to " +
                     format_number(p.max) + ", expected a minimum below the maximum");
  if (!p.keyframes.empty() && !p.rule_terms.empty())
    throw InputError(who + "found keyframes and a rule, expected only one of them");
  for (size_t i = 0; i < p.keyframes.size(); ++i) {
    const auto& keyframe = p.keyframes[i];
    if (!std::isfinite(keyframe.time))
      throw InputError(who + "found a keyframe at time " + format_number(keyframe.time) +
                       ", expected a finite time");
    if (i > 0 && !(keyframe.time > p.keyframes[i - 1].time))
      throw InputError(who + "found a keyframe at time " + format_number(keyframe.time) +
                       " after one at " + format_number(p.keyframes[i - 1].time) +
                       ", expected increasing times");
    expect_in_range(p, keyframe.value);
  }
  if (p.keyframes.empty() && p.rule_terms.empty()) expect_in_range(p, p.value);
}

void check(const std::string& name, const std::vector<ScalarParameter::Term>& rule_terms,
           double offset) {
  const std::string who = "parameter '" + name + "': ";
  if (!std::isfinite(offset))
    throw InputError(who + "found the offset " + format_number(offset) + ", expected a number");
  for (const auto& term : rule_terms)
    if (!std::isfinite(term.factor))
      throw InputError(who + "found the factor " + format_number(term.factor) + " of '" + term.of +
                       "', expected a number");
}

}  // namespace

void Parameters::add(ScalarParameter parameter) {
  check(parameter);
  if (has(parameter.name))
    throw InputError("parameter '" + parameter.name +
                     "': the name is already used; choose a different one");
  check(parameter.name, parameter.rule_terms, parameter.offset);
  for (const auto& term : parameter.rule_terms) index(term.of);
  const int i = count();
  index_.emplace(parameter.name, i);
  current_.push_back(parameter.value);
  user_set_.push_back(false);
  all_.push_back(std::move(parameter));
  if (!all_.back().keyframes.empty()) all_.back().value = current_.back() = at_time(i);
  order_rules();
  follow();
}

void Parameters::remove(const std::string& name) {
  const int gone = index(name);
  for (const ScalarParameter& p : all_)
    for (const auto& term : p.rule_terms)
      if (term.of == name)
        throw InputError("parameter '" + name + "' cannot be removed: the rule of '" + p.name +
                         "' depends on it");
  all_.erase(all_.begin() + gone);
  current_.erase(current_.begin() + gone);
  user_set_.erase(user_set_.begin() + gone);
  index_.clear();
  for (int i = 0; i < count(); ++i) index_.emplace(all_[i].name, i);
  order_rules();
}

void Parameters::set_rule(const std::string& name, std::vector<ScalarParameter::Term> rule_terms,
                          double offset) {
  ScalarParameter& driven = all_[index(name)];
  check(name, rule_terms, offset);
  if (rule_terms.empty()) expect_in_range(driven, offset);
  // None of the parameters that `name` is to depend on may depend on `name`, directly or
  // indirectly.
  std::vector<std::string> way = {name};
  const auto look = [&](const auto& self, const std::vector<ScalarParameter::Term>& terms) -> void {
    for (const auto& term : terms) {
      way.push_back(term.of);
      if (term.of == name) {
        std::string circle;
        for (const auto& word : way)
          circle += (circle.empty() ? "'" : " depends on '") + word + "'";
        throw InputError("parameter '" + name + "': found a circular dependency: " + circle);
      }
      self(self, all_[index(term.of)].rule_terms);
      way.pop_back();
    }
  };
  look(look, rule_terms);
  driven.keyframes.clear();
  driven.rule_terms = std::move(rule_terms);
  driven.offset = offset;
  if (driven.rule_terms.empty()) driven.value = current_[index(name)] = offset;
  order_rules();
  follow();
}

int Parameters::index(const std::string& name) const {
  const auto found = index_.find(name);
  if (found != index_.end()) return found->second;
  std::vector<std::string> names;
  std::string list;
  for (const ScalarParameter& p : all_) {
    names.push_back(p.name);
    list += (list.empty() ? "" : ", ") + p.name;
  }
  throw InputError("found parameter '" + name + "', expected " +
                   (names.empty() ? "none: there are no parameters" : "one of: " + list) +
                   did_you_mean(name, names));
}

void Parameters::set(int index, double value) {
  if (index < 0 || index >= count())
    throw InputError("found parameter number " + std::to_string(index) + ", expected 0 to " +
                     std::to_string(count() - 1));
  ScalarParameter& p = all_[index];
  if (!p.rule_terms.empty()) {
    std::string leaders;
    for (const auto& term : p.rule_terms)
      leaders += (leaders.empty() ? "'" : ", '") + term.of + "'";
    throw InputError("parameter '" + p.name + "' cannot be set: its rule depends on " + leaders +
                     "; set those instead");
  }
  expect_in_range(p, value);
  p.value = current_[index] = value;
  user_set_[index] = true;
  follow();
}

bool Parameters::set_time(double time) {
  if (!std::isfinite(time))
    throw InputError("found the time " + format_number(time) + ", expected a number");
  time_ = time;
  bool changed = false;
  for (int i = 0; i < count(); ++i) {
    const auto k = static_cast<size_t>(i);
    if (all_[k].keyframes.empty() || user_set_[k]) continue;
    const double value = at_time(i);
    changed = changed || value != current_[k];
    all_[k].value = current_[k] = value;
  }
  if (changed) follow();
  return changed;
}

void Parameters::restore(const std::vector<double>& values, double time) {
  if (values.size() != current_.size())
    throw InputError("found " + std::to_string(values.size()) + " values to restore, expected " +
                     std::to_string(current_.size()));
  time_ = time;
  for (size_t k = 0; k < all_.size(); ++k) {
    current_[k] = values[k];
    if (all_[k].rule_terms.empty()) all_[k].value = values[k];
    user_set_[k] = !all_[k].keyframes.empty() && values[k] != at_time(static_cast<int>(k));
  }
  follow();
}

double Parameters::at_time(int i) const {
  const auto& keyframes = all_[i].keyframes;
  if (time_ <= keyframes.front().time) return keyframes.front().value;
  if (time_ >= keyframes.back().time) return keyframes.back().value;
  const auto after =
      std::upper_bound(keyframes.begin(), keyframes.end(), time_,
                       [](double t, const auto& keyframe) { return t < keyframe.time; });
  const auto& [t0, v0] = *(after - 1);
  const auto& [t1, v1] = *after;
  const double s = (time_ - t0) / (t1 - t0);
  return (1 - s) * v0 + s * v1;
}

void Parameters::follow() {
  for (const Rule& rule : rules_) {
    const ScalarParameter& p = all_[rule.follower];
    double value = p.offset;
    for (const auto& [leader, factor] : rule.terms) value += factor * current_[leader];
    current_[rule.follower] = std::clamp(value, p.min, p.max);
  }
}

void Parameters::order_rules() {
  rules_.clear();
  std::vector<char> placed(all_.size(), false);
  const auto place = [&](const auto& self, int i) -> void {
    const auto k = static_cast<size_t>(i);
    if (placed[k]) return;
    placed[k] = true;
    if (all_[k].rule_terms.empty()) return;
    Rule rule{i, {}};
    for (const auto& term : all_[k].rule_terms) {
      rule.terms.emplace_back(index_.at(term.of), term.factor);
      self(self, rule.terms.back().first);
    }
    rules_.push_back(std::move(rule));
  };
  for (int i = 0; i < count(); ++i) place(place, i);
}

}  // namespace batten
