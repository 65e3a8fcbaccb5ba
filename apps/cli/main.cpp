// batten: the command line.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>

#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/info.h"
#include "batten/apps/commands/lines/run_fair.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/runs/distributed.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/apps/commands/shapes/run_sculpt.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"
#include "batten/io/files/in_child.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/scene/read_scene.h"

namespace {

using namespace batten;

/// Exit codes, docs/conventions.md.
enum Exit {
  kDone = 0,
  kBadInput = 1,
  kConflict = 2,
  kNoSolution = 3,
  kMissed = 4,
  kCancelled = 130
};

const char* const kVersion = "batten " BATTEN_VERSION
#ifdef BATTEN_HAVE_CHOLMOD
                             "\nfactorization: CHOLMOD"
#else
                             "\nfactorization: Eigen (built without CHOLMOD)"
#endif
#ifdef BATTEN_HAVE_CGAL
                             "\nmeshes: CGAL Mesh_2 and fan"
#else
                             "\nmeshes: fan only (built without CGAL)"
#endif
#ifdef BATTEN_HAVE_CERES
                             "\ncurves of least curvature: Ceres";
#else
                             "\ncurves of least curvature: none (built without Ceres)";
#endif

const char* const kExamples = R"(
Examples:
  batten skin outline.csv --out result          lines to a surface: STEP, VTK, report
  batten skin --network sketch.json --unit m --out result    a network of lines to all its surfaces
  batten run hood.toml --out result             everything a scene asks for
  batten run hood.toml --out result --set crown=4
  batten stress hood.toml --out result          and its stresses, without remeshing
  batten sculpt bowl.toml --out result --sweep swell=0:250:9
  batten fair sketch.csv --out fair.step        drawn lines, as smooth as they were meant
  batten deform edit.toml --out result          a mesh moved, its holes and beads exactly kept
  batten sequence edit.toml --out result        a deforming mesh: paths, footprints, keyframes
  batten info hood.toml                         its lines and its parameters
  batten info panel.bdf                         a mesh: its holes and creases, what is wrong
  batten view hood.toml --screenshot hood.png   a picture (needs a display, or xvfb-run)

Exit codes:
  0 done   1 bad input   2 constraints in conflict   3 no solution
  4 done, but a promise was missed (which, by how much: see the report)   130 cancelled
)";

/// CLI::PositiveNumber, in words.
const CLI::Validator kPositive(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
                 ? std::string()
                 : "found " + text + ", expected a number above 0";
    },
    "POSITIVE");

struct Arguments {
  std::string file, out, minimum, unit = "mm", screenshot, compare, show = "shaded", picture,
                                  report, choices;
  std::vector<std::string> files, inner, settings, only;
  SculptTask sculpt;
  StressTask stress;
  SequenceTask sequence;
  std::vector<double> angles;
  double edge_length = 0, tolerance = 0, meet = 0, pressure = 0;
  double noise = 0, deviation = 0, wavelength = 0, corner_angle = FairOptions{}.corner_angle,
         segments = 0, memory = 0;
  int threads = 0, contours = 0;
  bool network = false, exact_step = false, quiet = false, hold_ends = false, closed = false,
       open = false, keep_outliers = false;
};

int finish(const RunReport& report, const std::string& text, const Arguments& a) {
  end_progress();
  if (!a.quiet) std::cout << text;
  constexpr size_t most = 10;  // of a kind: the report has all
  const auto list = [&](const char* label, const auto& items, const auto& text_of) {
    for (size_t i = 0; i < std::min(items.size(), most); ++i)
      std::cerr << label << ": " << text_of(items[i]) << "\n";
    if (items.size() > most)
      std::cerr << label << ": and " << items.size() - most << " more (the report has all)\n";
  };
  list("warning", report.warnings, [](const auto& w) { return w; });
  list("promise missed", report.missed, [](const auto& m) { return m.what + " " + m.detail; });
  return report.missed.empty() ? kDone : kMissed;
}
template <class AnyReport>
int finish(const AnyReport& report, const Arguments& a) {
  return finish(report, summary(report, a.out), a);
}

