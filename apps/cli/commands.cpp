// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/commands.h"

#include <semaphore.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <thread>

#include "batten/apps/documents/document.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/runs/plugins.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

void add_common(const Subcommand& subcommand, CommonOptions& common) {
  subcommand.option("--threads", common.threads, "Number of threads (default: number of cores)")
      .in_range(1, 1024);
  subcommand
      .option("--memory", common.memory,
              "Memory limit in GB (default: available memory); jobs that would exceed it are "
              "rejected at the start")
      .positive();
  subcommand.flag("--quiet", common.quiet, "Print warnings, failed checks and errors only");
}

void add_unit(const Subcommand& subcommand, std::string& unit) {
  subcommand.option("--unit", unit, "Length unit").one_of(length_units()).show_default();
}

void add_schema(const Subcommand& subcommand, bool& ap242) {
  subcommand.enum_option(
      "--schema", {"ap214", "ap242"},
      [&ap242](const std::string& word) { ap242 = word == "ap242"; },
      "Schema of STEP files: ap214 (default) or ap242");
}

void add_step_options(const Subcommand& subcommand, StepFileArguments& step) {
  subcommand.flag("--step-curves", step.lines,
                  "Also write the input curves to the STEP file, in a product 'curves'");
  add_schema(subcommand, step.ap242);
}

int print_result(const RunReport& report, const std::string& text, const CommonOptions& common) {
  end_progress();
  if (!common.quiet) std::cout << text;
  constexpr size_t most = 10;  // lines per kind; the report lists all
  const auto list = [&](const char* label, const auto& items, const auto& text_of) {
    for (size_t i = 0; i < std::min(items.size(), most); ++i)
      std::cerr << label << ": " << text_of(items[i]) << "\n";
    if (items.size() > most)
      std::cerr << label << ": " << items.size() - most << " more, see the report\n";
  };
  list("warning", report.warnings, [](const auto& w) { return w; });
  list("check failed", report.failed_checks, [](const auto& m) { return m.what + " " + m.detail; });
  return report.failed_checks.empty() ? kDone : kCheckFailed;
}

namespace {

std::atomic<bool> signal_came = false;
std::atomic<bool> bar_is_drawn = false;
sem_t signals;  // incremented per signal; sem_post() is async-signal-safe

void count_signal(int) {
  signal_came = true;
  sem_post(&signals);
}

// Waits for a signal, then up to 0.3 s for another one; then ends the program.
void watch(int exit_code) {
  while (sem_wait(&signals) != 0) {
  }
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += 300'000'000;
  until.tv_sec += until.tv_nsec / 1'000'000'000;
  until.tv_nsec %= 1'000'000'000;
  sem_timedwait(&signals, &until);
  remove_temporary_files();
  end_progress();
  std::fputs("batten: cancelled\n", stderr);
  std::_Exit(exit_code);
}

void draw(std::string_view stage, double fraction) {
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int done = static_cast<int>(fraction * kWidth);
  const std::string bar = std::string(done, '#') + std::string(kWidth - done, '.');
  // "\033[K" erases the rest of a longer previous line.
  std::fprintf(stderr, "\r[%s] %3.0f %%  %.*s\033[K", bar.c_str(), 100 * fraction,
               static_cast<int>(std::min<size_t>(stage.size(), 40)), stage.data());
  std::fflush(stderr);
  bar_is_drawn = true;
}

}  // namespace

void catch_interrupts(int exit_code) {
  sem_init(&signals, 0, 0);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, count_signal);
  std::thread(watch, exit_code).detach();
}

bool interrupted() { return signal_came; }

Progress terminal_progress(bool quiet) {
  Progress progress;
  progress.cancelled = interrupted;
  if (quiet || !isatty(STDERR_FILENO)) return progress;
  using Clock = std::chrono::steady_clock;
  progress.report = [next = Clock::now() + std::chrono::seconds(1), last = std::string()](
                        std::string_view stage, double fraction) mutable {
    const auto now = Clock::now();
    // If a bar is drawn already, a new stage shows at once: it may be a long one without progress
    // steps.
    if (now < next && !(bar_is_drawn && stage != last)) return;
    draw(stage, fraction);
    last = stage;
    next = now + std::chrono::milliseconds(100);
  };
  return progress;
}

void end_progress() {
  if (bar_is_drawn) std::fprintf(stderr, "\r\033[K");
  bar_is_drawn = false;
}

// `batten run` and `batten stress`.

