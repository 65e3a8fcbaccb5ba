// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/commands.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "batten/apps/cli/process.h"
#include "batten/apps/documents/document.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/fit_surface.h"
#include "batten/scenes/runs/plugins.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

void add_common(Subcommand& subcommand, CommonOptions& common) {
  subcommand.group("General");
  subcommand.option("--threads COUNT", common.threads, "number of threads, 1 to 1024")
      .in_range(1, 1024)
      .default_text("number of cores");
  subcommand
      .option("--memory GB", common.memory,
              "memory limit; jobs that would exceed it are rejected at the start")
      .positive()
      .default_text("available memory");
  subcommand.flag("--in-place", common.in_place, "output files may replace input files");
  subcommand.flag("--quiet", common.quiet, "print only warnings, failed checks and errors");
}

void add_unit(const Subcommand& subcommand, std::string& unit, const std::string& text) {
  subcommand.option("--unit", unit, text).one_of(length_units()).default_text(unit);
}

void add_schema(const Subcommand& subcommand, bool& ap242) {
  subcommand
      .enum_option(
          "--schema", {"ap214", "ap242"},
          [&ap242](const std::string& word) { ap242 = word == "ap242"; }, "schema of STEP files")
      .default_text("ap214");
}

void add_step_options(const Subcommand& subcommand, StepFileArguments& step) {
  subcommand.flag("--step-curves", step.lines,
                  "also write the input curves to the STEP file, in a product 'curves'");
  add_schema(subcommand, step.ap242);
}

namespace {

// Options that several commands have.

constexpr char kSetText[] = "set a parameter of the scene, with a number as the value";

void add_out(const Subcommand& subcommand, std::string& out) {
  subcommand.option("--out FOLDER", out, "output folder for all files, including report.json")
      .required()
      .folder();
}

void add_edge_length(const Subcommand& subcommand, double& length, const std::string& otherwise) {
  subcommand.option("--edge-length LENGTH", length, "target edge length of the elements")
      .positive()
      .default_text(otherwise);
}

void add_gap_tolerance(const Subcommand& subcommand, double& tolerance) {
  subcommand
      .option("--gap-tolerance LENGTH", tolerance,
              "gaps between curves up to this length are closed")
      .positive()
      .default_text("detected");
}

}  // namespace

int print_result(const RunReport& report, const std::string& text, const CommonOptions& common) {
  end_progress();
  if (!common.quiet) print(text);
  constexpr size_t most = 10;  // lines per kind; the report lists all
  const auto list = [&](const char* label, const auto& items, const auto& text_of) {
    for (size_t i = 0; i < std::min(items.size(), most); ++i)
      std::cerr << label << ": " << printable(text_of(items[i])) << "\n";
    if (items.size() > most)
      std::cerr << label << ": " << items.size() - most << " more, see the report\n";
  };
  list("warning", report.warnings, [](const auto& w) { return w; });
  list("check failed", report.failed_checks, [](const auto& m) { return m.what + " " + m.detail; });
  return report.failed_checks.empty() ? kDone : kCheckFailed;
}

// Headings of the commands in the help of the program.
namespace {
constexpr char kSurfaces[] = "Surfaces", kFiles[] = "Files and pictures";
}  // namespace

// `batten run` and `batten stress`.

