// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_evaluator.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/image.h"
#include "batten/io/report/report.h"
#include "batten/io/sessions/session_log.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/shapes/make_session.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/scenes/shapes/stress_setup.h"

namespace batten {

// Output of a shape that changes with a parameter or with time, as a series of files.

/// Collects the shapes of one series and writes their files.
class ShapeSeries {
 public:
  /// Files are called STEM_000.vtp, …, with enough digits for `most` shapes. Pictures use the
  /// settings of the scene's first [[picture]]; their captions are LABEL = value.
  ShapeSeries(const Scene& scene, std::string stem, std::string label, const OutputFolder& out,
              int most);

  /// Adds a shape and writes its .vtp immediately. Throws InputError.
  void add(Report& report, double value, std::vector<SkinnedRegion> regions);
  int count() const { return isize(files_); }

  /// Writes STEM.pvd, STEM.gif (at most 120 shapes), and STEM.png with all shapes (at most 48) or,
  /// with `each`, one .png per shape. All pictures have the same camera and contour heights. Throws
  /// InputError, also if there is no display; STEM.pvd is written before that.
  void finish(Report& report, bool each, const Progress& progress);

 private:
  std::string name(int i, const std::string& ending) const;
  const Scene& scene_;
  std::string stem_, label_;
  const OutputFolder& out_;
  int digits_;
  std::vector<std::pair<double, std::string>> files_;
  std::vector<std::vector<SkinnedRegion>> shapes_;
};

namespace {

/// Parses "jumps:ITERATIONS".
int parse_rounds(const std::string& text) {
  if (text.empty()) return 0;
  const std::string word = text.starts_with("jumps:") ? text.substr(6) : "";
  char* end = nullptr;
  const long rounds = std::strtol(word.c_str(), &end, 10);
  if (word.empty() || *end != '\0' || rounds < 1 || rounds > 20)
    throw InputError("--refine: found " + text +
                     ", expected jumps:ITERATIONS with 1 to 20 iterations");
  return static_cast<int>(rounds);
}

int parse_steps(const SculptTask& task) {
  if (task.time == 0 && task.dt == 0) return 0;
  const auto fail = [](const std::string& found, const std::string& expected) {
    throw InputError("--time, --dt: found " + found + ", expected " + expected);
  };
  if (!(task.time > 0) || !(task.dt > 0) || !std::isfinite(task.time) || !std::isfinite(task.dt))
    fail("the time " + format_number(task.time) + " with the time step " + format_number(task.dt),
         "two numbers above 0");
  const double steps = task.time / task.dt;
  constexpr double most = 1e6;
  if (steps > most) fail(format_number(steps) + " time steps", "at most a million");
  // The last step ends at the given time, or is the first one after it.
  return std::max(1, static_cast<int>(std::ceil(steps * (1 - 1e-12))));
}

double area_of(const Surface& surface) {
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  const TriangleRule whole = split_triangle_rule(2);
  double area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const TriangleRule rule = trim && trim->side(t) == Trim::Side::Cut ? trim->rule(t, 2) : whole;
    for (long p = 0; p < rule.weights.size(); ++p)
      area += rule.weights[p] * mesh.shape(t).area *
              surface.jet({t, rule.L.row(p).transpose()}).area_vector().norm();
  }
  return area;
}

Report::Shape current_shape(const SculptingSession& session) {
  const SurfaceEnergy energy = session.energy();
  return {energy.stretching, energy.bending, area_of(session.layout().surface(session.dofs())),
          session.enclosed_volume(), session.residual()};
}

/// One run: the session and its state.
class SculptRun {
 public:
  SculptRun(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
            const Progress& progress)
      : scene_(scene), task_(task), progress_(progress), run_(scene, folder) {}

