// The words of `batten fair`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/lines/run_fair.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"

namespace batten {
namespace {

struct FairWords {
  std::string file, out, minimum, unit = "mm", picture, report;
  std::vector<std::string> only;
  double noise = 0, deviation = 0, wavelength = 0, corner_angle = FairOptions{}.corner_angle,
         segments = 0;
  bool hold_ends = false, closed = false, open = false, keep_outliers = false;
};

int fair(const FairWords& a, const CommonWords& common) {
  FairScene scene;
  scene.unit = a.unit;
  scene.name = std::filesystem::path(a.file).filename().string();
  scene.segments = a.segments;
  scene.lines.emplace_back();
  scene.lines.back().file = a.file;
  for (const std::string& name : a.only) scene.lines.back().only.push_back({name, {}});
  FairStage stage;
  stage.name = "fair";
  FairOptions& options = stage.options;
  using Balance = FairOptions::Balance;
  options.balance = a.noise > 0        ? Balance::Noise
                    : a.deviation > 0  ? Balance::Deviation
                    : a.wavelength > 0 ? Balance::Wavelength
                                       : Balance::CrossValidation;
  options.noise = a.noise;
  options.drop_outliers = !a.keep_outliers;
  options.deviation = a.deviation;
  options.wavelength = a.wavelength;
  options.corner_angle = a.corner_angle;
  if (!a.minimum.empty())
    stage.minimum = a.minimum == "energy" ? CurveFunctional::Energy : CurveFunctional::Variation;
  if (a.closed || a.open) options.closed = a.closed;
  stage.hold_ends = a.hold_ends;
  scene.stages.push_back(stage);
  const FairReport report =
      run_fair(scene, FairFiles{a.out, a.picture, a.report}, terminal_progress(common.quiet));
  return finish(report, summary(report), common);
}

}  // namespace

Command add_fair(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<FairWords>();
  FairWords& a = *words;
  const Words sub =
      program.command("fair", "Fair drawn or measured lines; the ending of OUT says the kind");
  sub.option("lines", a.file, "Lines: .curves .csv .txt .xyz .dat .obj .iges .step .dxf .svg")
      .required();
  sub.option("--out", a.out, "File to write: " + listed(curve_file_endings())).required();
  const Word noise = sub.option("--noise", a.noise,
                                "The fairest curve that the points are off by this, root mean "
                                "square: where the noise is known");
  const Word deviation = sub.option("--deviation", a.deviation,
                                    "The fairest curve not farther than this from any point");
  const Word wavelength = sub.option("--wavelength", a.wavelength,
                                     "Smooth what is shorter than this (default: found by itself)");
  noise.positive().excludes(deviation).excludes(wavelength);
  deviation.positive().excludes(wavelength);
  wavelength.positive();
  sub.option("--minimum", a.minimum,
             "Instead: the curve through all points (a few) of least curvature, or of least "
             "change of it")
      .one_of({"energy", "variation"})
      .excludes(noise)
      .excludes(deviation)
      .excludes(wavelength);
  sub.option("--corner-angle", a.corner_angle,
             "A corner is where a line turns by more than this, degrees (180: none)")
      .within(1e-3, 180.0)
      .with_default();
  sub.flag("--hold-ends", a.hold_ends, "First and last points stay where they are");
  const Word closed = sub.flag("--closed", a.closed, "All lines come back to their start");
  sub.flag("--open", a.open, "No line does").excludes(closed);
  sub.flag("--keep-outliers", a.keep_outliers,
           "Points that lie off a noisy line are not passed over");
  sub.option("--segments", a.segments,
             "In the end: as few segments as stay this near to the fair curve")
      .positive();
  sub.option("--only", a.only, "A line to take, by its name (may be repeated)").repeated();
  sub.option("--picture", a.picture, "Curvature combs before and after (.png)");
  sub.option("--report", a.report, "All numbers (.json)");
  add_unit(sub, a.unit);
  add_common(sub, common);
  return {sub, [words, &common] { return fair(*words, common); }};
}

}  // namespace batten
