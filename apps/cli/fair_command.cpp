// The words of `batten fair`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/lines/run_fair.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"

namespace batten {
namespace {

struct FairArguments {
  std::string file, out, minimum, unit = "mm", picture, report;
  std::vector<std::string> only;
  double noise = 0, deviation = 0, wavelength = 0, corner_angle = FairOptions{}.corner_angle,
         segments = 0;
  bool fix_ends = false, closed = false, open = false, keep_outliers = false;
};

int fair(const FairArguments& a, const CommonOptions& common) {
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
  using Smoothing = FairOptions::Smoothing;
  options.smoothing = a.noise > 0        ? Smoothing::Noise
                      : a.deviation > 0  ? Smoothing::Deviation
                      : a.wavelength > 0 ? Smoothing::Wavelength
                                         : Smoothing::CrossValidation;
  options.noise = a.noise;
  options.reject_outliers = !a.keep_outliers;
  options.deviation = a.deviation;
  options.wavelength = a.wavelength;
  options.corner_angle = a.corner_angle;
  if (!a.minimum.empty())
    stage.minimum = a.minimum == "energy" ? CurveFunctional::Energy : CurveFunctional::Variation;
  if (a.closed || a.open) options.closed = a.closed;
  stage.fix_ends = a.fix_ends;
  scene.stages.push_back(stage);
  const FairReport report =
      run_fair(scene, FairFiles{a.out, a.picture, a.report}, terminal_progress(common.quiet));
  return print_result(report, summary(report), common);
}

}  // namespace

Command add_fair(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FairArguments>();
  FairArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("fair", "Fair drawn or measured lines; the ending of OUT says the kind");
  subcommand
      .option("lines", a.file, "Lines: .curves .csv .txt .xyz .dat .obj .iges .step .dxf .svg")
      .required();
  subcommand.option("--out", a.out, "File to write: " + comma_separated(curve_file_endings()))
      .required();
  const CommandOption noise =
      subcommand.option("--noise", a.noise,
                        "The fairest curve that the points are off by this, root mean "
                        "square: where the noise is known");
  const CommandOption deviation = subcommand.option(
      "--deviation", a.deviation, "The fairest curve not farther than this from any point");
  const CommandOption wavelength = subcommand.option(
      "--wavelength", a.wavelength, "Smooth what is shorter than this (default: found by itself)");
  noise.positive().excludes(deviation).excludes(wavelength);
  deviation.positive().excludes(wavelength);
  wavelength.positive();
  subcommand
      .option("--minimum", a.minimum,
              "Instead: the curve through all points (a few) of least curvature, or of least "
              "change of it")
      .one_of({"energy", "variation"})
      .excludes(noise)
      .excludes(deviation)
      .excludes(wavelength);
  subcommand
      .option("--corner-angle", a.corner_angle,
              "A corner is where a line turns by more than this, degrees (180: none)")
      .in_range(1e-3, 180.0)
      .show_default();
  subcommand.flag("--hold-ends", a.fix_ends, "First and last points stay where they are");
  const CommandOption closed =
      subcommand.flag("--closed", a.closed, "All lines come back to their start");
  subcommand.flag("--open", a.open, "No line does").excludes(closed);
  subcommand.flag("--keep-outliers", a.keep_outliers,
                  "Points that lie off a noisy line are not passed over");
  subcommand
      .option("--segments", a.segments,
              "In the end: as few segments as stay this near to the fair curve")
      .positive();
  subcommand.option("--only", a.only, "A line to take, by its name (may be repeated)")
      .allow_repeated();
  subcommand.option("--picture", a.picture, "Curvature combs before and after (.png)");
  subcommand.option("--report", a.report, "All numbers (.json)");
  add_unit(subcommand, a.unit);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] { return fair(*arguments, common); }};
}

}  // namespace batten
