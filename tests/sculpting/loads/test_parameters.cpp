// SPDX-License-Identifier: MPL-2.0
// Parameters: ranges, keyframes, and rules between them.
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

ScalarParameter named(const std::string& name, double value = 0) {
  ScalarParameter p;
  p.name = name;
  p.value = value;
  return p;
}

ScalarParameter ranged(const std::string& name, double value, double min, double max) {
  ScalarParameter p = named(name, value);
  p.min = min;
  p.max = max;
  return p;
}

}  // namespace

TEST_CASE("one parameter drives several by linear rules, whatever their order",
          "[sculpting][parameters]") {
  Parameters all;
  // Dependent ones first, so that the order of the rules is not that of adding.
  for (const char* name : {"far", "near", "depth", "bolder", "finer"}) all.add(named(name));
  all.set_rule("far", {{"near", 2}, {"finer", -1}}, 1);
  all.set_rule("near", {{"bolder", 10}}, 3);
  all.set_rule("depth", {{"bolder", -4}, {"bolder", 1}}, 0);
  all.set("bolder", 0.5);
  CHECK(all.value("far") == 2 * 8 + 1);
  all.set("finer", 0.25);
  CHECK(all.value("near") == 8);
  CHECK(all.value("far") == 2 * 8 - 0.25 + 1);
  CHECK(all.value("depth") == -1.5);
  CHECK(all.values() == std::vector<double>{all.value("far"), 8, -1.5, 0.5, 0.25});

  CHECK_THROWS_WITH(all.set("near", 1), Contains("'near'") && Contains("depends on 'bolder'"));
  CHECK_THROWS_WITH(all.remove("bolder"), Contains("the rule of 'near' depends on it"));
  all.set_rule("near", {}, 5);  // independent again
  CHECK(all.value("far") == 10.75);
  all.set("near", 0);
  CHECK(all.value("far") == 0.75);
  all.set_rule("depth", {}, 0);
  all.remove("bolder");
  CHECK(all.count() == 4);
  CHECK(all.index("finer") == 3);
  all.set("finer", 1);
  CHECK(all.value("far") == 0);
}

TEST_CASE("a follower is held to its own range", "[sculpting][parameters]") {
  Parameters all;
  all.add(ranged("slider", 0, -10, 10));
  ScalarParameter driven = ranged("pressure", 0, 0, 30);
  driven.rule_terms = {{"slider", 5}};
  driven.offset = 10;
  all.add(driven);
  CHECK(all.value("pressure") == 10);
  all.set("slider", 10);
  CHECK(all.value("pressure") == 30);
  all.set("slider", -10);
  CHECK(all.value("pressure") == 0);
  all.set("slider", 1);
  CHECK(all.value("pressure") == 15);
}

TEST_CASE("a circle of rules is named and changes nothing", "[sculpting][parameters]") {
  Parameters all;
  for (const char* name : {"a", "b", "c"}) all.add(named(name, 1));
  all.set_rule("b", {{"a", 2}}, 0);
  all.set_rule("c", {{"b", 2}}, 0);
  CHECK_THROWS_WITH(all.set_rule("a", {{"c", 1}}, 0),
                    Contains("'a' depends on 'c' depends on 'b' depends on 'a'"));
  CHECK_THROWS_WITH(all.set_rule("a", {{"a", 1}}, 0), Contains("'a' depends on 'a'"));
  CHECK_THROWS_WITH(all.set_rule("b", {{"aa", 1}}, 0), Contains("'aa'"));
  CHECK_THROWS_AS(all.set_rule("b", {{"a", std::nan("")}}, 0), InputError);
  CHECK_THROWS_AS(all.set_rule("b", {{"a", 1}}, std::nan("")), InputError);
  all.set("a", 3);
  CHECK(all.value("c") == 12);
}