  Report done() {
    if (task_.stress && !scene_.stress)
      throw InputError(scene_.at({}) +
                       "found no [stress], expected one with thickness, material and supports");
    for (const std::string& text : task_.sweeps) sweeps_.push_back(parse_range("--sweep", text));
    const int rounds = parse_rounds(task_.refinement), steps = parse_steps(task_);
    if (!task_.record.empty()) record_.emplace(task_.record);
    Stopwatch& watch = run_.watch;
    report_.sculpting = Report::Sculpting{};
    std::vector<Setting> settings;
    for (Setting& s : parse_settings(task_.settings)) {
      if (is_session_parameter(scene_, s.name))
        settings.push_back(s);
      else
        scene_.set(s.name, s.value, s.where);
    }
    const std::vector<Operation> log =
        task_.replay.empty() ? std::vector<Operation>{} : read_session_log(task_.replay);

    model_ = sculpt_model(model_of(run_, scene_, progress_), scene_, progress_);
    watch.lap("layout");
    progress_.update("session", 0);
    session_.emplace(make_session(*model_.layout, scene_, model_.made, FactorReuse::many, progress_,
                                  &start_, model_.fair.rest));
    check_sweeps();
    watch.lap("session");

    session_->record(!task_.record.empty());
    if (!task_.replay.empty()) replay(log);
    for (const Setting& s : settings) set(s.name, s.value, s.where);
    if (task_.replay.empty() || !settings.empty()) solve_to_equilibrium("solve");
    for (int round = 0; round < rounds; ++round) refine();
    watch.lap("sculpt");
    for (const ParameterSweep& sweep : sweeps_) {
      do_sweep(sweep);
      watch.lap("sweep of " + sweep.parameter);
    }
    if (steps > 0) {
      move(steps);
      watch.lap("motion");
    }
    write();
    return std::move(report_);
  }

 private:
  std::string stem(const std::string& what) const {
    const std::string name = scene_.vtp.empty() ? safe_file_name(scene_.name)
                                                : std::filesystem::path(scene_.vtp).stem().string();
    return name + "_" + safe_file_name(what);
  }

  void set(const std::string& name, double value, const std::string& where) {
    try {
      session_->set(name, value);
    } catch (const InputError& e) {
      throw InputError(where + e.what());
    }
  }

  /// Checks all values of all sweeps before the computation.
  void check_sweeps() const {
    for (const ParameterSweep& sweep : sweeps_)
      for (const double value : {sweep.from, sweep.to}) {
        if (!is_session_parameter(scene_, sweep.parameter))
          throw InputError(sweep.where + "found '" + sweep.parameter +
                           "', which cannot vary in a sweep, expected a load, stiffness, offset, "
                           "[[parameter]], coordinate of a point constraint, alpha or beta");
        try {
          Parameters(session_->parameters()).set(sweep.parameter, value);
        } catch (const InputError& e) {
          throw InputError(sweep.where + e.what());
        }
      }
  }

  SolveReport solve_to_equilibrium(const std::string& what) {
    progress_.update("sculpting", 0);
    solve_report_ = session_->solve_to_equilibrium();
    report_.sculpting->solves.push_back(
        {what, solve_report_.iterations, solve_report_.change, solve_report_.factored});
    return solve_report_;
  }

  void replay(const std::vector<Operation>& log) {
    progress_.update("replay", 0);
    const int refused = session_->replay(log);
    if (refused > 0)
      report_.warnings.push_back(
          std::to_string(refused) + " of " + std::to_string(log.size()) +
          " operations of the log were refused; if they were not refused when recorded, the log "
          "belongs to another scene");
    report_.sculpting->solves.push_back({"replay", isize(log), 0, false});
  }

  void refine() {
    Refinement refinement;
    refinement.where = Refinement::JumpIndicator{};
    const RefinementReport r = session_->refine(refinement);
    report_.sculpting->refinements.push_back({r.triangles_before, r.triangles, r.max_displacement,
                                              r.energy_before, r.energy_transferred,
                                              r.energy_at_equilibrium});
  }