int deform(const Arguments& a) {
  DeformScene scene = read_deform_scene(a.file);
  apply_settings(scene, a.settings);
  return finish(run_deform(scene, a.out, terminal_progress(a.quiet)), a);
}

int sequence(const Arguments& a) {
  return finish(
      run_sequence(read_sequence_scene(a.file), a.out, a.sequence, terminal_progress(a.quiet)), a);
}

int fair(const Arguments& a) {
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
      run_fair(scene, FairFiles{a.out, a.picture, a.report}, terminal_progress(a.quiet));
  return finish(report, summary(report), a);
}

int run(const Arguments& a) {
  if (edits_a_sequence(a.file)) return sequence(a);
  if (edits_a_mesh(a.file)) return deform(a);
  if (only_fairs(a.file)) {
    FairScene scene = read_fair_scene(a.file);
    apply_settings(scene, a.settings);
    return finish(run_fair(scene, std::filesystem::path(a.out), terminal_progress(a.quiet)), a);
  }
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  return finish(run_scene(scene, a.out, terminal_progress(a.quiet)), a);
}

int stress(const Arguments& a) {
  const auto processes = Distributed::of_this_run();
  if (processes && processes->helps()) {
    processes->serve();
    return kDone;
  }
  StressTask task = a.stress;
  if (processes) task.factors = processes->factors();
  Scene scene = read_scene(a.file);
  apply_settings(scene, a.settings);
  return finish(run_stress(scene, a.out, task, terminal_progress(a.quiet)), a);
}

int sculpt(const Arguments& a) {
  const Report report = run_sculpt(read_scene(a.file), a.sculpt, a.out, terminal_progress(a.quiet));
  return finish(report, sculpt_summary(report, a.out), a);
}

Scene lines_scene(const Arguments& a) {
  Scene scene = a.network ? scene_of_network({a.files.begin(), a.files.end()}, a.unit)
                          : scene_of_lines({a.files.begin(), a.files.end()},
                                           {a.inner.begin(), a.inner.end()}, a.unit);
  scene.skin.options.edge_length = a.edge_length;
  scene.skin.options.tolerance = a.tolerance;
  if (a.meet > 0) {
    if (!scene.network) throw InputError("--meet is for lines of a --network");
    scene.network->tolerance = a.meet;
  }
  scene.compare = a.compare;
  if (a.exact_step) scene.step_form = Scene::StepForm::Exact;
  if (a.pressure != 0) {
    SceneLoad load;
    load.name = "pressure";
    load.value = a.pressure;
    scene.loads.push_back(load);
  }
  return scene;
}

int skin(const Arguments& a) {
  return finish(run_scene(lines_scene(a), a.out, terminal_progress(a.quiet)), a);
}

int info(Arguments a) {
  if (!a.choices.empty()) {
    a.files = {a.file};
    a.network = true;
    std::cout << draw_choices(a.choices,
                              a.file.ends_with(".toml") ? read_scene(a.file) : lines_scene(a));
    return kDone;
  }
  std::cout << file_info(a.file, a.unit);
  if (!a.picture.empty()) draw_lines(a.picture, a.file, a.unit);
  return kDone;
}

int view(Arguments a) {
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
  view_scene(scene, look, a.screenshot, terminal_progress(a.quiet));
  end_progress();
  if (!a.quiet) std::cout << a.screenshot << "\n";
  return kDone;
}

/// Adds the options that every long command has.
void add_common(CLI::App* sub, Arguments& a) {
  sub->add_option("--threads", a.threads, "Threads to use; the number of cores unless given")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--memory", a.memory,
                  "GB that may be used; what is there unless given. More is refused beforehand")
      ->check(kPositive);
  sub->add_flag("--quiet", a.quiet, "Print errors only");
}

/// An option that may be there several times, each with one value.
CLI::Option* repeated(CLI::Option* option) { return option->take_all()->allow_extra_args(false); }

/// Adds the unit of lengths.
void add_unit(CLI::App* sub, Arguments& a) {
  sub->add_option("--unit", a.unit, "Unit of lengths")
      ->check(CLI::IsMember(length_units()))
      ->capture_default_str();
}

