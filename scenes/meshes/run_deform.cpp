// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/mesh_pictures.h"
#include "batten/io/report/deform_report.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/scenes/meshes/derivative_files.h"
#include "batten/scenes/meshes/design_table.h"
#include "batten/scenes/meshes/dimension_requirements.h"
#include "batten/scenes/meshes/morph_measures.h"
#include "batten/scenes/meshes/morph_solver.h"
#include "batten/scenes/meshes/morph_variants.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

// Pictures of a deformed mesh.

/// Draws the pictures of a scene. `states`: positions of all vertices before the first edit and
/// after each edit.
void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<DeformTask>& tasks,
                   const SharedConstraints& shared, const OutputFolder& out);

namespace {

void write_modes(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                 VertexSelector& select, const Points& after, const OutputFolder& out) {
  const ModesSpec& rule = *scene.modes;
  ModalDeck modes;
  modes.thickness = rule.thickness;
  modes.young = rule.young;
  modes.poisson = rule.poisson;
  modes.density = rule.density;
  modes.count = rule.count;
  modes.units = "lengths in " + scene.unit;
  if (!rule.clamped.empty()) modes.clamped = select.of(rule.clamped);
  ShellMesh shells = file.shells();
  for (const bool deformed : {false, true}) {
    const std::string& name = deformed ? rule.after : rule.before;
    if (name.empty()) continue;
    if (deformed) shells.points = after;
    write_modal_deck(out.file(name), shells, modes);
    report.files.push_back(name);
  }
}

/// Writes the deformed mesh with displacements and vertex roles as data.
void write_result(const std::filesystem::path& path, const MeshFile& file, const Points& before,
                  const Points& after, const SharedConstraints& shared) {
  DeformedData data;
  data.displacement = after - before;
  data.feature.assign(before.rows(), -1);
  for (size_t f = 0; f < shared.features.size(); ++f)
    for (const int v : shared.features[f].vertices) data.feature[v] = static_cast<int>(f);
  for (const auto& f : shared.features) data.feature_names.push_back(f.name);
  ShellMesh shells = file.shells();
  shells.points = after;
  write_deformed_vtp(path, shells, data);
}

/// One run of `batten deform`: the constructor reads the input; the other steps follow in order.
class DeformRun {
 public:
  DeformRun(const DeformScene& scene, const std::filesystem::path& folder, const MorphTask& task,
            const Progress& progress)
      : scene_(scene),
        task_(task),
        progress_(progress),
        ranges_(parse_ranges()),
        design_(parse_design()),
        out_(folder),
        watch_(report_.timings),
        source_(read_mesh()),
        file_(source_.file),
        solver_(scene, source_, tolerance()) {}

  /// Checks the names of the output files, see OutputFolder::require_replaceable().
  void require_replaceable() const {
    for (const std::filesystem::path& path : task_.derivatives) {
      require_derivative_format(path, file_);
      replaceable_file(path);
    }
    std::vector<std::string> names{scene_.mesh_out, scene_.vtp, "report.json"};
    if (scene_.modes) names.insert(names.end(), {scene_.modes->before, scene_.modes->after});
    for (const MeshPictureSpec& rule : scene_.pictures) names.push_back(rule.file);
    out_.require_replaceable(names);
  }

  /// Performs the edits in order, and changes parameters until the requirements hold.
  void edit() {
    solver_.solve(scene_, progress_);
    const std::vector<std::string>& notes = shared().notes;
    report_.warnings.insert(report_.warnings.end(), notes.begin(), notes.end());
    dimensions_ = mesh_dimensions(scene_, shared().features, solver_.select(), solver_.mesh());
    meet_requirements(solver_, scene_, dimensions_, progress_);
    states_ = solver_.states();
    for (const auto& edit : solver_.edits()) add_warnings(*edit);
    watch_.lap("edits");
  }

  void measure() {
    progress_.update("measuring", 0);
    measure_morph(report_, file_, solver_, dimensions_);
    failed_ = failed_checks(report_, solver_, dimensions_);
    warn_left_behind(report_, file_, solver_);
    watch_.lap("measure");
  }

  void write() {
    progress_.update("files", 0);
    if (!scene_.mesh_out.empty()) write_mesh();
    if (!scene_.vtp.empty()) {
      write_result(out_.file(scene_.vtp), file_, node_positions(states_.front(), file_),
                   node_positions(states_.back(), file_), shared());
      report_.files.push_back(scene_.vtp);
    }
    if (scene_.modes)
      write_modes(report_, scene_, file_, solver_.select(), node_positions(states_.back(), file_),
                  out_);
    watch_.lap("files");
  }

  void draw() {
    draw_deformed(report_, scene_, file_, states_, tasks_, shared(), out_);
    watch_.lap("pictures");
  }