  void do_sweep(const ParameterSweep& sweep) {
    const double before = session_->parameters().value(sweep.parameter);
    Report::Sculpting::Sweep table{sweep.parameter, {}, ""};
    ShapeSeries series(scene_, stem(sweep.parameter), sweep.parameter, run_.out, sweep.count);
    for (int i = 0; i < sweep.count; ++i) {
      progress_.update("sweep of " + sweep.parameter, static_cast<double>(i) / sweep.count);
      const double value = sweep.at(i);
      session_->set(sweep.parameter, value);
      try {
        solve_report_ = session_->solve_to_equilibrium();
      } catch (const NoSolutionError& e) {
        table.stopped = "at " + format_number(value) + ": " + e.what();
        report_.failed_checks.push_back(
            {"sweep of " + sweep.parameter, "stopped after " + std::to_string(i) + " of " +
                                                std::to_string(sweep.count) + " values, " +
                                                table.stopped});
        break;
      }
      table.rows.push_back(
          {value, current_shape(*session_), solve_report_.iterations, 0, current_stress()});
      series.add(report_, value, session_->regions());
    }
    report_.sculpting->sweeps.push_back(table);
    finish(series, false);
    session_->set(sweep.parameter, before);
    solve_to_equilibrium("solve after the sweep of " + sweep.parameter);
  }

  // Maxima over all load cases.
  std::optional<Report::Sculpting::Stress> current_stress() {
    if (!task_.stress) return std::nullopt;
    const ShellEvaluator::MaxValues most = stress_.at(session_->layout(), session_->dofs());
    return Report::Sculpting::Stress{most.displacement, most.von_mises};
  }

  void move(int steps) {
    const SceneMotion& m = scene_.motion;
    session_->start_motion({task_.dt, m.density, m.damping, m.theta});
    Report::Sculpting::Motion table{task_.dt, m.density, m.damping, m.theta, steps, 0, {}};
    const int stride = (steps + task_.frames - 1) / task_.frames;
    ShapeSeries series(scene_, stem("time"), "t", run_.out, steps / stride + 1);
    const auto add = [&](double time) {
      table.rows.push_back({time, current_shape(*session_), 0, session_->total_energy(), {}});
      series.add(report_, time, session_->regions());
    };
    add(0);
    for (int i = 1; i <= steps; ++i) {
      progress_.update("motion", static_cast<double>(i) / steps);
      solve_report_ = session_->step();
      const double residual = session_->residual();
      if (!(residual <= table.max_residual)) table.max_residual = residual;
      if (i % stride == 0 || i == steps) add(solve_report_.time);
    }
    report_.sculpting->motion = table;
    finish(series, true);
  }

  void finish(ShapeSeries& series, bool each) {
    try {
      series.finish(report_, each, progress_);
    } catch (const InputError&) {
      // Without a display, a series has shapes but no pictures.
      if (can_draw(report_, "pictures of the series")) throw;
    }
  }

  /// Dofs of the shape of the lines alone, on the current mesh.
  Points current_unloaded() const {
    if (start_.unloaded.rows() == session_->dofs().rows()) return start_.unloaded;
    const Points bent = min_bending_shape(session_->layout(), scene_, progress_);
    if (!model_.fair.rest) return bent;
    const ConstraintSet rows = session_->layout().line_constraints();
    const Points fair =
        RestShapeFunction(model_.fair.rest)({session_->layout(), rows, bent, {}, progress_});
    return fair.rows() > 0 ? fair : bent;
  }

  void write() {
    progress_.update("measuring", 0);
    for (const ScalarParameter& p : session_->parameters().all())
      report_.parameters.push_back({p.name, session_->parameters().value(p.name), p.min, p.max});
    report_.sculpting->shape = current_shape(*session_);
    const FairingSummary fairing = model_.fair.fairing ? *model_.fair.fairing : FairingSummary{};
    SolvedShape shape = shape_of(*session_, scene_, current_unloaded(), solve_report_);
    shape.fairing = fairing;
    measure_into(run_, model_.made, shape, scene_, progress_);
    write_files(run_, scene_, model_.made, shape, progress_);
    draw_pictures(run_, scene_, model_.made, shape, progress_);
    if (!scene_.pictures.empty()) run_.watch.lap("pictures");
    write_step_file(run_, scene_, model_.made, progress_);
    run_.finish(progress_);
    if (record_)
      record_->write([&](std::ostream& out) { out << session_log_text(session_->recorded()); });
    run_.out.commit("report.json", record_ ? &*record_ : nullptr);
  }

