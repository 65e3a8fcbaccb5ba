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

#include "batten/apps/commands/documents/document.h"
#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/apps/commands/info.h"
#include "batten/apps/commands/lines/run_fair.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/run_any_scene.h"
#include "batten/apps/commands/runs/mpi_processes.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/apps/commands/shapes/run_sculpt.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/scene/read_scene.h"

namespace batten {

void add_common(const Subcommand& subcommand, CommonOptions& common) {
  subcommand.option("--threads", common.threads, "Threads to use; the number of cores unless given")
      .in_range(1, 1024);
  subcommand
      .option("--memory", common.memory,
              "GB that may be used; what is there unless given. More is refused beforehand")
      .positive();
  subcommand.flag("--quiet", common.quiet, "Print errors only");
}

void add_unit(const Subcommand& subcommand, std::string& unit) {
  subcommand.option("--unit", unit, "Unit of lengths").one_of(length_units()).show_default();
}

void add_schema(const Subcommand& subcommand, bool& ap242) {
  subcommand.enum_option(
      "--schema", {"ap214", "ap242"},
      [&ap242](const std::string& word) { ap242 = word == "ap242"; }, "Of STEP: ap214 or ap242");
}

void add_step_options(const Subcommand& subcommand, StepFileArguments& step) {
  subcommand.flag("--step-lines", step.lines,
                  "The STEP file holds the lines too, as curves in a product 'lines'");
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
      std::cerr << label << ": and " << items.size() - most << " more (the report has all)\n";
  };
  list("warning", report.warnings, [](const auto& w) { return w; });
  list("promise missed", report.failed_checks,
       [](const auto& m) { return m.what + " " + m.detail; });
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
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: name=value")
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
  const auto processes = MpiProcesses::detect();
  if (processes && processes->is_worker()) {
    processes->serve();
    return kDone;
  }
  StressTask task = a.stress;
  if (processes) task.factors = processes->factors();
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  const auto report = run_stress(scene, a.out, task, terminal_progress(common.quiet));
  return print_result(report, summary(report, a.out), common);
}

}  // namespace

Command add_run(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand =
      add_scene(program, "run", "Do everything a scene asks for", *a, common);
  return {subcommand, [a, &common] { return run(*a, common); }};
}