namespace {

struct SceneArguments {
  std::string file, out;
  std::vector<std::string> settings;
  StressTask stress;
};

Subcommand add_scene(CommandLine& program, const char* name, const char* group, const char* what,
                     SceneArguments& a) {
  Subcommand subcommand = program.command(name, group, what);
  subcommand.option("SCENE", a.file, "scene file (.toml)").required();
  add_out(subcommand, a.out);
  subcommand.group("Parameters");
  subcommand.option("--set NAME=VALUE", a.settings, kSetText).allow_repeated();
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
  Subcommand subcommand =
      add_scene(program, "run", kSurfaces, "compute a scene and write all its outputs", *a);
  add_common(subcommand, common);
  subcommand.example("batten run examples/05-door/scene.toml --out out/door",
                     "surface, STEP file and pictures of a car door");
  subcommand.example("batten run examples/05-door/scene.toml --out out/swollen --set swell=250",
                     "the same door under a larger pressure");
  subcommand.example("batten run examples/10-plate-with-holes/turned.toml --out out/plate",
                     "scenes of mesh edits, mesh sequences and curves run, too");
  return {subcommand, [a, &common] { return run(*a, common); }};
}

Command add_stress(CommandLine& program, CommonOptions& common) {
  const auto a = std::make_shared<SceneArguments>();
  Subcommand subcommand =
      add_scene(program, "stress", kSurfaces,
                "run a scene, and analyse its surface as a shell (needs [stress])", *a);
  subcommand.group("Analysis");
  subcommand
      .option("--accuracy NUMBER", a->stress.accuracy,
              "refine the mesh until the estimated relative errors of the displacements and of the "
              "largest stresses are below this value (0.01 is 1 %), or fail; 0: no refinement")
      .in_range(0.0, 1.0)
      .default_text("0.02, with a limited number of unknowns");
  subcommand.flag("--animations", a->stress.animations,
                  "draw an animation (GIF) of each natural mode and buckling mode");
  const CommandOption with_ccx =
      subcommand.flag("--with-ccx", a->stress.with_calculix,
                      "cross-check: analyse the same shell with CalculiX and print its results");
  using Element = ShellDeck::Element;
  subcommand
      .enum_option(
          "--ccx-elements", {"S6", "S3", "S8R"},
          [a](const std::string& name) {
            a->stress.element = name == "S3"    ? Element::S3
                                : name == "S8R" ? Element::S8R
                                                : Element::S6;
          },
          "element type for CalculiX")
      .needs(with_ccx)
      .default_text("S6");
  add_common(subcommand, common);
  subcommand.example("batten stress examples/18-lean/scene.toml --out out/lean",
                     "stresses and natural frequencies of a car door under 100 N");
  subcommand.example(
      "batten stress examples/07-plate-with-hole/scene.toml --out out/hole "
      "--accuracy 0.01",
      "a mesh that is refined to a relative error of 1 %");
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
  Subcommand subcommand = program.command(
      "sculpt", kSurfaces, "solve for series of parameter values, or simulate a motion");
  subcommand.option("SCENE", a.file, "scene file (.toml)").required();
  add_out(subcommand, a.out);
  subcommand.group("Parameters");
  subcommand.option("--set NAME=VALUE", a.task.settings, kSetText).allow_repeated();
  const CommandOption sweep =
      subcommand
          .option("--sweep NAME=FROM:TO:COUNT", a.task.sweeps,
                  "solve at COUNT values (2 to 1000) of a parameter, each starting from the "
                  "previous solution")
          .allow_repeated();
  subcommand
      .flag("--stress", a.task.stress,
            "compute the maximum displacement and stress of the shell of [stress] at each value "
            "of a sweep")
      .needs(sweep);
  subcommand.group("Motion");
  const CommandOption time = subcommand.option(
      "--time TIME", a.task.time, "simulate the motion from the converged shape until this time");
  const CommandOption dt =
      subcommand.option("--dt TIME", a.task.dt, "time step of the motion; required with --time");
  time.positive().needs(dt).default_text("no motion");
  dt.positive().needs(time).default_text("no motion");
  subcommand
      .option("--frames COUNT", a.task.frames,
              "maximum number of output frames of a motion, 1 to 1000")
      .in_range(1, 1000)
      .default_text(std::to_string(a.task.frames));
  subcommand.group("Mesh");
  const CommandOption refinement =
      subcommand
          .option("--refine jumps:ITERATIONS", a.task.refinement,
                  "bisect elements at curvature jumps, in 1 to 20 iterations")
          .default_text("no refinement");
  subcommand.group("Recording");
  const CommandOption record =
      subcommand.option("--record FILE", a.task.record, "write all operations to this log file")
          .default_text("none");
  subcommand.option("--replay FILE", a.task.replay, "replay a file written by --record")
      .excludes(sweep)
      .excludes(time)
      .excludes(refinement)
      .excludes(record)
      .default_text("none");
  add_common(subcommand, common);
  subcommand.example(
      "batten sculpt examples/05-door/sculpt.toml --out out/bolder "
      "--sweep bolder=0:1:6",
      "six doors, with a contact sheet and an animation");
  subcommand.example(
      "batten sculpt examples/06-goblet-bowl/scene.toml --out out/bowl "
      "--set swell=100",
      "one shape, for another value of a parameter");
  return {subcommand, [arguments, &common] {
            const Report report = run_sculpt(read_scene(arguments->file), arguments->task,
                                             arguments->out, terminal_progress(common.quiet));
            return print_result(report, sculpt_summary(report, arguments->out), common);
          }};
}

// `batten run-script`.

Command add_run_script(CommandLine& program, CommonOptions& common) {
  const auto file = std::make_shared<std::string>();
  Subcommand subcommand = program.command(
      "run-script", "Scripts", "run a script of editing commands, as saved by batten-studio");
  subcommand
      .option("SCRIPT", *file, "script file: open, add, set, slide, solve, undo, save, export, ...")
      .required();
  add_common(subcommand, common);
  subcommand.example("batten run-script examples/05-door/session.batten",
                     "open a scene, move a slider, add a load, and write all outputs");
  return {subcommand, [file, &common] {
            const ScriptReport report = run_script(*file, terminal_progress(common.quiet));
            std::string text = printable(report.name) + "\n";
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
  MorphTask morph;
  std::vector<std::string> derivatives;
};

}  // namespace

Command add_deform(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  Subcommand subcommand = program.command(
      "deform", "Meshes", "morph a mesh; its form features keep their shape exactly");
  subcommand.option("SCENE", a.file, "scene file of a mesh edit (.toml)").required();
  add_out(subcommand, a.out);
  subcommand.group("Parameters");
  subcommand.option("--set NAME=VALUE", a.settings, kSetText).allow_repeated();
  subcommand.group("Design studies");
  subcommand
      .option(
          "--derivatives FILE", a.derivatives,
          "write the derivatives of all nodes with respect to the parameters: .csv, .npz (NumPy), "
          "or .bdf (DESVAR and DVGRID cards for a Nastran deck)")
      .allow_repeated()
      .default_text("none");
  subcommand
      .option("--doe lhs:N|grid|FILE", a.morph.doe,
              "write a mesh for each variant of a design of experiments, and a table: a Latin "
              "hypercube of N variants, all combinations, or the rows of a CSV file")
      .default_text("none");
  subcommand
      .option("--range NAME=FROM:TO[:COUNT]", a.morph.ranges,
              "range of a parameter for --doe, with COUNT values (default 3) for a grid; "
              "--derivatives are then those of these parameters only")
      .allow_repeated()
      .default_text("none");
  add_common(subcommand, common);
  subcommand.example("batten deform examples/11-panel/edit.toml --out out/panel",
                     "a Nastran deck whose panel becomes longer; its holes keep their shape");
  subcommand.example("batten deform examples/23-assembly/longer.toml --out out/longer",
                     "an assembly with bolts and solids, made longer");
  return {subcommand, [arguments, &common] {
            DeformScene scene = read_deform_scene(arguments->file);
            apply_settings(scene, arguments->settings);
            MorphTask task = arguments->morph;
            task.derivatives.assign(arguments->derivatives.begin(), arguments->derivatives.end());
            const auto report =
                run_deform(scene, arguments->out, task, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_sequence(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<EditArguments>();
  EditArguments& a = *arguments;
  Subcommand subcommand = program.command(
      "sequence", "Meshes", "edit a mesh sequence: keyframes, foot plants, paths, filters");
  subcommand.option("SCENE", a.file, "scene file of a mesh sequence (.toml)").required();
  add_out(subcommand, a.out);
  subcommand
      .parsed_option(
          "--frames FIRST:LAST",
          [arguments](const std::string& text) {
            const size_t colon = text.find(':');
            const auto first = parse_number(text.substr(0, colon)),
                       last = colon == std::string::npos ? first
                                                         : parse_number(text.substr(colon + 1));
            if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
              return "found " + text +
                     ", expected FIRST:LAST, with FIRST from 1 and LAST not below it";
            arguments->sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
            return std::string();
          },
          "compute only these frames, counted from 1, to split the work over a job array")
      .default_text("all frames");
  add_common(subcommand, common);
  subcommand.example("batten sequence examples/24-stairs/stairs.toml --out out/stairs",
                     "a walk on the spot becomes a walk up the stairs");
  subcommand.example("batten sequence examples/29-forming/forming.toml --out out/forming",
                     "a forming simulation whose flange becomes wider, in every frame");
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
  Subcommand subcommand =
      program.command("fair", "Curves", "fair (smooth) drawn or measured curves");
  subcommand
      .option("CURVES", a.file,
              "file of curves: .curves .csv .txt .xyz .dat .obj .iges .step .dxf .svg")
      .required();
  subcommand
      .option("--out FILE", a.out,
              "output file; its extension selects the format: " +
                  comma_separated(curve_file_extensions()))
      .required();
  add_unit(subcommand, a.unit, "length unit of files that state none");
  subcommand.option("--only NAME", a.only, "fair only this curve").allow_repeated();
  subcommand.group("Smoothing");
  const CommandOption noise =
      subcommand.option("--noise LENGTH", a.noise,
                        "known noise level: the fairest curve whose RMS distance from the points "
                        "is this length");
  const CommandOption deviation = subcommand.option(
      "--deviation LENGTH", a.deviation, "maximum distance of the fair curve from any point");
  const CommandOption wavelength = subcommand.option("--wavelength LENGTH", a.wavelength,
                                                     "smooth waves shorter than this length");
  noise.positive().excludes(deviation).excludes(wavelength).default_text("estimated");
  deviation.positive().excludes(wavelength).default_text("no limit");
  wavelength.positive().default_text("estimated by cross-validation");
  subcommand
      .option("--minimize", a.minimize,
              "instead of smoothing, interpolate all points (a few) by the curve of minimum "
              "bending energy, or of minimum curvature variation")
      .one_of({"bending", "variation"})
      .excludes(noise)
      .excludes(deviation)
      .excludes(wavelength)
      .default_text("smoothing");
  subcommand.flag("--keep-outliers", a.keep_outliers,
                  "do not reject points that lie off a noisy curve");
  subcommand
      .option("--segments LENGTH", a.segments,
              "finally approximate the fair curve by as few segments as possible within this "
              "distance")
      .positive()
      .default_text("all segments");
  subcommand.group("Ends and corners");
  subcommand
      .option("--corner-angle DEGREES", a.corner_angle,
              "a curve has a corner where it turns by more than this angle; 180: no corners")
      .in_range(1e-3, 180.0)
      .default_text(format_number(a.corner_angle));
  subcommand.flag("--fix-ends", a.fix_ends, "keep the first and last point of each curve fixed");
  const CommandOption closed = subcommand.flag(
      "--closed", a.closed, "treat all curves as closed; without this option, it is detected");
  subcommand.flag("--open", a.open, "treat all curves as open; without this option, it is detected")
      .excludes(closed);
  subcommand.group("Other outputs");
  subcommand
      .option("--picture FILE", a.picture,
              "picture to write (.png): curvature combs before and after")
      .default_text("none");
  subcommand.option("--report FILE", a.report, "report to write (.json)").default_text("none");
  add_common(subcommand, common);
  subcommand.example("batten fair examples/04-fairing/swan.csv --out fair.step",
                     "a hand-drawn curve becomes a smooth B-spline");
  subcommand.example(
      "batten fair examples/04-fairing/swan.csv --out fair.csv --deviation 0.5 "
      "--picture fair.png",
      "at most 0.5 mm from the drawn points, with curvature combs");
  return {subcommand, [arguments, &common] { return fair(*arguments, common); }};
}

// `batten skin`, `batten info` and `batten view`, which take files of curves.

namespace {

struct LineArguments {
  std::string file, out, unit = "mm", screenshot, compare, show = "shaded", picture, alternatives;
  std::vector<std::string> files, inner, settings;
  std::vector<double> angles;
  std::string corners;
  double edge_length = 0, tolerance = 0, gap_tolerance = 0, corner_angle = 0, pressure = 0;
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
  if (a.corner_angle > 0) {
    scene.skin.options.corner_angle = a.corner_angle;
    scene.skin.corner_angle_is_stated = true;
  }
  for (SceneLine& line : scene.lines)
    if (!a.corners.empty()) {
      line.corners.emplace();
      line.all_corners = a.corners == "all";
    }
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
    const Scene scene = a.file.ends_with(".toml") ? read_scene(a.file) : lines_scene(a);
    print(draw_alternatives(a.alternatives, scene));
    return kDone;
  }
  print(file_info(a.file, a.unit));
  if (!a.picture.empty()) draw_lines(a.picture, a.file, a.unit);
  return kDone;
}

int view(LineArguments a, const CommonOptions& common) {
  PictureScene look;
  using Field = PictureScene::Field;
  look.field = a.show == "shaded"           ? Field::None
               : a.show == "mean_curvature" ? Field::Mean
               : a.show == "faces"          ? Field::Regions
                                            : Field::Gauss;
  look.contours = a.contours;
  if (!a.angles.empty()) {
    look.azimuth = a.angles[0];
    look.elevation = a.angles[1];
  }
  if (file_kind(a.file) == FileKind::Cad)
    if (const auto report = view_cad_faces(a.file, look, a.screenshot))
      return print_result(*report, printable(report->text) + "\n" + printable(a.screenshot) + "\n",
                          common);
  Scene scene;
  if (a.file.ends_with(".toml")) {
    scene = read_scene(a.file);
    apply_settings(scene, a.settings);
  } else {
    a.files = {a.file};
    scene = lines_scene(a);
  }
  look.unit = scene.unit;
  const RunReport report = view_scene(scene, look, a.screenshot, terminal_progress(common.quiet));
  return print_result(report, printable(a.screenshot) + "\n", common);
}

}  // namespace

Command add_skin(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  Subcommand subcommand =
      program.command("skin", kSurfaces, "fit smooth surfaces through curves: STEP, VTK, report");
  subcommand
      .option("CURVES", a.files,
              "files of curves: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg .json")
      .required();
  add_out(subcommand, a.out);
  subcommand
      .option("--inner FILE", a.inner,
              "file of inner curves, which lie on a face but do not bound one")
      .allow_repeated();
  add_unit(subcommand, a.unit, "length unit of the results, and of files that state none");
  subcommand.group("Surface");
  add_edge_length(subcommand, a.edge_length,
                  "1/20 of the size of a single face, 1/40 of that of a model");
  subcommand
      .option("--fit-tolerance LENGTH", a.tolerance,
              "maximum distance of the surface from the input curves")
      .positive()
      .default_text("1e-4 of the size");
  add_gap_tolerance(subcommand, a.gap_tolerance);
  const CommandOption corners =
      subcommand
          .option("--corners WHICH", a.corners,
                  "which points of the curves are corners: all of them and every kink, or none")
          .one_of({"all", "none"})
          .default_text("detected");
  subcommand
      .option("--corner-angle DEGREES", a.corner_angle,
              "a curve has a corner wherever it turns by more than this angle")
      .in_range(1e-3, 179.9)
      .default_text("detected")
      .excludes(corners);
  subcommand
      .option("--pressure NUMBER", a.pressure,
              "pressure along the normal, in relative units; 1 to 30 gives a slight bulge")
      .default_text("0");
  subcommand.group("Output");
  subcommand.flag("--exact-step", a.exact_step,
                  "write the exact surface to STEP: three STEP faces per element instead of one "
                  "fitted STEP face per face");
  add_step_options(subcommand, a.step);
  subcommand
      .option("--compare FILE", a.compare,
              "CAD file to compare with: measure the distance from its faces")
      .default_text("none");
  add_common(subcommand, common);
  subcommand.example("batten skin examples/05-door/lines/outline.csv --out out/panel",
                     "a smooth surface inside one closed curve");
  subcommand.example(
      "batten skin examples/05-door/lines/outline.csv --out out/ribbed "
      "--inner examples/05-door/lines/rib.csv",
      "the same, through a curve inside");
  return {subcommand, [arguments, &common] {
            const auto report =
                run_scene(lines_scene(*arguments), arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

Command add_info(CommandLine& program) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  Subcommand subcommand = program.command(
      "info", kFiles, "show the contents of a scene, or a file of curves, CAD or meshes");
  subcommand.option("FILE", a.file, "file to read").required();
  add_unit(subcommand, a.unit, "length unit of files that state none; a scene states its own");
  subcommand.group("Pictures");
  subcommand
      .option("--picture FILE", a.picture,
              "picture to write (.png): the curves with their curvature combs")
      .default_text("none");
  subcommand
      .option("--alternatives FOLDER", a.alternatives,
              "curve networks: draw every ambiguous face and its alternatives into this folder, "
              "and print the TOML that selects them")
      .default_text("none");
  subcommand.group("General");
  subcommand.example("batten info examples/05-door/scene.toml",
                     "curves, parameters, and how much each load moves the surface");
  subcommand.example("batten info examples/11-panel/panel.bdf",
                     "nodes, holes, creases and element quality of a mesh");
  subcommand.example("batten info examples/04-fairing/swan.csv --picture combs.png",
                     "a drawn curve with its curvature comb");
  return {subcommand, [arguments] { return info(*arguments); }};
}

Command add_view(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<LineArguments>();
  LineArguments& a = *arguments;
  Subcommand subcommand = program.command(
      "view", kFiles, "draw a picture of the surface of a scene or curve file, or of CAD faces");
  subcommand.option("FILE", a.file, "scene (.toml), file of curves, or CAD file").required();
  subcommand.option("--screenshot FILE", a.screenshot, "picture to write (.png)").required();
  add_unit(subcommand, a.unit, "length unit of files that state none; a scene states its own");
  subcommand.option("--set NAME=VALUE", a.settings, kSetText).allow_repeated();
  subcommand.group("View");
  subcommand.option("--show", a.show, "colours of the surface")
      .one_of({"shaded", "mean_curvature", "gauss_curvature", "faces"})
      .default_text(a.show);
  subcommand.option("--contours COUNT", a.contours, "number of height contours, 0 to 1000")
      .in_range(0, 1000)
      .default_text(std::to_string(a.contours));
  subcommand
      .option("--view DEGREES DEGREES", a.angles, "azimuth and elevation of the direction of view")
      .count(2)
      .default_text("-30 30");
  add_common(subcommand, common);
  subcommand.example("batten view examples/02-hood/scene.toml --screenshot hood.png",
                     "a picture of a car hood");
  subcommand.example(
      "batten view examples/05-door/scene.toml --screenshot door.png "
      "--show mean_curvature --view 30 20",
      "mean curvature of a door, from another direction");
  return {subcommand, [arguments, &common] { return view(*arguments, common); }};
}

// `batten convert`.

Command add_convert(CommandLine& program, CommonOptions& common) {
  const auto task = std::make_shared<ConvertTask>();
  Subcommand subcommand =
      program.command("convert", kFiles, "convert CAD to CAD or to triangles, meshes, and curves");
  const auto unit = [&](const char* name, std::string& value, const char* what,
                        const char* otherwise) {
    subcommand.option(name, value, what)
        .with_alias("inch", "in")
        .one_of(length_units())
        .default_text(otherwise);
  };
  subcommand.option("FROM", task->from, "file to read: STEP, IGES, BREP, a mesh or curves")
      .required();
  subcommand
      .option("TO", task->to,
              "file to write; its extension selects the format: .step .iges .brep .glb .3mf .stl "
              ".obj .ply .off .vtp .vtu .inp .bdf .csv .curves .dxf .svg")
      .required();
  subcommand.group("Units");
  unit("--unit", task->unit, "length unit of the written file; the geometry is scaled accordingly",
       "as read");
  unit("--from-unit", task->from_unit,
       "length unit of a mesh or of points, whose files state none; required for .glb and .3mf",
       "unknown");
  subcommand.group("Output");
  add_schema(subcommand, task->ap242);
  subcommand
      .option("--chord LENGTH", task->chord,
              "triangulation of CAD faces: maximum distance of the triangles from the faces")
      .positive()
      .default_text("0.001 of the size");
  add_common(subcommand, common);
  subcommand.example("batten convert examples/04-fairing/swan.csv swan.dxf", "points to a drawing");
  subcommand.example(
      "batten convert examples/10-plate-with-holes/plate.obj plate.3mf "
      "--from-unit mm",
      "a mesh to a file for 3-D printing");
  subcommand.example("batten convert part.step part.stl --chord 0.1",
                     "a CAD file of yours to a watertight triangle mesh, within 0.1 mm");
  return {subcommand, [task, &common] {
            const ConvertReport report = run_convert(*task, terminal_progress(common.quiet));
            return print_result(report, report.text, common);
          }};
}

// `batten fit`.

namespace {

struct FitArguments {
  std::string target, out;
  std::vector<std::string> lines;
  FitTask task;
  StepFileArguments step;
};

}  // namespace

Command add_fit(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FitArguments>();
  FitArguments& a = *arguments;
  Subcommand subcommand =
      program.command("fit", kSurfaces, "fit a sculptable smooth surface to a CAD model or a mesh");
  subcommand
      .option("TARGET", a.target,
              "file of the target surface: .step .iges .brep, or a mesh (.stl .obj .ply ...)")
      .required();
  add_out(subcommand, a.out);
  subcommand
      .option("--curves FILE", a.lines,
              "file of the curves to keep; without this option, they are the edges of the CAD "
              "model, or the creases and free edges of the mesh")
      .allow_repeated();
  add_unit(subcommand, a.task.settings.unit,
           "length unit of the results, and of files that state none");
  subcommand.group("Surface");
  subcommand
      .option("--fit-tolerance LENGTH", a.task.settings.fit_tolerance,
              "maximum distance from the target surface")
      .positive()
      .default_text("1e-4 of the size");
  subcommand.flag("--cage", a.task.settings.cage,
                  "the mesh is a control cage: fit its Catmull-Clark limit surface");
  add_edge_length(subcommand, a.task.settings.edge_length, "initially 1/40 of the size");
  add_gap_tolerance(subcommand, a.task.settings.gap_tolerance);
  subcommand.group("Output");
  add_step_options(subcommand, a.step);
  add_common(subcommand, common);
  subcommand.example("batten fit examples/30-refit/scan.obj --out out/scan --fit-tolerance 0.5",
                     "a scanned panel becomes a smooth surface within 0.5 mm");
  subcommand.example("batten fit part.step --out out/part",
                     "a CAD model of yours becomes a model that you can sculpt");
  return {subcommand, [arguments, &common] {
            FitTask& task = arguments->task;
            task.settings.curve_files.assign(arguments->lines.begin(), arguments->lines.end());
            task.step_curves = arguments->step.lines;
            task.step_ap242 = arguments->step.ap242;
            const auto report =
                run_fit(arguments->target, task, arguments->out, terminal_progress(common.quiet));
            return print_result(report, summary(report, arguments->out), common);
          }};
}

// `batten fill`.
namespace {

struct FillArguments {
  std::string part, out;
  std::vector<std::string> inner;
  std::vector<double> openings;
  FillTask task;
  StepFileArguments step;
};

// Options of `batten fill` and `batten blend`.
void add_given_faces(Subcommand& subcommand, FillArguments& a) {
  subcommand
      .option("PART", a.part,
              "CAD file (.step .iges .brep) or mesh (.stl .obj .ply, decks) with the faces")
      .required();
  add_out(subcommand, a.out);
  add_unit(subcommand, a.task.unit, "length unit of the results");
}

void add_face_selection(Subcommand& subcommand, FillArguments& a) {
  subcommand
      .option("--replace FACE", a.task.replaced,
              "face to leave out, such as \"face 3\" in file order; its boundary is an opening")
      .allow_repeated();
  subcommand
      .option("--face FACE", a.task.faces, "use only this face and others named so, not all faces")
      .allow_repeated();
}

void add_new_faces(Subcommand& subcommand, FillArguments& a) {
  subcommand.group("Surface");
  subcommand
      .option("--continuity WHICH", a.task.continuity,
              "continuity with the given faces: common edges, tangent planes, or curvature")
      .one_of({"G0", "G1", "G2"})
      .default_text("G1, and G0 at sharp angles");
  add_edge_length(subcommand, a.task.edge_length, "1/20 of the size of a single face");
  subcommand.group("Output");
  subcommand.flag("--new-faces-only", a.task.patches_only,
                  "write only the new faces to STEP, not those of the part");
  add_step_options(subcommand, a.step);
}

int run_fill_command(FillArguments& a, const CommonOptions& common) {
  FillTask& task = a.task;
  task.inner.assign(a.inner.begin(), a.inner.end());
  for (const double number : a.openings) {
    if (!(number >= 1 && number <= 1e6 && number == std::floor(number)))
      throw InputError("--opening: found " + format_number(number) +
                       ", expected the number of an opening, from 1");
    task.openings.push_back(static_cast<int>(number));
  }
  task.step_curves = a.step.lines;
  task.step_ap242 = a.step.ap242;
  const auto report = run_fill(a.part, task, a.out, terminal_progress(common.quiet));
  return print_result(report, summary(report, a.out), common);
}

}  // namespace

Command add_fill(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FillArguments>();
  FillArguments& a = *arguments;
  Subcommand subcommand = program.command(
      "fill", kSurfaces, "fill the openings of CAD models or meshes, tangent to their faces");
  add_given_faces(subcommand, a);
  subcommand.group("Openings");
  subcommand
      .option("--opening NUMBER", a.openings,
              "opening to fill, 1 is the longest; without this option, all but outer boundaries")
      .allow_repeated();
  subcommand
      .option("--edge NAME", a.task.edges,
              "fill the opening with this free edge, such as edge5 in file order")
      .allow_repeated();
  add_face_selection(subcommand, a);
  subcommand.option("--inner FILE", a.inner, "file of curves through which the new faces pass")
      .allow_repeated();
  add_new_faces(subcommand, a);
  add_common(subcommand, common);
  subcommand.example("batten fill part.step --out out/part",
                     "a CAD model of yours becomes a closed solid");
  subcommand.example("batten fill part.step --replace \"face 3\" --continuity G2 --out out/part",
                     "one face is replaced by a face with continuous curvature");
  subcommand.example("batten fill scan.stl --out out/scan",
                     "the holes of a scan are closed, and its triangles joined to the mesh");
  return {subcommand, [arguments, &common] { return run_fill_command(*arguments, common); }};
}

// `batten blend`.
Command add_blend(CommandLine& program, CommonOptions& common) {
  const auto arguments = std::make_shared<FillArguments>();
  FillArguments& a = *arguments;
  a.task.bridge = true;
  Subcommand subcommand = program.command(
      "blend", kSurfaces, "connect edges or openings of CAD models or meshes, tangentially");
  add_given_faces(subcommand, a);
  subcommand.group("Edges");
  subcommand
      .option("--edge NAME", a.task.edges,
              "free edge to connect, such as edge5 in file order; name the edges of both ends")
      .allow_repeated();
  subcommand
      .option("--opening NUMBER", a.openings,
              "whole openings to connect, instead of edges: two of them, 1 is the longest")
      .allow_repeated();
  add_face_selection(subcommand, a);
  subcommand
      .option("--tension VALUE", a.task.tension,
              "pull at the sides of a face between open edges: 0.5 is flat, 2 bulges")
      .positive()
      .default_text("1");
  add_new_faces(subcommand, a);
  add_common(subcommand, common);
  subcommand.example("batten blend two-sheets.step --edge edge3 --edge edge5 --out out/blend",
                     "a face connects edges of two sheets");
  subcommand.example("batten blend two-tubes.step --opening 1 --opening 4 --out out/blend",
                     "a face connects the ends of two tubes");
  return {subcommand, [arguments, &common] { return run_fill_command(*arguments, common); }};
}

}  // namespace batten
