// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/formula.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

double value_of(const std::string& text, const Vec3& x) { return Formula(text)(x); }

}  // namespace

TEST_CASE("formulas of the coordinates", "[io][scene]") {
  const Vec3 x(3, -2, 0.5);
  CHECK(value_of("2", x) == 2);
  CHECK(value_of("x + 10 * y + 100*z", x) == 33);
  CHECK(value_of("-1.5e-3*x^2", x) == Approx(-0.0135));
  CHECK(value_of("2E3 * z", x) == 1000);
  CHECK(value_of("max(0, 120 - z) * 9.81e-6", x) == Approx(119.5 * 9.81e-6));
  CHECK(value_of("sin(pi*x/6) * hypot(x, y)", x) == Approx(std::sqrt(13)));
  CHECK(value_of("atan2(y, x)", x) == Approx(std::atan2(-2, 3)));
  CHECK(value_of("x > 2 and y < 0 ? 1 : 5", x) == 1);
  CHECK(value_of("x > 4 or y > 0 ? 1 : 5", x) == 5);
  CHECK(value_of("if(not(x > 4), 7, 8)", x) == 7);
  CHECK(value_of("if(x < 2, 1, 5)", x) == 5);
  const Formula formula("x*y");
  const Formula copy = formula;
  CHECK(copy({2, 3, 0}) == 6);
  CHECK(formula({5, 3, 0}) == 15);
}

TEST_CASE("formulas that cannot be are refused by what is wrong", "[io][scene]") {
  const auto refusal = [](const std::string& text) {
    return error_message([&] { Formula formula(text); });
  };
  CHECK_THAT(refusal("2 * w"), Contains("found 'w' in the formula '2 * w', expected"));
  CHECK_THAT(refusal("2 * sine(x)"), Contains("did you mean 'sin'"));
  CHECK_THAT(refusal("2 * (x"), Contains("Mismatched brackets"));
  CHECK_THAT(refusal("x *"), Contains("found the formula 'x *', expected a formula of x, y, z"));
  for (const char* text : {"x y", "10 000 * x", "2x"}) {
    INFO(text);
    CHECK_THAT(refusal(text), Contains("expected an operator"));
  }
  // Statements of the parser's language, which might not end.
  for (const char* text : {"while(true) {1}", "x := 3", "repeat 1 until(0)", "[x, y, z]",
                           "for(var i := 0; i < 9; i += 1) {x}", "x; y", "x = 3; 1"}) {
    INFO(text);
    CHECK_THAT(refusal(text), Contains("formula"));
  }
  CHECK_THAT(error_message([] {
               Formula("sqrt(x)")({-1, 0, 2});
             }),
             Contains("'sqrt(x)' has no finite value at (-1, 0, 2)"));
  CHECK_THAT(error_message([] { Formula("1/z")({1, 0, 0}); }), Contains("no finite value"));
}