/// Adds "batten run" or "batten stress" and its options.
CLI::App* add_run(CLI::App& app, const char* name, const char* what, Arguments& a) {
  auto* sub = app.add_subcommand(name, what);
  sub->add_option("scene", a.file, "Scene (.toml)")->required();
  sub->add_option("--out", a.out, "Folder for all files, report.json too")->required();
  repeated(sub->add_option("--set", a.settings, "Set a parameter of the scene: name=value"));
  add_common(sub, a);
  return sub;
}

/// Adds "batten sculpt" and its options.
CLI::App* add_sculpt(CLI::App& app, Arguments& a) {
  auto* sub = app.add_subcommand(
      "sculpt", "Settle, sweep, move and refine a scene's surface under live loads");
  sub->add_option("scene", a.file, "Scene (.toml)")->required();
  sub->add_option("--out", a.out, "Folder for all files, report.json too")->required();
  repeated(sub->add_option("--set", a.sculpt.settings, "Set a parameter: name=value"));
  auto* sweep = repeated(
      sub->add_option("--sweep", a.sculpt.sweeps,
                      "Settle at so many values, each from the one before: name=from:to:count"));
  auto* time = sub->add_option("--time", a.sculpt.time,
                               "Motion from the settled shape, until this time; needs --dt");
  auto* dt = sub->add_option("--dt", a.sculpt.dt, "Step of the motion; needs --time");
  time->check(kPositive)->needs(dt);
  dt->check(kPositive)->needs(time);
  sub->add_option("--frames", a.sculpt.frames, "Most frames of a motion")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  auto* refinement =
      sub->add_option("--refine", a.sculpt.refinement,
                      "Halve triangles where curvature jumps, so many rounds: jumps:ROUNDS");
  sub->add_flag(
         "--stress", a.sculpt.stress,
         "Largest displacement and stress of the shell of [stress], at each value of a sweep")
      ->needs(sweep);
  auto* record =
      sub->add_option("--record", a.sculpt.record, "Write everything that was done to this file");
  sub->add_option("--replay", a.sculpt.replay, "Do what such a file says")
      ->excludes(sweep)
      ->excludes(time)
      ->excludes(refinement)
      ->excludes(record);
  add_common(sub, a);
  return sub;
}

/// Adds "batten deform" and its options.
CLI::App* add_deform(CLI::App& app, Arguments& a) {
  auto* sub =
      app.add_subcommand("deform", "Edit a mesh; its form features keep their shape exactly");
  sub->add_option("edits", a.file, "Edits of a mesh (.toml)")->required();
  sub->add_option("--out", a.out, "Folder for all files, report.json too")->required();
  repeated(sub->add_option("--set", a.settings, "Set a parameter of the edits: name=value"));
  add_common(sub, a);
  return sub;
}

/// Adds "batten sequence" and its options.
CLI::App* add_sequence(CLI::App& app, Arguments& a) {
  auto* sub = app.add_subcommand(
      "sequence", "Edit a deforming mesh: keyframes, footprints, paths; mix, filter, morph");
  sub->add_option("edits", a.file, "Edits of a sequence (.toml)")->required();
  sub->add_option("--out", a.out, "Folder for all files, report.json too")->required();
  sub->add_option_function<std::string>(
      "--frames",
      [&a](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = stated_number(text.substr(0, colon)),
                   last =
                       colon == std::string::npos ? first : stated_number(text.substr(colon + 1));
        if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
          throw CLI::ValidationError("--frames", "found " + text + ", expected FIRST:LAST");
        a.sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
      },
      "Make these frames only, FIRST:LAST from 1: runs of a job array share the work");
  add_common(sub, a);
  return sub;
}