  /// Computes and writes the derivatives, and the variants of the design of experiments.
  void study() {
    if (!task_.derivatives.empty()) derive();
    if (!design_) return;
    write_variants(report_, solver_, scene_, file_, dimensions_, *design_, out_, progress_);
    watch_.lap("variants");
  }

  /// Writes report.json and commits all files.
  DeformReport finish() {
    watch_.total();
    write_report(report_, failed_, out_, progress_);
    out_.commit();
    return std::move(report_);
  }

 private:
  const TriangleMesh& original() const { return solver_.mesh(); }
  const SharedConstraints& shared() const { return solver_.shared(); }

  MeshSource read_mesh() {
    report_.name = scene_.name;
    report_.unit = scene_.unit;
    progress_.update("mesh", 0);
    MeshSource source = read_source(scene_.mesh);
    if (!scene_.mesh_out.empty())
      scene_.mesh_out = (source.file.folder_in_tree() / scene_.mesh_out).string();
    report_.warnings = source.file.warnings();
    // The report counts these elements, and names the nodes that stay behind.
    std::erase_if(report_.warnings, [&](const std::string& warning) {
      return warning == source.file.element_counts();
    });
    const std::vector<std::string>& notes = source.prepared.notes;
    report_.warnings.insert(report_.warnings.end(), notes.begin(), notes.end());
    report_.mesh_file = scene_.mesh.filename().string();
    report_.format = source.file.format();
    report_.nodes = source.file.shells().node_count();
    report_.faces = source.file.shells().face_count();
    watch_.lap("mesh");
    return source;
  }

  /// Derivatives need a smooth function of the parameters, as Newton's method does for requirements.
  double tolerance() const {
    const bool adjusts = std::any_of(scene_.requirements.begin(), scene_.requirements.end(),
                                     [](const auto& rule) { return !rule.adjust.text.empty(); });
    return adjusts || !task_.derivatives.empty() ? kDerivativeTolerance
                                                 : MeshEditorOptions().tolerance;
  }

  std::vector<ParameterSweep> parse_ranges() const {
    std::vector<ParameterSweep> ranges;
    constexpr int default_count = 3;
    for (const std::string& text : task_.ranges) {
      ranges.push_back(parse_range("--range", text, default_count));
      const ParameterSweep& range = ranges.back();
      for (const double end : {range.from, range.to})
        DeformScene(scene_).set(range.parameter, end, range.where);
      if (std::any_of(ranges.begin(), ranges.end() - 1,
                      [&](const auto& other) { return other.parameter == range.parameter; }))
        throw InputError(range.where + "found a second range, expected one for each parameter");
      for (const RequirementSpec& rule : scene_.requirements)
        if (rule.adjust.text == range.parameter)
          throw InputError(range.where + "found a parameter that [[require]] in line " +
                           std::to_string(rule.location.line) +
                           " adjusts, expected another parameter");
    }
    if (!ranges.empty() && task_.doe.empty() && task_.derivatives.empty())
      throw InputError(ranges.front().where +
                       "found no use for it, expected --doe or --derivatives");
    return ranges;
  }

  std::optional<DesignTable> parse_design() const {
    if (task_.doe.empty()) return std::nullopt;
    DesignTable design = design_table(task_.doe, ranges_);
    check_design(scene_, design);
    return design;
  }

  void add_warnings(const EditSession& edit) {
    tasks_.push_back(edit.task());
    const std::string& name = edit.rule().name;
    const MeshEditStatistics& statistics = edit.statistics();
    if (!statistics.converged)
      report_.warnings.push_back(name + ": the estimated rotations did not converge in " +
                                 std::to_string(statistics.iterations) + " iterations");
    for (const auto& note : edit.notes()) report_.warnings.push_back(name + ": " + note);
  }

  /// The parameters of --range; all parameters, if there are none.
  std::vector<Parameter> derivative_parameters() const {
    std::vector<Parameter> parameters = scene_.parameters();
    if (!ranges_.empty())
      std::erase_if(parameters, [&](const Parameter& p) {
        return std::none_of(ranges_.begin(), ranges_.end(),
                            [&](const ParameterSweep& range) { return range.parameter == p.name; });
      });
    return parameters;
  }

