// Named numbers that shape a surface: sliders, values over time, and rules between them.
#pragma once

#include <limits>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// A number with a name and a range. It has one source: the user's hand (`value`), time, or other
/// parameters.
struct ScalarParameter {
  /// One term of a rule: it adds factor times the value of another parameter.
  struct Term {
    std::string of;
    double factor = 1;
  };
  /// A value at one time. Values are linear between moments, and constant before the first and
  /// after the last.
  struct Keyframe {
    double time, value;
  };
  std::string name;
  double value = 0;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<Keyframe> keyframes = {};  ///< ascending; none: the value stands
  /// value = offset + Σ factor · parameter; none: the value is its own. So one slider can move many
  /// parameters.
  std::vector<Term> rule_terms = {};
  double offset = 0;
};

/// The parameters of one model, in the order in which they were added. Copies are independent.
class Parameters {
 public:
  /// Adds a parameter. Throws InputError: no name or one that is taken, numbers that are not
  /// finite, min > max, a value or a moment outside of the range, moments that do not ascend, a
  /// parameter that has moments and follows others too, or that follows one that is not there yet.
  void add(ScalarParameter parameter);
  /// Removes a parameter. Throws InputError: an unknown name, or one that another parameter
  /// follows.
  void remove(const std::string& name);
  /// Makes a parameter that is there already follow others; it loses its own value and moments.
  /// Without any to follow it stands alone again, with the offset as its value. Throws InputError:
  /// unknown names, a circle (its members are named), numbers that are not finite, an offset
  /// outside of the range for a parameter that stands alone.
  void set_rule(const std::string& name, std::vector<ScalarParameter::Term> rule_terms,
                double offset);

  int count() const { return isize(all_); }
  const std::vector<ScalarParameter>& all() const { return all_; }
  bool has(const std::string& name) const { return index_.count(name) > 0; }
  /// Returns the number of a parameter. Throws InputError: an unknown name (the nearest is
  /// offered).
  int index(const std::string& name) const;

  /// Sets a parameter by hand; time moves it no more, until restore(). Throws InputError: a number
  /// that is not finite or out of range, a parameter that follows others (they are named).
  /// O(followers), allocates nothing.
  void set(int index, double value);
  void set(const std::string& name, double value) { set(index(name), value); }

  /// Returns the current value: that set by hand, that of the present time, or that of its rule,
  /// held to its own range.
  double value(int index) const { return current_[index]; }
  double value(const std::string& name) const { return value(index(name)); }
  const std::vector<double>& values() const { return current_; }

  double time() const { return time_; }
  /// Sets the time, and with it the parameters that have moments and were not set by hand. Returns
  /// whether any value changed.
  /// Throws InputError on a time that is not finite. Allocates nothing.
  bool set_time(double time);

  /// Restores values that values() once gave for the same parameters, and that time. Parameters
  /// with moments whose value is that of the time follow it again, others count as set by hand.
  /// Throws InputError when there are not as many. Allocates nothing.
  void restore(const std::vector<double>& values, double time);

 private:
  struct Rule {
    int follower;
    std::vector<std::pair<int, double>> terms;  // parameter, factor
  };
  double at_time(int i) const;
  void follow();
  void order_rules();
  std::vector<ScalarParameter> all_;
  std::unordered_map<std::string, int> index_;
  std::vector<Rule> rules_;     // each after those of the parameters that it follows
  std::vector<char> user_set_;  // of parameters with moments: time does not move them
  std::vector<double> current_;
  double time_ = 0;
};

}  // namespace batten
