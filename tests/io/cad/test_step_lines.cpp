// SPDX-License-Identifier: MPL-2.0
// Curves in STEP files: separate entities besides the faces, which are unchanged.
#include <cstdlib>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_convert.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/step/step.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;
namespace fs = std::filesystem;

namespace {

std::vector<CubicSpline> splines_of(const BuiltModel& made) {
  std::vector<CubicSpline> splines;
  for (const NetworkEdge& edge : made.network.edges())
    for (const CubicSpline& spline : cubic_splines("line " + edge.name, edge.curve))
      splines.push_back(spline);
  return splines;
}

StepReport written(const BuiltModel& made, const fs::path& file,
                   const StepFileOptions& file_options, double unit) {
  StepFaceOptions options;
  options.file = file_options;
  options.tolerance = 1e-3;
  return write_step_faces(file, made.model.skinned(), unit, options);
}

}  // namespace

TEST_CASE("a STEP file contains curves beside the same faces, in any schema and unit",
          "[io][step]") {
  const fs::path folder = scratch("step_lines");
  const double unit = GENERATE(1e-3, 0.0254);
  const BuiltModel made = build_model(box({4, 3, 2}), {}, 1);
  StepFileOptions file_options;
  file_options.name = "box";
  const StepReport plain = written(made, folder / "plain.step", file_options, unit);
  file_options.lines = splines_of(made);
  file_options.ap242 = true;
  const StepReport r = written(made, folder / "lines.step", file_options, unit);
  CHECK(plain.curves == 0);
  CHECK(r.curves == 12);
  CHECK(r.valid);
  CHECK(r.faces == plain.faces);
  CHECK(r.edges == plain.edges);
  CHECK(r.free_edges == 0);
  CHECK(r.solids == 1);
  CHECK(r.size == plain.size);
  CHECK(r.area == Approx(plain.area).epsilon(1e-12));
  CHECK(r.volume == Approx(plain.volume).epsilon(1e-12));
  CHECK(*r.max_deviation == Approx(*plain.max_deviation).epsilon(1e-9));
  CHECK(r.continuity->edges == plain.continuity->edges);
  const StepReport again = check_step(folder / "lines.step", unit);
  CHECK(again.curves == 12);
  CHECK(again.faces == plain.faces);

  CHECK(read_cad_contents(folder / "plain.step").format == "STEP AP214");
  const CadContents c = read_cad_contents(folder / "lines.step");
  CHECK(c.format == "STEP AP242");
  CHECK(c.unit_in_metres == Approx(unit).epsilon(1e-12));
  REQUIRE(c.products.size() == 2);
  CHECK(c.products[0].name.starts_with("box"));
  CHECK(c.products[0].curves == 0);
  CHECK(c.products[1].name == "curves");
  CHECK(c.products[1].faces == 0);
  CHECK(c.products[1].curves == 12);
  // The curves are the input splines, with their names.
  int found = 0;
  for (const CharacterLine& line : read_cad_lines(folder / "lines.step", unit))
    for (const CubicSpline& spline : file_options.lines) {
      if (line.name != spline.name) continue;
      ++found;
      CHECK((line.curve->evaluate(line.curve->start()) - spline.poles.front()).norm() < 1e-12);
      CHECK((line.curve->evaluate(line.curve->end()) - spline.poles.back()).norm() < 1e-12);
      CHECK(line.curve->piecewise_cubic());
      CHECK(line.curve->breaks().size() == spline.knots.size());
    }
  CHECK(found == 12);
}

TEST_CASE("Gmsh meshes the faces of a file with curves as it does without", "[io][step]") {
  if (std::system("/usr/bin/python3 -c 'import gmsh' > /dev/null 2>&1") != 0) {
    WARN("skipped: python3 has no module gmsh");
    return;
  }
  const fs::path folder = scratch("step_lines_gmsh");
  const BuiltModel made = build_model(box({4, 3, 2}), {}, 1);
  StepFileOptions file_options;
  file_options.lines = splines_of(made);
  const fs::path file = folder / "lines.step";
  written(made, file, file_options, 1e-3);
  CHECK(std::system(("/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/cad/gmsh_opens_step.py' '" +
                     file.string() + "' > /dev/null")
                        .c_str()) == 0);
}