namespace {

struct SceneArguments {
  std::string file, out;
  std::vector<std::string> settings;
  StressTask stress;
};

Subcommand add_scene(CommandLine& program, const char* name, const char* what, SceneArguments& a,
                     CommonOptions& common) {
  const Subcommand subcommand = program.command(name, what);
  subcommand.option("scene", a.file, "Scene (.toml)").required();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: NAME=VALUE")
      .allow_repeated();
  add_common(subcommand, common);
  return subcommand;
}

int run(const SceneArguments& a, const CommonOptions& common) {
  const auto done = [&](const auto& report) {
    return print_result(report, summary(report, a.out), common);
  };
  const Progress progress = terminal_progress(common.quiet);
  return visit_scene(a.file, [&](auto& scene) {
    if constexpr (requires { scene.set("", 0.0, ""); }) apply_settings(scene, a.settings);
    return done(run_any_scene(scene, a.out, progress));
  });
}

int stress(const SceneArguments& a, const CommonOptions& common) {
  const auto processes = connect_mpi_processes();
  if (processes && processes->is_worker()) {
    processes->serve();
    return kDone;
  }
  StressTask task = a.stress;
  if (processes) task.factors = processes->solvers();
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  const auto report = run_stress(scene, a.out, task, terminal_progress(common.quiet));
  return print_result(report, summary(report, a.out), common);
}

}  // namespace

Command add_run(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand =
      add_scene(program, "run", "Compute a scene and write all its outputs", *a, common);
  return {subcommand, [a, &common] { return run(*a, common); }};
}

Command add_stress(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand = add_scene(
      program, "stress", "Run a scene, then analyse the surface as a thin shell (needs [stress])",
      *a, common);
  const CommandOption with_ccx =
      subcommand.flag("--with-ccx", a->stress.with_calculix,
                      "Cross-check: analyse the same shell with CalculiX and print its results");
  using Element = ShellDeck::Element;
  subcommand
      .indexed_enum_option(
          "--ccx-elements",
          {{"S6", int(Element::S6)}, {"S3", int(Element::S3)}, {"S8R", int(Element::S8R)}},
          [a](int element) { a->stress.element = Element(element); },
          "Element type for CalculiX: S6, S3 or S8R")
      .needs(with_ccx);
  subcommand
      .option("--accuracy", a->stress.accuracy,
              "Refine the mesh until the estimated relative error of the displacements is below "
              "this value (0.01: 1 %)")
      .positive();
  return {subcommand, [a, &common] { return stress(*a, common); }};
}

// `batten sculpt`.

namespace {

struct SculptArguments {
  std::string file, out;
  SculptTask task;
};

}  // namespace

Command add_sculpt(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<SculptArguments>();
  SculptArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "sculpt", "Solve a scene's surface under its loads; parameter sweeps, dynamics, refinement");
  subcommand.option("scene", a.file, "Scene (.toml)").required();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  subcommand.option("--set", a.task.settings, "Set a parameter: NAME=VALUE").allow_repeated();
  const CommandOption sweep =
      subcommand
          .option("--sweep", a.task.sweeps,
                  "Solve at COUNT values (2 to 1000) of a parameter, each starting from the "
                  "previous solution: NAME=FROM:TO:COUNT")
          .allow_repeated();
  const CommandOption time = subcommand.option(
      "--time", a.task.time, "Simulate the motion from the converged shape until this time");
  const CommandOption dt = subcommand.option("--dt", a.task.dt, "Time step of the motion");
  time.positive().needs(dt);
  dt.positive().needs(time);
  subcommand.option("--frames", a.task.frames, "Maximum number of output frames of a motion")
      .in_range(1, 1000)
      .show_default();
  const CommandOption refinement =
      subcommand.option("--refine", a.task.refinement,
                        "Bisect elements at curvature jumps, in 1 to 20 iterations: "
                        "jumps:ITERATIONS");
  subcommand
      .flag("--stress", a.task.stress,
            "Compute the maximum displacement and stress of the shell of [stress] at each value "
            "of a sweep")
      .needs(sweep);
  const CommandOption record =
      subcommand.option("--record", a.task.record, "Write all operations to this log file");
  subcommand.option("--replay", a.task.replay, "Replay a file written by --record")
      .excludes(sweep)
      .excludes(time)
      .excludes(refinement)
      .excludes(record);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const Report report = run_sculpt(read_scene(arguments->file), arguments->task,
                                             arguments->out, terminal_progress(common.quiet));
            return print_result(report, sculpt_summary(report, arguments->out), common);
          }};
}

// `batten run-script`.

