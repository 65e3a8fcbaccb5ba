// SPDX-License-Identifier: MPL-2.0
// `batten skin curves.csv` without any option gives the expected surface.
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/skin_command.h"

using namespace batten_test;

namespace {

// Without the STEP file a shape takes a third of the time; only the checks of that file are
// missing.
enum class Step { Written, Omitted };

void check_group(const std::string& group, unsigned seed, Step step) {
  for (const ExpectedShape& shape : expected_shapes(seed)) {
    if (shape.group != group) continue;
    const CliCase c("expected");
    c.file("curves.csv", shape.csv());
    const SkinnedCurves result = skin_curves(c / "curves.csv", c / "out", step == Step::Written);
    const ShapeDeviation deviation = deviation_of(result, shape);
    INFO(shape.name << ", seed " << seed << ": exit code " << result.exit_code << ", deviation "
                    << deviation.max << " of the size (tolerance " << shape.tolerance << "), area "
                    << deviation.area << " and volume " << deviation.volume
                    << " of the expected ones\n"
                    << result.message);
    CHECK(result.exit_code == 0);
    CHECK(deviation.correct);
  }
}

constexpr unsigned kStandard = 0, kVaried = 1;

}  // namespace

TEST_CASE("expected shapes: cylinders, cones, spheres, tori", "[apps][expected_shapes]") {
  check_group("revolved", kStandard, Step::Written);
}
TEST_CASE("expected shapes: tubes, wings and hulls from sections", "[apps][expected_shapes]") {
  check_group("sections", kStandard, Step::Written);
}
TEST_CASE("expected shapes: saddles, ruled surfaces, canopies", "[apps][expected_shapes]") {
  check_group("ruled", kStandard, Step::Written);
}
TEST_CASE("expected shapes: flat outlines with corners", "[apps][expected_shapes]") {
  check_group("flat", kStandard, Step::Written);
}
TEST_CASE("expected shapes: wedges", "[apps][expected_shapes]") {
  check_group("solids", kStandard, Step::Written);
}

TEST_CASE("expected shapes with other dimensions, points, order and position",
          "[apps][expected_shapes]") {
  for (const char* group : {"revolved", "sections", "ruled", "flat", "solids"})
    check_group(group, kVaried, Step::Omitted);
}

TEST_CASE("expected shapes: the program gives the same as its functions",
          "[apps][expected_shapes]") {
  for (const ExpectedShape& shape : expected_shapes()) {
    if (shape.name != "tube, short" && shape.name != "wedge of 16 degrees" &&
        shape.name != "wing, span 8")
      continue;
    const CliCase c("expected_program");
    c.file("curves.csv", shape.csv());
    const CliResult program = c.run({"skin", "curves.csv", "--out", "out"});
    const SkinnedCurves result = skin_curves(c / "curves.csv", c / "in process", true);
    INFO(shape.name << "\n" << program.out << program.err << result.message);
    CHECK(program.code == result.exit_code);
    const auto j = report(c, "out");
    CHECK(j["surface"]["area"].get<double>() == Approx(result.area).epsilon(1e-9));
    for (const char* file : {"curves.vtp", "curves.step"}) CHECK(fs::exists(c / "out" / file));
  }
}

TEST_CASE("expected shapes: outlines with blunt corners are not read as curves without a remark",
          "[apps][expected_shapes]") {
  // Turns below 50 degrees could be corners or points of a smooth curve. As long as the command
  // does not treat such outlines as polygons, it must report how it interpreted them.
  for (const ExpectedShape& shape : ambiguous_outlines()) {
    const CliCase c("expected_ambiguous");
    c.file("curves.csv", shape.csv());
    const SkinnedCurves result = skin_curves(c / "curves.csv", c / "out", false);
    INFO(shape.name);
    CHECK((deviation_of(result, shape).correct || result.warns()));
  }
}
