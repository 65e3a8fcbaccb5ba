// SPDX-License-Identifier: MPL-2.0
#include "batten/core/errors.h"

#include <limits>

#include "batten/core/progress.h"
#include "batten/tests/support/catch.h"

using namespace batten;

TEST_CASE("every error is caught as batten::Error and as std::exception", "[core][errors]") {
  CHECK_THROWS_AS(throw InputError("wrong"), Error);
  CHECK_THROWS_AS(throw NoSolutionError("singular"), Error);
  CHECK_THROWS_AS(throw ConflictError({}), Error);
  CHECK_THROWS_AS(throw CancelledError(), Error);
  CHECK_THROWS_AS(throw CancelledError(), std::exception);
}

TEST_CASE("a conflict names every constraint that takes part and by how much they miss",
          "[core][errors]") {
  const ConflictError error({{{"corner", "rim", "seam"}, 0.25}, {{"alone"}, 1e-3}});
  REQUIRE(error.conflicts().size() == 2);
  CHECK(error.conflicts()[0].names == std::vector<std::string>{"corner", "rim", "seam"});
  CHECK(error.conflicts()[0].amount == 0.25);
  const std::string text = error.what();
  for (const char* word : {"'corner'", "'rim'", "'seam'", "0.25", "'alone'", "0.001"})
    CHECK(text.find(word) != std::string::npos);
}

TEST_CASE("format_number() keeps six digits and never invents any", "[core][errors]") {
  CHECK(format_number(0) == "0");
  CHECK(format_number(0.1) == "0.1");
  CHECK(format_number(-2.5e-7) == "-2.5e-07");
  CHECK(format_number(1.0 / 3) == "0.333333");
  CHECK(format_number(1e300) == "1e+300");
  CHECK(format_number(std::numeric_limits<double>::quiet_NaN()).find("nan") != std::string::npos);
}

TEST_CASE("closest_match finds the intended word, and none if no word is similar",
          "[core][errors]") {
  const std::vector<std::string> words{"stiffness", "pressure", "point", "uniform"};
  CHECK(closest_match("pressure", words) == "pressure");
  CHECK(closest_match("presure", words) == "pressure");    // a missing letter
  CHECK(closest_match("pressurre", words) == "pressure");  // an extra letter
  CHECK(closest_match("stifnes", words) == "stiffness");   // two missing letters
  CHECK(closest_match("uniporm", words) == "uniform");     // a replaced letter
  CHECK(closest_match("temperature", words) == "");
  CHECK(closest_match("point", {}) == "");
  // The closer one of two similar words.
  CHECK(closest_match("lined", {"limes", "lines", "line"}) == "lines");
  CHECK(did_you_mean("presure", words) == "; did you mean 'pressure'?");
  CHECK(did_you_mean("temperature", words).empty());
}

TEST_CASE("an empty progress does nothing, a cancelled one stops the computation",
          "[core][errors]") {
  CHECK_NOTHROW(Progress{}.update("stage", 0.5));

  std::string seen;
  double fraction = 0;
  Progress progress;
  progress.report = [&](std::string_view stage, double f) {
    seen = stage;
    fraction = f;
  };
  progress.update("factor", 0.25);
  CHECK(seen == "factor");
  CHECK(fraction == 0.25);

  progress.cancelled = [] { return true; };
  CHECK_THROWS_AS(progress.update("solve", 1), CancelledError);
  CHECK(seen == "factor");  // no report from a cancelled stage
}