Command add_run_script(CommandLine& program, CommonOptions& common) {
  const auto file = std::make_shared<std::string>();
  const Subcommand subcommand =
      program.command("run-script", "Run a script of editing commands, as saved by batten-studio");
  subcommand.option("script", *file, "Script: open, add, set, slide, solve, undo, save, export, …")
      .required();
  add_common(subcommand, common);
  return {subcommand, [file, &common] {
            const ScriptReport report = run_script(*file, terminal_progress(common.quiet));
            std::string text = report.name + "\n";
            text += summary_line("script", format_count(report.commands, "command")) + report.shape;
            for (const std::string& written : report.files) text += summary_line("file", written);
            return print_result(report, text, common);
          }};
}

// `batten deform` and `batten sequence`.

namespace {

struct EditArguments {
  std::string file, out;
  std::vector<std::string> settings;
  SequenceTask sequence;
};

}  // namespace

Command add_deform(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("deform", "Morph a mesh; its form features keep their shape exactly");
  subcommand.option("scene", a.file, "Deform scene (.toml)").required();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: NAME=VALUE")
      .allow_repeated();
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            DeformScene scene = read_deform_scene(arguments->file);
            apply_settings(scene, arguments->settings);
            const auto report = run_deform(scene, arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_sequence(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "sequence", "Edit a mesh sequence: keyframes, foot plants, paths; mix, filter, morph");
  subcommand.option("scene", a.file, "Sequence scene (.toml)").required();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  subcommand.parsed_option(
      "--frames",
      [arguments](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = parse_number(text.substr(0, colon)),
                   last = colon == std::string::npos ? first : parse_number(text.substr(colon + 1));
        if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
          return "found " + text + ", expected FIRST:LAST, with FIRST from 1 and LAST not below it";
        arguments->sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
        return std::string();
      },
      "Compute only these frames, FIRST:LAST, counted from 1 (to split the work over a job "
      "array)");
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report = run_sequence(read_sequence_scene(arguments->file), arguments->out,
                                             arguments->sequence, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

// `batten fair`.

namespace {

struct FairArguments {
  std::string file, out, minimize, unit = "mm", picture, report;
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
  SceneFairStage stage;
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
  if (!a.minimize.empty())
    stage.minimum = a.minimize == "bending" ? CurveFunctional::Energy : CurveFunctional::Variation;
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
  const Subcommand subcommand = program.command("fair", "Fair (smooth) drawn or measured curves");
  subcommand
      .option("curves", a.file, "Curves: .curves .csv .txt .xyz .dat .obj .iges .step .dxf .svg")
      .required();
  subcommand
      .option("--out", a.out,
              "Output file; its extension selects the format: " +
                  comma_separated(curve_file_extensions()))
      .required();
  const CommandOption noise =
      subcommand.option("--noise", a.noise,
                        "Known noise level: the fairest curve whose RMS distance from the points "
                        "is this length");
  const CommandOption deviation = subcommand.option(
      "--deviation", a.deviation, "Maximum distance of the fair curve from any point");
  const CommandOption wavelength = subcommand.option(
      "--wavelength", a.wavelength,
      "Smooth waves shorter than this length (default: estimated by cross-validation)");
  noise.positive().excludes(deviation).excludes(wavelength);
  deviation.positive().excludes(wavelength);
  wavelength.positive();
  subcommand
      .option("--minimize", a.minimize,
              "Interpolate all points (a few) by the curve of minimum bending energy, or of "
              "minimum curvature variation, instead of smoothing")
      .one_of({"bending", "variation"})
      .excludes(noise)
      .excludes(deviation)
      .excludes(wavelength);
  subcommand
      .option("--corner-angle", a.corner_angle,
              "Corner angle in degrees: a curve has a corner where it turns by more (180: no "
              "corners)")
      .in_range(1e-3, 180.0)
      .show_default();
  subcommand.flag("--fix-ends", a.fix_ends, "Keep the first and last point of each curve fixed");
  const CommandOption closed =
      subcommand.flag("--closed", a.closed, "Treat all curves as closed (default: detected)");
  subcommand.flag("--open", a.open, "Treat all curves as open (default: detected)")
      .excludes(closed);
  subcommand.flag("--keep-outliers", a.keep_outliers,
                  "Do not reject points that lie off a noisy curve");
  subcommand
      .option("--segments", a.segments,
              "Finally approximate the fair curve by as few segments as possible within this "
              "distance")
      .positive();
  subcommand.option("--only", a.only, "Name of a curve to fair (may be repeated; default: all)")
      .allow_repeated();
  subcommand.option("--picture", a.picture,
                    "Picture to write (.png): curvature combs before and after");
  subcommand.option("--report", a.report, "Report to write (.json)");
  add_unit(subcommand, a.unit);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] { return fair(*arguments, common); }};
}

// `batten skin`, `batten info` and `batten view`, which take files of curves.

namespace {

struct LineArguments {
  std::string file, out, unit = "mm", screenshot, compare, show = "shaded", picture, alternatives;
  std::vector<std::string> files, inner, settings;
  std::vector<double> angles;
  double edge_length = 0, tolerance = 0, gap_tolerance = 0, pressure = 0;
  int contours = 0;
  bool exact_step = false;
  StepFileArguments step;
};

Scene lines_scene(const LineArguments& a) {
  Scene scene =
      scene_of_lines({a.files.begin(), a.files.end()}, {a.inner.begin(), a.inner.end()}, a.unit);

  scene.skin.options.edge_length = a.edge_length;
  scene.skin.options.tolerance = a.tolerance;
  scene.network.tolerance = a.gap_tolerance;
  scene.compare = a.compare;
  scene.step_lines = a.step.lines;
  scene.step_ap242 = a.step.ap242;
  if (a.exact_step) scene.step_form = Scene::StepForm::Exact;
  if (a.pressure != 0) {
    SceneLoad load;
    load.name = "pressure";
    load.value = a.pressure;
    scene.loads.push_back(load);
  }
  return scene;
}

int info(LineArguments a) {
  if (!a.alternatives.empty()) {
    a.files = {a.file};
    std::cout << draw_alternatives(a.alternatives,
                                   a.file.ends_with(".toml") ? read_scene(a.file) : lines_scene(a));
    return kDone;
  }
  std::cout << file_info(a.file, a.unit);
  if (!a.picture.empty()) draw_lines(a.picture, a.file, a.unit);
  return kDone;
}

int view(LineArguments a, const CommonOptions& common) {
  Scene scene;
  if (a.file.ends_with(".toml")) {
    scene = read_scene(a.file);
    apply_settings(scene, a.settings);
  } else {
    a.files = {a.file};
    scene = lines_scene(a);
  }
  PictureScene look;
  using Field = PictureScene::Field;
  look.title = scene.name;
  look.field = a.show == "shaded"           ? Field::None
               : a.show == "mean_curvature" ? Field::Mean
               : a.show == "faces"          ? Field::Regions
                                            : Field::Gauss;
  look.contours = a.contours;
  if (!a.angles.empty()) {
    look.azimuth = a.angles[0];
    look.elevation = a.angles[1];
  }
  view_scene(scene, look, a.screenshot, terminal_progress(common.quiet));
  end_progress();
  if (!common.quiet) std::cout << a.screenshot << "\n";
  return kDone;
}

}  // namespace

Command add_skin(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("skin", "Fit smooth surfaces through curves: STEP, VTK, report");
  subcommand
      .option("curves", a.files,
              "Curves: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg .json")
      .required();
  subcommand
      .option("--inner", a.inner,
              "File of inner curves, which lie on a face but do not bound one (may be repeated)")
      .allow_repeated();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  add_unit(subcommand, a.unit);
  subcommand
      .option("--edge-length", a.edge_length,
              "Target edge length of the elements (default: 1/20 of the size of a single face, "
              "1/40 of that of a model)")
      .positive();
  subcommand
      .option("--fit-tolerance", a.tolerance,
              "Maximum distance of the surface from the input curves (default: 1e-4 of the size)")
      .positive();
  subcommand
      .option("--gap-tolerance", a.gap_tolerance,
              "Gaps between curves up to this length are closed (default: detected)")
      .positive();
  subcommand.option("--compare", a.compare,
                    "CAD file to compare with: measure the distance from its faces");
  subcommand.flag("--exact-step", a.exact_step,
                  "Write the exact surface to STEP: three STEP faces per element instead of one "
                  "fitted STEP face per face");
  add_step_options(subcommand, a.step);
  subcommand.option("--pressure", a.pressure, "Pressure along the normal, in relative units");
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report =
                run_scene(lines_scene(*arguments), arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_info(CommandLine& program) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "info", "Show the contents of a scene, a curve file, a mesh, a mesh sequence or a CAD file");
  subcommand.option("file", a.file, "File to read").required();
  subcommand.option("--picture", a.picture,
                    "Picture to write (.png): the curves with their curvature combs");
  subcommand.option(
      "--alternatives", a.alternatives,
      "Curve networks: draw every ambiguous face and its alternatives into this folder, and print "
      "the TOML that selects them");
  add_unit(subcommand, a.unit);
  return {subcommand, [arguments] { return info(*arguments); }};
}

Command add_view(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("view", "Draw a picture of the surface of a scene or of a curve file");
  subcommand.option("file", a.file, "Scene (.toml) or curve file").required();
  subcommand.option("--screenshot", a.screenshot, "Picture to write (.png)").required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: NAME=VALUE")
      .allow_repeated();
  subcommand.option("--show", a.show, "What to show")
      .one_of({"shaded", "mean_curvature", "gauss_curvature", "faces"})
      .show_default();
  subcommand.option("--contours", a.contours, "Number of contour lines (default: 0)")
      .in_range(0, 1000);
  subcommand.option("--view", a.angles, "Azimuth and elevation of the view, in degrees").count(2);
  add_unit(subcommand, a.unit);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] { return view(*arguments, common); }};
}