  Scene scene_;
  const SculptTask& task_;
  const Progress& progress_;
  RunContext run_;
  Report& report_ = run_.report;
  SculptModel model_;
  std::vector<ParameterSweep> sweeps_;
  std::optional<AtomicFile> record_;
  std::optional<SculptingSession> session_;
  ShellEvaluator stress_{shell_problem(scene_)};
  SessionReference start_;
  SolveReport solve_report_;
};

std::string row_text(const std::vector<std::string>& cells) {
  std::string text = "   ";
  for (const std::string& cell : cells)
    text += std::string(cell.size() < 13 ? 13 - cell.size() : 1, ' ') + cell;
  return text + "\n";
}

}  // namespace

Report run_sculpt(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
                  const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  return SculptRun(scene, task, folder, progress).done();
}

std::string sculpt_summary(const Report& report, const std::filesystem::path& folder) {
  const auto& s = report.surface;
  const auto& sculpting = *report.sculpting;
  const auto energy = [](const Report::Shape& shape) { return shape.stretching + shape.bending; };
  std::string text = printable(report.name) + "\n";
  text +=
      summary_line("surface", std::to_string(s.triangles) + " triangles, " +
                                  std::to_string(s.dofs) + " unknowns per coordinate, area " +
                                  format_number(sculpting.shape.area) + " " + report.unit + "²");
  text +=
      summary_line("energy", format_number(energy(sculpting.shape)) + " (bending " +
                                 format_number(sculpting.shape.bending) + "), volume " +
                                 format_number(sculpting.shape.volume) + " " + report.unit + "³");
  text += summary_line("constraints", "residual " + format_number(sculpting.shape.residual));
  for (const auto& r : sculpting.refinements)
    text += summary_line("refined", std::to_string(r.triangles_before) + " -> " +
                                        std::to_string(r.triangles) + " triangles, displacement " +
                                        format_number(r.max_displacement) +
                                        " of the size, energy " + format_number(r.energy_before) +
                                        " -> " + format_number(r.energy_at_equilibrium));
  for (const auto& sweep : sculpting.sweeps) {
    std::vector<std::string> head = {
        printable(sweep.parameter), "energy", "area", "volume", "iterations", "residual"};
    if (!sweep.rows.empty() && sweep.rows[0].stress)
      head.insert(head.end(), {"displacement", "von Mises"});
    text += row_text(head);
    for (const auto& row : sweep.rows) {
      std::vector<std::string> words = {
          format_number(row.value),       format_number(energy(row.shape)),
          format_number(row.shape.area),  format_number(row.shape.volume),
          std::to_string(row.iterations), format_number(row.shape.residual)};
      if (row.stress)
        words.insert(words.end(), {format_number(row.stress->displacement),
                                   format_number(row.stress->von_mises)});
      text += row_text(words);
    }
    if (!sweep.stopped.empty()) text += "    stopped " + printable(sweep.stopped) + "\n";
  }
  if (sculpting.motion) {
    const auto& m = *sculpting.motion;
    text += summary_line("motion", std::to_string(m.steps) + " steps of " + format_number(m.dt) +
                                       ", largest residual " + format_number(m.max_residual));
    constexpr size_t most_rows = 12;
    const size_t stride = (m.rows.size() + most_rows - 1) / most_rows;
    text += row_text({"time", "total energy", "area", "volume", "residual"});
    for (size_t i = 0; i < m.rows.size(); ++i)
      if (i % stride == 0 || i + 1 == m.rows.size())
        text +=
            row_text({format_number(m.rows[i].value), format_number(m.rows[i].total_energy),
                      format_number(m.rows[i].shape.area), format_number(m.rows[i].shape.volume),
                      format_number(m.rows[i].shape.residual)});
  }
  return text + summary_footer(report, folder);
}

