// SPDX-License-Identifier: MPL-2.0
// Named scalar parameters of a model: sliders, keyframed values, and linear rules between
// parameters.
#pragma once

#include <limits>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// A named number with a range. Its value comes from one source: the user (`value`), keyframes over
/// time, or a linear rule that depends on other parameters.
struct ScalarParameter {
  /// One term of a rule: factor times the value of the parameter named `of`.
  struct Term {
    std::string of;
    double factor = 1;
  };
  /// A value at one time. Values are interpolated linearly between keyframes, and constant before
  /// the first and after the last.
  struct Keyframe {
    double time, value;
  };
  std::string name;
  double value = 0;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<Keyframe> keyframes = {};  ///< ascending times; empty: the value is constant in time
  /// Terms of the rule value = offset + Σ factor · parameter, by which one slider can drive many
  /// parameters. Empty: no rule.
  std::vector<Term> rule_terms = {};
  double offset = 0;
};

/// The parameters of one model, in the order in which they were added. Copies are independent.
class Parameters {
 public:
  /// Adds a parameter.
  ///
  /// Throws InputError for an empty or duplicate name, numbers that are not finite, min > max, a
  /// value or keyframe out of range, and keyframes that do not ascend. Also throws if a parameter
  /// has both keyframes and a rule, or if its rule refers to a parameter that does not exist yet.
  void add(ScalarParameter parameter);
  /// Removes a parameter. Throws InputError for an unknown name, and if the rule of another
  /// parameter depends on this one.
  void remove(const std::string& name);
  /// Sets the rule of an existing parameter; its own value and keyframes are discarded.
  ///
  /// Empty `rule_terms` remove the rule; the offset then becomes the value. Throws InputError for
  /// unknown names, a cyclic rule (the message names the parameters of the cycle), numbers that are
  /// not finite, and an offset out of range for a parameter without rule.
  void set_rule(const std::string& name, std::vector<ScalarParameter::Term> rule_terms,
                double offset);

  int count() const { return isize(all_); }
  const std::vector<ScalarParameter>& all() const { return all_; }
  bool has(const std::string& name) const { return index_.count(name) > 0; }
  /// Index of a parameter. Throws InputError for an unknown name (the message suggests the closest
  /// one).
  int index(const std::string& name) const;

  /// Sets a parameter to a user value, which overrides its keyframes until restore().
  ///
  /// Throws InputError for a number that is not finite or out of range, and for a parameter with a
  /// rule (the message names the parameters that drive it). Cost: O(dependent parameters).
  /// Allocates no memory.
  void set(int index, double value);
  void set(const std::string& name, double value) { set(index(name), value); }

  /// Current value of a parameter: the user value, the value of its keyframes at the current time,
  /// or the result of its rule, clamped to the range of the parameter.
  double value(int index) const { return current_[index]; }
  double value(const std::string& name) const { return value(index(name)); }
  const std::vector<double>& values() const { return current_; }

  double time() const { return time_; }
  /// Sets the time, and thereby all keyframed parameters that have no user value. Returns true if
  /// any value changed. Throws InputError for a time that is not finite. Allocates no memory.
  bool set_time(double time);

  /// Restores values that values() returned earlier for the same parameters, and the time.
  ///
  /// Keyframed parameters whose restored value equals the value of their keyframes at `time` follow
  /// the keyframes again; the others count as set by the user. Throws InputError for a wrong number
  /// of values. Allocates no memory.
  void restore(const std::vector<double>& values, double time);

 private:
  struct Rule {
    int follower;
    std::vector<std::pair<int, double>> terms;  // parameter index, factor
  };
  double at_time(int i) const;
  void follow();
  void order_rules();
  std::vector<ScalarParameter> all_;
  std::unordered_map<std::string, int> index_;
  std::vector<Rule> rules_;     // sorted so that each rule comes after those of the parameters it
                                // uses
  std::vector<char> user_set_;  // per keyframed parameter: set by the user, so keyframes do not act
  std::vector<double> current_;
  double time_ = 0;
};

}  // namespace batten