TEST_CASE("numbers that cannot be are refused with their range", "[sculpting][parameters]") {
  Parameters all;
  all.add(ranged("swell", 1, -300, 300));
  CHECK_THROWS_WITH(all.set("swell", 301), Contains("'swell'") && Contains("found 301") &&
                                               Contains("a number from -300 to 300"));
  CHECK_THROWS_WITH(all.set("swell", std::nan("")), Contains("found nan"));
  CHECK_THROWS_WITH(all.set("sweel", 1), Contains("did you mean 'swell'?"));
  CHECK_THROWS_AS(all.set(7, 1.0), InputError);
  CHECK_THROWS_AS(all.set(-1, 1.0), InputError);
  CHECK(all.value("swell") == 1);

  CHECK_THROWS_WITH(all.add(named("swell")), Contains("already used"));
  CHECK_THROWS_WITH(all.add(named("")), Contains("without a name"));
  CHECK_THROWS_WITH(all.add(ranged("x", 0, 2, 1)), Contains("range from 2 to 1"));
  CHECK_THROWS_WITH(all.add(ranged("x", 3, 0, 1)), Contains("found 3"));
  CHECK_THROWS_AS(all.add(named("x", std::numeric_limits<double>::infinity())), InputError);
  ScalarParameter timed = named("x");
  timed.keyframes = {{0, 1}, {2, 1}, {2, 3}};
  CHECK_THROWS_WITH(all.add(timed), Contains("increasing times"));
  timed.keyframes = {{0, 1}, {2, 1}};
  timed.max = 0.5;
  CHECK_THROWS_WITH(all.add(timed), Contains("0.5 or less"));
  timed.max = 2;
  timed.rule_terms = {{"swell", 1}};
  CHECK_THROWS_WITH(all.add(timed), Contains("one of them"));
  ScalarParameter early = named("y");
  early.rule_terms = {{"z", 1}};
  CHECK_THROWS_WITH(all.add(early), Contains("'z'"));
  CHECK(all.count() == 1);
}

TEST_CASE("values over time are linear between moments and constant outside",
          "[sculpting][parameters]") {
  Parameters all;
  ScalarParameter timed = named("swell");
  timed.keyframes = {{1, 10}, {2, 30}, {4, -10}};
  all.add(timed);
  ScalarParameter follower = named("depth");
  follower.rule_terms = {{"swell", 0.5}};
  all.add(follower);
  CHECK(all.value("swell") == 10);
  CHECK(all.value("depth") == 5);
  CHECK_FALSE(all.set_time(0.9));
  const std::vector<std::pair<double, double>> expected = {{1, 10}, {1.25, 15},  {2, 30},
                                                           {3, 10}, {3.75, -5.}, {9, -10}};
  for (const auto& [time, value] : expected) {
    all.set_time(time);
    CHECK(all.value("swell") == Approx(value).margin(1e-15));
    CHECK(all.value("depth") == Approx(value / 2).margin(1e-15));
    CHECK(all.time() == time);
  }
  CHECK_THROWS_AS(all.set_time(std::nan("")), InputError);

  all.set("swell", 7);  // set by the user: not controlled by time
  CHECK_FALSE(all.set_time(2));
  CHECK(all.value("swell") == 7);
}

TEST_CASE("restored values are the same bits, and moments move again", "[sculpting][parameters]") {
  Parameters all;
  all.add(named("a", 0.1));
  ScalarParameter timed = named("t");
  timed.keyframes = {{0, 1}, {3, 2}};
  all.add(timed);
  all.add(named("f"));
  all.set_rule("f", {{"a", 1.0 / 3}, {"t", 0.7}}, 0.2);
  all.set_time(1);
  const std::vector<double> before = all.values();
  all.set("a", 0.7);
  all.set("t", 5);
  all.set_time(2);
  const std::vector<double> after = all.values();
  all.restore(before, 1);
  CHECK(all.values() == before);
  CHECK(all.time() == 1);
  CHECK(all.set_time(3));
  CHECK(all.value("t") == 2);
  all.restore(after, 2);
  CHECK(all.values() == after);
  CHECK_FALSE(all.set_time(3));
  CHECK_THROWS_AS(all.restore({1, 2}, 0), InputError);
}

TEST_CASE("setting, moving in time and restoring ask for no memory", "[sculpting][parameters]") {
  if (!batten_test::counts_allocations()) return;
  Parameters all;
  all.add(ranged("slider", 0, -1, 1));
  ScalarParameter timed = named("t");
  timed.keyframes = {{0, 1}, {3, 2}};
  all.add(timed);
  all.add(named("swell"));
  all.set_rule("swell", {{"slider", 200}, {"t", 1}}, 6);
  const std::vector<double> values = all.values();
  const int slider = all.index("slider");
  const ScopedOpCount work;
  for (int i = 0; i < 100; ++i) {
    all.set(slider, 0.01 * i);
    all.set("slider", -0.01 * i);
    all.set_time(0.03 * i);
    all.restore(values, 0);
  }
  CHECK(work.of(OpCounter::Allocation) == 0);
}