Command add_stress(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  const Subcommand subcommand =
      add_scene(program, "stress",
                "The same, and the stresses of the shape as the shell of [stress]", *a, common);
  const CommandOption with_ccx =
      subcommand.flag("--with-ccx", a->stress.with_calculix,
                      "Run CalculiX on the same shell, and print what it finds");
  using Element = ShellDeck::Element;
  subcommand
      .indexed_enum_option(
          "--ccx-elements",
          {{"S6", int(Element::S6)}, {"S3", int(Element::S3)}, {"S8R", int(Element::S8R)}},
          [a](int element) { a->stress.element = Element(element); }, "Its elements: S6, S3 or S8R")
      .needs(with_ccx);
  subcommand
      .option("--accuracy", a->stress.accuracy,
              "Make elements smaller until displacements are this exact: 0.01 is a percent")
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
      "sculpt", "Settle, sweep, move and refine a scene's surface under live loads");
  subcommand.option("scene", a.file, "Scene (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.task.settings, "Set a parameter: name=value").allow_repeated();
  const CommandOption sweep =
      subcommand
          .option("--sweep", a.task.sweeps,
                  "Settle at so many values, each from the one before: name=from:to:count")
          .allow_repeated();
  const CommandOption time = subcommand.option(
      "--time", a.task.time, "Motion from the settled shape, until this time; needs --dt");
  const CommandOption dt = subcommand.option("--dt", a.task.dt, "Step of the motion; needs --time");
  time.positive().needs(dt);
  dt.positive().needs(time);
  subcommand.option("--frames", a.task.frames, "Most frames of a motion")
      .in_range(1, 1000)
      .show_default();
  const CommandOption refinement =
      subcommand.option("--refine", a.task.refinement,
                        "Halve triangles where curvature jumps, so many rounds: jumps:ROUNDS");
  subcommand
      .flag("--stress", a.task.stress,
            "Largest displacement and stress of the shell of [stress], at each value of a sweep")
      .needs(sweep);
  const CommandOption record =
      subcommand.option("--record", a.task.record, "Write everything that was done to this file");
  subcommand.option("--replay", a.task.replay, "Do what such a file says")
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
  const Subcommand subcommand = program.command(
      "run-script", "Do again what was done to a scene in batten-studio, command by command");
  subcommand.option("script", *file, "Script: open, add, set, slide, settle, undo, save, export, …")
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
      program.command("deform", "Edit a mesh; its form features keep their shape exactly");
  subcommand.option("edits", a.file, "Edits of a mesh (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.option("--set", a.settings, "Set a parameter of the edits: name=value")
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
      "sequence", "Edit a deforming mesh: keyframes, footprints, paths; mix, filter, morph");
  subcommand.option("edits", a.file, "Edits of a sequence (.toml)").required();
  subcommand.option("--out", a.out, "Folder for all files, report.json too").required();
  subcommand.parsed_option(
      "--frames",
      [arguments](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = parse_number(text.substr(0, colon)),
                   last = colon == std::string::npos ? first : parse_number(text.substr(colon + 1));
        if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
          return "found " + text + ", expected FIRST:LAST";
        arguments->sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
        return std::string();
      },
      "Make these frames only, FIRST:LAST from 1: runs of a job array share the work");
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
  subcommand.option("--out", a.out, "File to write: " + comma_separated(curve_file_extensions()))
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

// `batten skin`, `batten info` and `batten view`, which take files of curves.

namespace {

struct LineArguments {
  std::string file, out, unit = "mm", screenshot, compare, show = "shaded", picture, alternatives;
  std::vector<std::string> files, inner, settings;
  std::vector<double> angles;
  double edge_length = 0, tolerance = 0, gap_tolerance = 0, pressure = 0;
  int contours = 0;
  bool network = false, exact_step = false;
  StepFileArguments step;
};

Scene lines_scene(const LineArguments& a) {
  Scene scene =
      scene_of_lines({a.files.begin(), a.files.end()}, {a.inner.begin(), a.inner.end()}, a.unit);
  if (a.network)
    scene.notes.push_back(
        "--network is not needed any more, since what curves bound is always found: leave it out");
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
               : a.show == "regions"        ? Field::Regions
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
      program.command("skin", "From files of curves straight to surfaces: STEP, VTK, report");
  subcommand
      .option("lines", a.files,
              "Curves: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg .json")
      .required();
  subcommand.option("--inner", a.inner, "A file of curves that lie on a surface and bound none")
      .allow_repeated();
  subcommand.flag("--network", a.network, "").hidden();
  subcommand.option("--out", a.out, "Folder for all files").required();
  add_unit(subcommand, a.unit);
  subcommand.option("--edge-length", a.edge_length, "Target length of element edges").positive();
  subcommand.option("--tolerance", a.tolerance, "Largest distance of fitted lines").positive();
  subcommand
      .option("--gap-tolerance", a.gap_tolerance,
              "Distance within which curves meet; found unless given")
      .positive();
  subcommand.option("--compare", a.compare, "CAD file: measure the distance from its faces");
  subcommand.flag("--exact-step", a.exact_step,
                  "STEP to rounding, three faces a triangle, instead of one face a region");
  add_step_options(subcommand, a.step);
  subcommand.option("--pressure", a.pressure, "Pressure along the normal, relative units");
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
      "info", "What is in a scene, a file of lines, a mesh, a deforming mesh, a STEP file");
  subcommand.option("file", a.file, "The file").required();
  subcommand.option("--picture", a.picture, "Draw its lines with their curvature, to a .png");
  subcommand.option(
      "--choices", a.alternatives,
      "Draw surfaces that could as well be others, into this folder, and say what to write");
  add_unit(subcommand, a.unit);
  return {subcommand, [arguments] { return info(*arguments); }};
}

Command add_view(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  const Subcommand subcommand =
      program.command("view", "A picture of a scene's or a line file's surface");
  subcommand.option("file", a.file, "Scene (.toml) or file of lines").required();
  subcommand.option("--screenshot", a.screenshot, "The picture to write (.png)").required();
  subcommand.option("--set", a.settings, "Set a parameter of the scene: name=value")
      .allow_repeated();
  subcommand.option("--show", a.show, "What to show")
      .one_of({"shaded", "mean_curvature", "gauss_curvature", "regions"})
      .show_default();
  subcommand.flag("--network", a.network, "").hidden();
  subcommand.option("--contours", a.contours, "Number of contour lines").in_range(0, 1000);
  subcommand.option("--view", a.angles, "Azimuth and elevation, degrees").count(2);
  add_unit(subcommand, a.unit);
  add_common(subcommand, common);
  return {subcommand, [arguments, &common] { return view(*arguments, common); }};
}

// `batten convert`.

Command add_convert(CommandLine& program, CommonOptions& common) {
  const auto task = std::make_shared<ConvertTask>();
  const Subcommand subcommand = program.command(
      "convert",
      "A file of another kind: CAD to CAD or to triangles, meshes to meshes, lines to lines");
  const auto unit = [&](const char* name, std::string& value, const char* what) {
    subcommand.option(name, value, what).with_alias("inch", "in").one_of(length_units());
  };
  subcommand.option("from", task->from, "STEP, IGES, BREP, a mesh, lines").required();
  subcommand
      .option("to", task->to,
              "Its ending says the kind: .step .iges .brep .glb .3mf .stl .obj .ply .off .vtp .vtu "
              ".csv .curves")
      .required();
  unit("--unit", task->unit, "Unit of the file that is written: it is scaled, and declares it");
  unit("--from-unit", task->from_unit,
       "Unit of a mesh or of points, which state none; .glb and .3mf need it");
  add_schema(subcommand, task->ap242);
  subcommand
      .option("--chord", task->chord,
              "Triangles of CAD faces: their largest distance from the faces; a thousandth of "
              "the size unless given")
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
      "fit",
      "Skin the lines of a given surface again, so that it can be sculpted: STEP, VTK, report");
  subcommand
      .option("target", a.target, "The surface: .step .iges .brep, or a mesh (.stl .obj .ply …)")
      .required();
  subcommand
      .option("--lines", a.lines,
              "Lines to keep; unless given, the edges of the CAD file, or the creases "
              "and rims of the mesh")
      .allow_repeated();
  subcommand.option("--out", a.out, "Folder for all files").required();
  add_unit(subcommand, a.unit);
  subcommand
      .option("--tolerance", a.tolerance, "Largest distance from the surface; 1e-4 of the size")
      .positive();
  subcommand.flag("--cage", a.cage,
                  "The mesh is a cage of polygons: fit to its Catmull-Clark limit surface");
  subcommand.option("--edge-length", a.edge_length, "Target length of element edges at the start")
      .positive();
  subcommand
      .option("--gap-tolerance", a.meet, "Distance within which curves meet; found unless given")
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