namespace {

/// 800 pixels are wide enough to see the motion, and small enough to send.
constexpr int kAnimationWidth = 800;
constexpr double kSeriesSeconds = 4, kLastSeconds = 1;

constexpr int kMostAnimated = 120, kMostPanels = 48;

/// Selects at most `most` of `count` frames, evenly spaced, including the last one.
bool is_chosen(int i, int count, int most) {
  const int stride = (count + most - 1) / most;
  return (count - 1 - i) % stride == 0;
}

PictureSize animation_size(const PictureSize& size) {
  const double scale = std::min(1.0, static_cast<double>(kAnimationWidth) / size.width);
  const auto scaled = [&](int pixels) {
    return std::max(64, static_cast<int>(std::lround(scale * pixels)));
  };
  return {scaled(size.width), scaled(size.height)};
}

/// A nearly square sheet for many panels, one row for up to three.
int columns_for(int count) {
  return count <= 3 ? count : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
}

}  // namespace

ShapeSeries::ShapeSeries(const Scene& scene, std::string stem, std::string label,
                         const OutputFolder& out, int most)
    : scene_(scene),
      stem_(std::move(stem)),
      label_(std::move(label)),
      out_(out),
      digits_(std::max<int>(3, static_cast<int>(std::to_string(most).size()))) {}

std::string ShapeSeries::name(int i, const std::string& ending) const {
  const std::string digits = std::to_string(i);
  return stem_ + "_" + std::string(static_cast<size_t>(digits_) - digits.size(), '0') + digits +
         ending;
}

void ShapeSeries::add(Report& report, double value, std::vector<SkinnedRegion> regions) {
  const std::string file = name(count(), ".vtp");
  write_vtp(out_.file(file), pointers(regions));
  report.files.push_back(file);
  files_.emplace_back(value, file);
  shapes_.push_back(std::move(regions));
}

void ShapeSeries::finish(Report& report, bool each, const Progress& progress) {
  if (files_.empty()) return;
  std::vector<SeriesFile> series;
  for (const auto& [value, file] : files_) series.push_back({value, file});
  write_pvd(out_.file(stem_ + ".pvd"), series);
  report.files.push_back(stem_ + ".pvd");

  const ScenePicture picture = scene_.pictures.empty() ? ScenePicture{} : scene_.pictures.front();
  std::vector<PictureScene> frames;
  for (size_t i = 0; i < shapes_.size(); ++i) {
    frames.push_back(picture.look);
    frames.back().regions = pointers(shapes_[i]);
    frames.back().title = label_ + " = " + format_number(files_[i].first);
  }
  share_view(frames);
  const PictureSize size = animation_size(picture.size);
  std::vector<Image> images;
  std::vector<PictureScene> panels;
  for (int i = 0; i < count(); ++i) {
    progress.update("pictures of " + label_, static_cast<double>(i) / count());
    const PictureScene& frame = frames[i];
    const bool animated = is_chosen(i, count(), kMostAnimated);
    if (!each && is_chosen(i, count(), kMostPanels)) panels.push_back(frame);
    if (!animated && !each) continue;
    Image image = picture_image(frame, size);
    if (each) {
      const std::string file = name(i, ".png");
      write_png(out_.file(file), image);
      report.files.push_back(file);
    }
    if (animated) images.push_back(std::move(image));
  }
  if (!each) {
    const int many = isize(panels);
    const int columns = columns_for(many), rows = (many + columns - 1) / columns;
    constexpr double sheet = 1500;
    const double height = sheet / columns * picture.size.height / picture.size.width * rows;
    draw_contact_sheet(out_.file(stem_ + ".png"), panels, columns,
                       {static_cast<int>(sheet), std::clamp(static_cast<int>(height), 64, 4096)});
    report.files.push_back(stem_ + ".png");
  }
  write_gif(out_.file(stem_ + ".gif"), images,
            std::min(0.5, kSeriesSeconds / static_cast<double>(images.size())), kLastSeconds);
  report.files.push_back(stem_ + ".gif");
}

}  // namespace batten