/// Adds "batten fair" and its options.
CLI::App* add_fair(CLI::App& app, Arguments& a) {
  auto* sub =
      app.add_subcommand("fair", "Fair drawn or measured lines; the ending of OUT says the kind");
  sub->add_option("lines", a.file, "Lines: .curves .csv .txt .xyz .dat .obj .iges .step .dxf .svg")
      ->required();
  sub->add_option("--out", a.out, "File to write: " + listed(curve_file_endings()))->required();
  auto* noise = sub->add_option("--noise", a.noise,
                                "The fairest curve that the points are off by this, root mean "
                                "square: where the noise is known");
  auto* deviation = sub->add_option("--deviation", a.deviation,
                                    "The fairest curve not farther than this from any point");
  auto* wavelength = sub->add_option("--wavelength", a.wavelength,
                                     "Smooth what is shorter than this (default: found by itself)");
  noise->check(kPositive)->excludes(deviation)->excludes(wavelength);
  deviation->check(kPositive)->excludes(wavelength);
  wavelength->check(kPositive);
  sub->add_option("--minimum", a.minimum,
                  "Instead: the curve through all points (a few) of least curvature, or of least "
                  "change of it")
      ->check(CLI::IsMember({"energy", "variation"}))
      ->excludes(noise)
      ->excludes(deviation)
      ->excludes(wavelength);
  sub->add_option("--corner-angle", a.corner_angle,
                  "A corner is where a line turns by more than this, degrees (180: none)")
      ->check(CLI::Range(1e-3, 180.0))
      ->capture_default_str();
  sub->add_flag("--hold-ends", a.hold_ends, "First and last points stay where they are");
  auto* closed = sub->add_flag("--closed", a.closed, "All lines come back to their start");
  sub->add_flag("--open", a.open, "No line does")->excludes(closed);
  sub->add_flag("--keep-outliers", a.keep_outliers,
                "Points that lie off a noisy line are not passed over");
  sub->add_option("--segments", a.segments,
                  "In the end: as few segments as stay this near to the fair curve")
      ->check(kPositive);
  repeated(sub->add_option("--only", a.only, "A line to take, by its name (may be repeated)"));
  sub->add_option("--picture", a.picture, "Curvature combs before and after (.png)");
  sub->add_option("--report", a.report, "All numbers (.json)");
  add_unit(sub, a);
  add_common(sub, a);
  return sub;
}

/// Adds "batten skin" and its options.
CLI::App* add_skin(CLI::App& app, Arguments& a) {
  auto* sub =
      app.add_subcommand("skin", "From files of lines straight to a surface: STEP, VTK, report");
  sub->add_option("lines", a.files,
                  "Outline: .csv .txt .xyz .dat .obj .curves .iges .step .dxf .svg; a network: "
                  ".json too")
      ->required();
  auto* inner =
      sub->add_option("--inner", a.inner, "A file of inner lines")->allow_extra_args(false);
  auto* network = sub->add_flag("--network", a.network,
                                "The lines are a network: all surfaces between them, joined");
  network->excludes(inner);
  sub->add_option("--out", a.out, "Folder for all files")->required();
  add_unit(sub, a);
  sub->add_option("--edge-length", a.edge_length, "Target length of element edges")
      ->check(kPositive);
  sub->add_option("--tolerance", a.tolerance, "Largest distance of fitted lines")->check(kPositive);
  sub->add_option("--meet", a.meet,
                  "Distance within which lines of a network meet; found unless given")
      ->check(kPositive);
  sub->add_option("--compare", a.compare, "CAD file: measure the distance from its faces");
  sub->add_flag("--exact-step", a.exact_step,
                "STEP to rounding, three faces a triangle, instead of one face a region");
  sub->add_option("--pressure", a.pressure, "Pressure along the normal, relative units")
      ->excludes(network);
  add_common(sub, a);
  return sub;
}

/// Adds "batten info" and its options.
CLI::App* add_info(CLI::App& app, Arguments& a) {
  auto* sub = app.add_subcommand(
      "info", "What is in a scene, a file of lines, a mesh, a deforming mesh, a STEP file");
  sub->add_option("file", a.file, "The file")->required();
  sub->add_option("--picture", a.picture, "Draw its lines with their curvature, to a .png");
  sub->add_option("--choices", a.choices,
                  "Network: draw surfaces that could as well be others, into this folder, and say "
                  "what to write");
  add_unit(sub, a);
  return sub;
}