// `batten convert`.

Command add_convert(CommandLine& program, CommonOptions& common) {
  const auto task = std::make_shared<ConvertTask>();
  const Subcommand subcommand = program.command(
      "convert", "Convert a file: CAD to CAD or to triangles, mesh to mesh, curves to curves");
  const auto unit = [&](const char* name, std::string& value, const char* what) {
    subcommand.option(name, value, what).with_alias("inch", "in").one_of(length_units());
  };
  subcommand.option("from", task->from, "File to read: STEP, IGES, BREP, a mesh or curves")
      .required();
  subcommand
      .option("to", task->to,
              "File to write; its extension selects the format: .step .iges .brep .glb .3mf .stl "
              ".obj .ply .off .vtp .vtu .csv .curves .dxf .svg")
      .required();
  unit("--unit", task->unit,
       "Length unit of the written file; the geometry is scaled accordingly (default: as read)");
  unit("--from-unit", task->from_unit,
       "Length unit of a mesh or of points, whose files state none (required for .glb and .3mf)");
  add_schema(subcommand, task->ap242);
  subcommand
      .option("--chord", task->chord,
              "Triangulation of CAD faces: maximum distance of the triangles from the faces "
              "(default: 0.001 of the size)")
      .positive();
  add_common(subcommand, common);
  return {subcommand, [task, &common] {
            const ConvertReport report = run_convert(*task, terminal_progress(common.quiet));
            return print_result(report, report.text, common);
          }};
}

