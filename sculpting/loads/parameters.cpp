#include "batten/sculpting/loads/parameters.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

std::string range_of(const NamedValue& p) {
  const bool low = std::isfinite(p.min), high = std::isfinite(p.max);
  if (low && high) return "a number from " + number(p.min) + " to " + number(p.max);
  if (low) return "a number from " + number(p.min) + " up";
  if (high) return "a number up to " + number(p.max);
  return "a number";
}

void expect_in_range(const NamedValue& p, double value) {
  if (!std::isfinite(value) || value < p.min || value > p.max)
    throw InputError("parameter '" + p.name + "': found " + number(value) + ", expected " +
                     range_of(p));
}

void check(const NamedValue& p) {
  const std::string who = "parameter '" + p.name + "': ";
  if (p.name.empty()) throw InputError("found a parameter without a name, expected a name");
  if (std::isnan(p.min) || std::isnan(p.max) || p.min > p.max)
    throw InputError(who + "found the range from " + number(p.min) + " to " + number(p.max) +
                     ", expected one that is not empty");
  if (!p.over_time.empty() && !p.follows.empty())
    throw InputError(who + "found moments and parameters that it follows, expected one of them");
  for (size_t i = 0; i < p.over_time.size(); ++i) {
    const auto& moment = p.over_time[i];
    if (!std::isfinite(moment.time))
      throw InputError(who + "found a moment at " + number(moment.time) + ", expected a time");
    if (i > 0 && !(moment.time > p.over_time[i - 1].time))
      throw InputError(who + "found a moment at " + number(moment.time) + " after one at " +
                       number(p.over_time[i - 1].time) + ", expected moments that ascend");
    expect_in_range(p, moment.value);
  }
  if (p.over_time.empty() && p.follows.empty()) expect_in_range(p, p.value);
}

void check(const std::string& name, const std::vector<NamedValue::Share>& follows, double offset) {
  const std::string who = "parameter '" + name + "': ";
  if (!std::isfinite(offset))
    throw InputError(who + "found the offset " + number(offset) + ", expected a number");
  for (const auto& share : follows)
    if (!std::isfinite(share.factor))
      throw InputError(who + "found the factor " + number(share.factor) + " of '" + share.of +
                       "', expected a number");
}

}  // namespace

void Parameters::add(NamedValue parameter) {
  check(parameter);
  if (has(parameter.name))
    throw InputError("parameter '" + parameter.name +
                     "': found the name again, expected one that is not taken");
  check(parameter.name, parameter.follows, parameter.offset);
  for (const auto& share : parameter.follows) index(share.of);
  const int i = count();
  index_.emplace(parameter.name, i);
  current_.push_back(parameter.value);
  by_hand_.push_back(false);
  all_.push_back(std::move(parameter));
  if (!all_.back().over_time.empty()) all_.back().value = current_.back() = at_time(i);
  order_rules();
  follow();
}

void Parameters::remove(const std::string& name) {
  const int gone = index(name);
  for (const NamedValue& p : all_)
    for (const auto& share : p.follows)
      if (share.of == name)
        throw InputError("parameter '" + name + "': found '" + p.name +
                         "' following it, expected none that does");
  all_.erase(all_.begin() + gone);
  current_.erase(current_.begin() + gone);
  by_hand_.erase(by_hand_.begin() + gone);
  index_.clear();
  for (int i = 0; i < count(); ++i) index_.emplace(all_[i].name, i);
  order_rules();
}

void Parameters::drive(const std::string& name, std::vector<NamedValue::Share> follows,
                       double offset) {
  NamedValue& driven = all_[index(name)];
  check(name, follows, offset);
  if (follows.empty()) expect_in_range(driven, offset);
  // Whoever `name` is to follow must not follow it, by however many steps.
  std::vector<std::string> way = {name};
  const auto look = [&](const auto& self, const std::vector<NamedValue::Share>& shares) -> void {
    for (const auto& share : shares) {
      way.push_back(share.of);
      if (share.of == name) {
        std::string circle;
        for (const auto& word : way) circle += (circle.empty() ? "'" : " follows '") + word + "'";
        throw InputError("parameter '" + name + "': found a circle, " + circle +
                         ", expected rules that end");
      }
      self(self, all_[index(share.of)].follows);
      way.pop_back();
    }
  };
  look(look, follows);
  driven.over_time.clear();
  driven.follows = std::move(follows);
  driven.offset = offset;
  if (driven.follows.empty()) driven.value = current_[index(name)] = offset;
  order_rules();
  follow();
}

int Parameters::index(const std::string& name) const {
  const auto found = index_.find(name);
  if (found != index_.end()) return found->second;
  std::vector<std::string> names;
  std::string list;
  for (const NamedValue& p : all_) {
    names.push_back(p.name);
    list += (list.empty() ? "" : ", ") + p.name;
  }
  const std::string nearest = nearest_word(name, names);
  throw InputError("found parameter '" + name + "', expected " +
                   (names.empty() ? "none: there are no parameters" : "one of: " + list) +
                   (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
}

void Parameters::set(int index, double value) {
  if (index < 0 || index >= count())
    throw InputError("found parameter number " + std::to_string(index) + ", expected 0 to " +
                     std::to_string(count() - 1));
  NamedValue& p = all_[index];
  if (!p.follows.empty()) {
    std::string leaders;
    for (const auto& share : p.follows) leaders += (leaders.empty() ? "'" : ", '") + share.of + "'";
    throw InputError("parameter '" + p.name + "': found a value for it, but it follows " + leaders +
                     "; expected one for those");
  }
  expect_in_range(p, value);
  p.value = current_[index] = value;
  by_hand_[index] = true;
  follow();
}

bool Parameters::set_time(double time) {
  if (!std::isfinite(time))
    throw InputError("found the time " + number(time) + ", expected a number");
  time_ = time;
  bool changed = false;
  for (int i = 0; i < count(); ++i) {
    const auto k = static_cast<size_t>(i);
    if (all_[k].over_time.empty() || by_hand_[k]) continue;
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
    if (all_[k].follows.empty()) all_[k].value = values[k];
    by_hand_[k] = !all_[k].over_time.empty() && values[k] != at_time(static_cast<int>(k));
  }
  follow();
}

double Parameters::at_time(int i) const {
  const auto& moments = all_[i].over_time;
  if (time_ <= moments.front().time) return moments.front().value;
  if (time_ >= moments.back().time) return moments.back().value;
  const auto after = std::upper_bound(moments.begin(), moments.end(), time_,
                                      [](double t, const auto& moment) { return t < moment.time; });
  const auto& [t0, v0] = *(after - 1);
  const auto& [t1, v1] = *after;
  const double s = (time_ - t0) / (t1 - t0);
  return (1 - s) * v0 + s * v1;
}

void Parameters::follow() {
  for (const Rule& rule : rules_) {
    const NamedValue& p = all_[rule.follower];
    double value = p.offset;
    for (const auto& [leader, factor] : rule.shares) value += factor * current_[leader];
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
    if (all_[k].follows.empty()) return;
    Rule rule{i, {}};
    for (const auto& share : all_[k].follows) {
      rule.shares.emplace_back(index_.at(share.of), share.factor);
      self(self, rule.shares.back().first);
    }
    rules_.push_back(std::move(rule));
  };
  for (int i = 0; i < count(); ++i) place(place, i);
}

}  // namespace batten