  void derive() {
    std::vector<MorphDerivative> derivatives =
        morph_derivatives(solver_, scene_, derivative_parameters(), dimensions_, progress_);
    for (const MorphDerivative& d : derivatives)
      if (!d.missing.empty())
        report_.warnings.push_back("no derivative with respect to '" + d.parameter.name +
                                   "': " + d.missing);
    std::erase_if(derivatives, [](const MorphDerivative& d) { return !d.missing.empty(); });
    report_.derivatives.emplace();
    for (const MorphDerivative& d : derivatives) {
      report_.derivatives->parameters.push_back(d.parameter.name);
      report_.derivatives->largest_error = std::max(report_.derivatives->largest_error, d.error);
    }
    constexpr double tolerance = 1e-7;
    if (report_.derivatives->largest_error > tolerance)
      failed_.push_back(
          {"derivatives.largest_error", "is " + format_number(report_.derivatives->largest_error) +
                                            ", expected at most " + format_number(tolerance)});
    const DerivativeTable table{&scene_,      &file_,       &states_.back(),
                                &dimensions_, &derivatives, ranges_};
    for (const auto& path : task_.derivatives) {
      write_derivatives(path, table);
      report_.derivatives->files.push_back(path.string());
    }
    watch_.lap("derivatives");
  }

  /// Writes the mesh in the format of its file.
  void write_mesh() {
    const std::filesystem::path tree = file_.folder_in_tree();
    const MeshWriteOptions options{scene_.large_field_nodes, out_.folder() / tree};
    std::filesystem::create_directories(out_.file(tree.string()));
    const Points places = node_positions(states_.back(), file_);
    const MeshFile::Rounding written = file_.write(out_.file(scene_.mesh_out), places, options);
    report_.rounding = written.largest;
    report_.warnings.insert(report_.warnings.end(), written.notes.begin(), written.notes.end());
    report_.files.push_back(scene_.mesh_out);
    for (const auto& beside : file_.included_files())
      report_.files.push_back((tree / beside).lexically_normal().string());
    if (report_.rounding > 1e-9 * original().size())
      report_.warnings.push_back(
          scene_.mesh_out + ": the number fields of this deck round coordinates by up to " +
          format_number(report_.rounding) + " " + scene_.unit +
          (report_.format.starts_with("Nastran") && !scene_.large_field_nodes
               ? "; large_field = true writes the moved nodes in large fields"
               : ""));
  }

  // In the order of construction.
  DeformScene scene_;  // with the parameters that meet its requirements
  const MorphTask& task_;
  const Progress& progress_;
  std::vector<ParameterSweep> ranges_;
  std::optional<DesignTable> design_;
  OutputFolder out_;
  DeformReport report_;
  Stopwatch watch_;
  const MeshSource source_;
  const MeshFile& file_;
  MorphSolver solver_;
  std::vector<MeshDimension> dimensions_;
  std::vector<Points> states_;     // before the first edit, and after each edit
  std::vector<DeformTask> tasks_;  // per edit
  std::vector<FailedCheck> failed_;
};

}  // namespace

DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const MorphTask& task, const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  DeformRun run(scene, folder, task, progress);
  run.require_replaceable();
  run.edit();
  run.measure();
  run.write();
  run.draw();
  run.study();
  return run.finish();
}

namespace {

std::vector<MeshPicture::Part> parts_of(const ShellMesh& shells, const SharedConstraints& shared,
                                        const DeformTask& task) {
  std::vector<MeshPicture::Part> vertex(shells.node_count(), MeshPicture::Part::Body);
  for (const int v : task.problem.fixed) vertex[v] = MeshPicture::Part::Fixed;
  for (const auto& h : task.problem.handles)
    for (const int v : h.vertices) vertex[v] = MeshPicture::Part::Handle;
  for (const auto& f : shared.features)
    for (const int v : f.vertices) vertex[v] = MeshPicture::Part::Feature;
  return parts_of_faces(shells, vertex);
}

}  // namespace

void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<DeformTask>& tasks,
                   const SharedConstraints& shared, const OutputFolder& out) {
  if (scene.pictures.empty()) return;
  using Show = MeshPictureSpec::Show;
  const auto parts = parts_of(file.shells(), shared, tasks.front());
  std::vector<Points> places;
  for (const Points& state : states) places.push_back(node_positions(state, file));
  for (const MeshPictureSpec& rule : scene.pictures) {
    if (!can_draw(report, rule.file)) continue;
    MeshPicture look;
    look.shells = &file.shells();
    look.parts = parts;
    look.lines = shared.lines;
    look.mesh = rule.mesh;
    look.azimuth = rule.azimuth;
    look.elevation = rule.elevation;
    look.up = rule.up;
    look.zoom = rule.zoom;
    for (const Points& state : places) look.also_in_view.push_back(&state);
    std::vector<MeshPicture> pictures;
    const auto add = [&](size_t state, const std::string& title) {
      look.points = places[state];
      look.title = title;
      pictures.push_back(look);
    };
    int columns = 1;
    if (rule.show == Show::BeforeAfter) {
      add(0, "before");
      add(states.size() - 1, "after");
      columns = 2;
    } else if (rule.show == Show::Steps) {
      add(0, "before");
      for (size_t k = 1; k < states.size(); ++k) add(k, scene.edits[k - 1].name);
      columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(states.size()))));
    } else {
      if (rule.show == Show::Displacement) {
        look.field = (places.back() - places.front()).rowwise().norm();
        look.field_title = "displacement [" + scene.unit + "]";
      }
      look.also_in_view.clear();
      add(states.size() - 1, rule.title);
    }
    draw_meshes(out.file(rule.file), pictures, columns, rule.size);
    report.files.push_back(rule.file);
  }
}