// `batten fit`.

namespace {

struct FitArguments {
  std::string target, out, unit = "mm";
  std::vector<std::string> lines;
  double tolerance = 0, edge_length = 0, meet = 0;
  bool cage = false;
  StepFileArguments step;
};

Scene scene_of(const FitArguments& a) {
  Scene scene = scene_of_target(a.target, {a.lines.begin(), a.lines.end()}, a.unit);
  scene.targets.front().tolerance = scene.step_tolerance = a.tolerance;
  scene.targets.front().cage = a.cage;
  scene.skin.options.edge_length = a.edge_length;
  scene.step_lines = a.step.lines;
  scene.step_ap242 = a.step.ap242;
  if (a.meet > 0) scene.network.tolerance = a.meet;
  return scene;
}

}  // namespace

Command add_fit(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FitArguments>();
  FitArguments& a = *arguments;
  const Subcommand subcommand = program.command(
      "fit", "Fit a sculptable smooth surface to a CAD model or a mesh: STEP, VTK, report");
  subcommand
      .option("target", a.target, "Target surface: .step .iges .brep, or a mesh (.stl .obj .ply …)")
      .required();
  subcommand
      .option("--curves", a.lines,
              "Curve file with the curves to keep (may be repeated; default: the edges of the CAD "
              "model, or the creases and free edges of the mesh)")
      .allow_repeated();
  subcommand.option("--out", a.out, "Output folder for all files, including report.json")
      .required();
  add_unit(subcommand, a.unit);
  subcommand
      .option("--fit-tolerance", a.tolerance,
              "Maximum distance from the target surface (default: 1e-4 of the size)")
      .positive();
  subcommand.flag("--cage", a.cage,
                  "The mesh is a control cage: fit its Catmull-Clark limit surface");
  subcommand
      .option("--edge-length", a.edge_length,
              "Initial target edge length of the elements (default: 1/40 of the size)")
      .positive();
  subcommand
      .option("--gap-tolerance", a.meet,
              "Gaps between curves up to this length are closed (default: detected)")
      .positive();
  add_step_options(subcommand, a.step);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] {
            const auto report =
                run_scene(scene_of(*arguments), arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

}  // namespace batten