/// Adds "batten view" and its options.
CLI::App* add_view(CLI::App& app, Arguments& a) {
  auto* sub = app.add_subcommand("view", "A picture of a scene's or a line file's surface");
  sub->add_option("file", a.file, "Scene (.toml) or file of lines")->required();
  sub->add_option("--screenshot", a.screenshot, "The picture to write (.png)")->required();
  repeated(sub->add_option("--set", a.settings, "Set a parameter of the scene: name=value"));
  sub->add_option("--show", a.show, "What to show")
      ->check(CLI::IsMember({"shaded", "mean_curvature", "gauss_curvature", "regions"}))
      ->capture_default_str();
  sub->add_flag("--network", a.network, "The lines of the file are a network");
  sub->add_option("--contours", a.contours, "Number of contour lines")->check(CLI::Range(0, 1000));
  sub->add_option("--view", a.angles, "Azimuth and elevation, degrees")->expected(2);
  add_unit(sub, a);
  add_common(sub, a);
  return sub;
}

/// Reads the command line and does what it says.
int command(int argc, char** argv) {
  Arguments a;
  CLI::App app("Batten: continuous surfaces that shape themselves", "batten");
  app.footer(kExamples);
  app.set_version_flag("--version", kVersion);
  app.require_subcommand(1);
  const CLI::App* run_command = add_run(app, "run", "Do everything a scene asks for", a);
  CLI::App* stress_command =
      add_run(app, "stress", "The same, and the stresses of the shape as the shell of [stress]", a);
  stress_command->add_flag("--with-ccx", a.stress.with_calculix,
                           "Run CalculiX on the same shell, and print what it finds");
  stress_command->add_option("--ccx-elements", a.stress.element, "Its elements: S6, S3 or S8R")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ShellDeck::Element>{{"S6", ShellDeck::Element::S6},
                                                    {"S3", ShellDeck::Element::S3},
                                                    {"S8R", ShellDeck::Element::S8R}},
          CLI::ignore_case))
      ->needs("--with-ccx");
  stress_command
      ->add_option("--accuracy", a.stress.accuracy,
                   "Make elements smaller until displacements are this exact: 0.01 is a percent")
      ->check(kPositive);
  const CLI::App* sculpt_command = add_sculpt(app, a);
  const CLI::App* deform_command = add_deform(app, a);
  const CLI::App* sequence_command = add_sequence(app, a);
  const CLI::App* fair_command = add_fair(app, a);
  const CLI::App* skin_command = add_skin(app, a);
  const CLI::App* info_command = add_info(app, a);
  add_view(app, a);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kBadInput;
  }
  catch_interrupts(kCancelled);
  std::signal(SIGXFSZ, SIG_IGN);  // writers tell of a file that may not grow
  read_in_child(true);
  set_thread_count(a.threads);
  limit_memory(1e9 * a.memory);
  if (*run_command) return run(a);
  if (*stress_command) return stress(a);
  if (*sculpt_command) return sculpt(a);
  if (*deform_command) return deform(a);
  if (*sequence_command) return sequence(a);
  if (*fair_command) return fair(a);
  if (*skin_command) return skin(a);
  if (*info_command) return info(a);
  return view(a);
}

}  // namespace

int main(int argc, char** argv) {
  int code = kBadInput;
  std::string message;
  try {
    code = command(argc, argv);
  } catch (const ConflictError& e) {
    code = kConflict;
    message = e.what();
  } catch (const NoSolutionError& e) {
    code = kNoSolution;
    message = e.what();
  } catch (const CancelledError& e) {
    code = kCancelled;
    message = e.what();
  } catch (const InputError& e) {
    message = e.what();
  } catch (const std::bad_alloc&) {
    code = kNoSolution;
    message = "not enough memory";
  } catch (const std::exception& e) {
    code = kNoSolution;
    message = std::string("unexpected: ") + e.what();
  }
  if (interrupted() && !message.empty()) {  // a file that was removed may have stopped it too
    code = kCancelled;
    message = CancelledError().what();
  }
  end_progress();
  if (!message.empty()) std::cerr << "batten: " << message << "\n";
  return code;
}