// Summary printed by `batten deform`.

std::string summary(const DeformReport& report, const std::filesystem::path& folder) {
  const std::string unit = " " + report.unit;
  std::string text = printable(report.name) + "\n";
  text += summary_line("mesh", std::to_string(report.nodes) + " nodes, " +
                                   std::to_string(report.faces) + " faces, " + report.format);
  for (const auto& [name, e] : report.edits)
    text += summary_line("edit", name + ": " + std::to_string(e.counts.unknowns) +
                                     " unknowns per coordinate, largest displacement " +
                                     format_number(e.largest_displacement) + unit + ", set-up " +
                                     format_number(1000 * e.setup_seconds) + " ms, edit " +
                                     format_number(1000 * e.edit_seconds) + " ms");
  double residual = 0, rigid = 0;
  for (const auto& e : report.edits) residual = std::max(residual, e.statistics.hard_residual);
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  text += summary_line("constraints", "residual " + format_number(residual) + " of the size");
  if (!report.features.empty())
    text += summary_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                         format_number(rigid) + " of their size");
  if (const auto& a = report.attached; !a.elements.empty()) {
    std::string words;
    for (const auto& [name, count] : a.elements)
      words += (words.empty() ? "" : ", ") + std::to_string(count) + " " + name;
    text += summary_line("attached",
                         words + "; " + std::to_string(a.connections) + " connections rigid to " +
                             format_number(a.max_rigid_error) + unit + ", " +
                             std::to_string(a.moved_with_shells) + " nodes moved with the shells");
  }
  for (const auto& c : report.curves)
    text += summary_line("curve", c.name + ": " + std::to_string(c.vertices) +
                                      " nodes, faired by " + format_number(c.fairing.max) + unit +
                                      ", curvature extrema " + std::to_string(c.before.extrema) +
                                      " -> " + std::to_string(c.after.extrema) + ", displacement " +
                                      format_number(c.largest_shift) + unit + ", residual " +
                                      format_number(c.max_residual));
  for (const auto& t : report.targets)
    text += summary_line("target",
                         t.file + ": " + std::to_string(t.followers) + " nodes, distance RMS " +
                             format_number(t.rms) + ", largest " + format_number(t.largest) +
                             "; from the target to the mesh RMS " + format_number(t.back_rms) +
                             ", largest " + format_number(t.back_largest) + unit + "; " +
                             std::to_string(t.ignored) + " nodes without a point of the target");
  for (const auto& d : report.dimensions) {
    std::string condition;
    for (const std::string& required : d.required) condition += ", required " + required;
    text += summary_line("dimension", d.name + ": " + format_number(d.before) + " -> " +
                                          format_number(d.after) +
                                          (d.unit.empty() ? "" : " " + d.unit) + condition);
  }
  if (!report.holes.empty()) {
    int kept = 0, round = 0;
    double radius = 0;
    for (const auto& h : report.holes) {
      if (h.feature.empty()) continue;
      ++kept;
      round += h.before.circular;
      radius = std::max(radius, std::abs(h.after.radius - h.before.radius) / h.before.radius);
    }
    text +=
        summary_line("holes", std::to_string(report.holes.size()) + " loops, " +
                                  std::to_string(kept) + " in features" +
                                  (kept == 0 ? ""
                                             : " (" + std::to_string(round) +
                                                   " round), largest relative change of a radius " +
                                                   format_number(radius)));
  }
  text += summary_line("quality", "aspect " + format_number(report.before.aspect.worst) + " -> " +
                                      format_number(report.after.aspect.worst) + ", warpage " +
                                      format_number(report.before.warpage_degrees.worst) + " -> " +
                                      format_number(report.after.warpage_degrees.worst) +
                                      " degrees, Jacobian " +
                                      format_number(report.before.jacobian.worst) + " -> " +
                                      format_number(report.after.jacobian.worst) + ", inverted " +
                                      std::to_string(report.inverted.size()));
  if (report.derivatives)
    text += summary_line("derivatives",
                         format_count(report.derivatives->parameters.size(), "parameter") +
                             ", estimated relative error " +
                             format_number(report.derivatives->largest_error) + ": " +
                             comma_separated(report.derivatives->files));
  if (report.variants)
    text += summary_line("variants", std::to_string(report.variants->count) + ", " +
                                         std::to_string(report.variants->failed) +
                                         " failed: " + report.variants->table);
  return text + summary_footer(report, folder);
}

}  // namespace batten
