#include "batten/apps/commands/meshes/run_deform.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "batten/apps/commands/meshes/deform_pictures.h"
#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/apps/commands/meshes/turn_estimate.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/core/box.h"
#include "batten/core/index.h"
#include "batten/io/decks/shell_deck.h"
#include "batten/io/vtk/shell_vtk.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/deform/similarity.h"

namespace batten {
namespace {

using Clock = std::chrono::steady_clock;

double largest_move(const Points& before, const Points& after, int* where = nullptr) {
  long row = 0;
  const double largest = before.rows() > 0 ? (after - before).rowwise().norm().maxCoeff(&row) : 0;
  if (where) *where = static_cast<int>(row);
  return largest;
}

/// Coordinates that change by roundings only are as they were, so that their text stays.
Points unmoved_as_before(const Points& before, const Points& after) {
  const double rounding =
      16 * std::numeric_limits<double>::epsilon() * before.cwiseAbs().maxCoeff();
  return ((after - before).array().abs() <= rounding).select(before, after);
}

void measure_into(DeformReport& report, const MeshFile& file, const TriangleMesh& original,
                  const Points& all_after, const Kept& kept) {
  const Points before = of_nodes(original.points(), file), after = of_nodes(all_after, file);
  const MeshTopology& topology = original.topology();
  for (const FormFeature& f : kept.features) {
    const Similarity fit = fit_similarity(before, after, f.vertices);
    const double angle = Eigen::AngleAxisd(fit.R).angle() * 180 / std::numbers::pi;
    const auto centre = VertexCombination::mean_of(f.vertices);
    Box3 box;
    for (const int v : f.vertices) box.extend(before.row(v).transpose());
    report.features.push_back({f.name, count_of(f.vertices), box.diagonal().norm(), fit.max_error,
                               fit.scale, angle, (centre.at(after) - centre.at(before)).norm()});
  }
  for (const MeshCurve& c : kept.curves)
    report.curves.push_back({c.name, count_of(c.vertices), c.curve.segment_count(), c.fairing,
                             c.wavelength, c.largest_shift,
                             distance_from(c, after) / original.size(), c.before, c.after});
  std::vector<int> feature_of(before.rows(), -1);
  for (size_t f = 0; f < kept.features.size(); ++f)
    for (const int v : kept.features[f].vertices) feature_of[v] = static_cast<int>(f);
  auto loops = topology.boundary_loops();
  for (auto& loop : loops)
    for (int& v : loop) v = topology.node_of(v);
  for (size_t l = 0; l < loops.size(); ++l) {
    DeformReport::Hole hole;
    hole.loop = static_cast<int>(l) + 1;
    hole.vertices = count_of(loops[l]);
    const int owner = feature_of[loops[l][0]];
    if (owner >= 0 && std::all_of(loops[l].begin(), loops[l].end(),
                                  [&](int v) { return feature_of[v] == owner; }))
      hole.feature = kept.features[owner].name;
    hole.before = measure_hole(before, loops[l]);
    hole.after = measure_hole(after, loops[l]);
    report.holes.push_back(hole);
  }
  report.before = summarize(file.shells(), before);
  report.after = summarize(file.shells(), after);
  for (auto* q : {&report.before, &report.after})
    for (auto* m : {&q->aspect, &q->warpage_degrees, &q->jacobian, &q->smallest_angle_degrees,
                    &q->largest_angle_degrees})
      if (m->worst_face >= 0) m->worst_face = static_cast<int>(file.face_label(m->worst_face));
  for (const int f : inverted_faces(file.shells(), before, after))
    report.inverted.push_back(file.face_label(f));
  report.size = original.size();
  report.largest_coordinate = std::max(before.cwiseAbs().maxCoeff(), after.cwiseAbs().maxCoeff());
  int where = 0;
  report.largest_displacement = largest_move(before, after, &where);
  report.largest_displacement_node = file.node_label(where);
}

void write_modes(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                 VertexSelector& select, const Points& after, const OutputFolder& out) {
  const ModesRule& rule = *scene.modes;
  ShellModes modes;
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
    write_shell_modes(out.file(name), shells, modes);
    report.files.push_back(name);
  }
}

/// The deformed mesh with what was done to it as data.
void write_result(const std::filesystem::path& path, const MeshFile& file, const Points& before,
                  const Points& after, const Kept& kept) {
  DeformedData data;
  data.displacement = after - before;
  data.feature.assign(before.rows(), -1);
  for (size_t f = 0; f < kept.features.size(); ++f)
    for (const int v : kept.features[f].vertices) data.feature[v] = static_cast<int>(f);
  for (const auto& f : kept.features) data.feature_names.push_back(f.name);
  ShellMesh shells = file.shells();
  shells.points = after;
  write_deformed_vtp(path, shells, data);
}

bool scales_features(const DeformEdit& edit) {
  return std::any_of(edit.feature_scales.begin(), edit.feature_scales.end(),
                     [](double scale) { return scale != 1; });
}

void count_into(DeformReport::Edit& report, const FormFeatureDeformer& deformer) {
  const auto c = deformer.counts();
  report.moving = c.moving;
  report.unknowns = c.unknowns;
  report.soft_rows = c.soft_rows;
  report.hard_rows = c.hard_rows;
  report.feature_rows = c.feature_rows;
  report.dropped_rows = c.dropped_rows;
  report.guide_rows = c.guide_rows;
  report.hard_residual = deformer.hard_residual();
}

/// One run of `batten deform`: the constructor reads, the other steps follow in their order.
class DeformRun {
 public:
  DeformRun(const DeformScene& scene, const std::filesystem::path& folder, const Progress& progress)
      : scene_(scene),
        progress_(progress),
        out_(folder),
        watch_(report_.timings),
        file_(read_mesh()),
        prepared_(prepare_mesh()),
        select_(make_selector()),
        attached_(file_, original(), scene.following),
        kept_(gather_kept()) {}

  /// Does the edits one after the other.
  void edit() {
    states_.push_back(original().points());
    for (size_t k = 0; k < scene_.edits.size(); ++k) {
      progress_.at(scene_.edits[k].name,
                   static_cast<double>(k) / static_cast<double>(scene_.edits.size()));
      edit_once(scene_.edits[k]);
    }
    watch_.lap("edits");
  }

  void measure() {
    progress_.at("measuring", 0);
    measure_into(report_, file_, original(), states_.back(), kept_);
    attached_.measure_into(report_, original().points(), states_.back());
    watch_.lap("measure");
  }

  void write() {
    progress_.at("files", 0);
    if (!scene_.mesh_out.empty()) write_mesh();
    if (!scene_.vtp.empty()) {
      write_result(out_.file(scene_.vtp), file_, of_nodes(states_.front(), file_),
                   of_nodes(states_.back(), file_), kept_);
      report_.files.push_back(scene_.vtp);
    }
    if (scene_.modes)
      write_modes(report_, scene_, file_, select_, of_nodes(states_.back(), file_), out_);
    watch_.lap("files");
  }

  void draw() {
    draw_deformed(report_, scene_, file_, states_, tasks_, kept_, out_);
    watch_.lap("pictures");
  }

  /// Writes report.json and lets all files appear.
  DeformReport finish() {
    watch_.total();
    write_report(report_, broken_promises(report_), out_, progress_);
    out_.commit();
    return std::move(report_);
  }

 private:
  const TriangleMesh& original() const { return prepared_.mesh; }

  MeshFile read_mesh() {
    report_.name = scene_.name;
    report_.unit = scene_.unit;
    report_.parameters = scene_.parameters();
    progress_.at("mesh", 0);
    MeshFile file = MeshFile::read(scene_.mesh);
    report_.warnings = file.warnings();
    report_.mesh_file = scene_.mesh.filename().string();
    report_.format = file.format();
    report_.nodes = file.shells().node_count();
    report_.faces = file.shells().face_count();
    return file;
  }

  PreparedMesh prepare_mesh() {
    try {
      PreparedMesh prepared =
          prepare(file_.shells(), [&](int v) { return std::to_string(file_.node_label(v)); });
      report_.warnings.insert(report_.warnings.end(), prepared.notes.begin(), prepared.notes.end());
      watch_.lap("mesh");
      return prepared;
    } catch (const InputError& e) {
      throw InputError(scene_.mesh.string() + ": " + e.what());
    }
  }

  VertexSelector make_selector() {
    progress_.at("features", 0);
    return VertexSelector(scene_, file_, original());
  }

  Kept gather_kept() {
    Kept kept = gather(scene_, select_, attached_, original());
    report_.warnings.insert(report_.warnings.end(), kept.notes.begin(), kept.notes.end());
    watch_.lap("features");
    return kept;
  }

  /// Errors name the edit and its place in the scene.
  void edit_once(const EditRule& rule) {
    const TriangleMesh mesh = original().with_points(states_.back());
    tasks_.push_back(task_of(scene_, rule, kept_, select_, mesh));
    const auto fail = [&](const std::string& why) {
      return scene_.at(rule.place) + "the edit '" + rule.name + "': " + why;
    };
    try {
      deform(rule, mesh, tasks_.back());
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), fail(""));
    } catch (const InputError& e) {
      throw InputError(fail(e.what()));
    } catch (const NoSolutionError& e) {
      throw NoSolutionError(fail(e.what()));
    }
  }

  void deform(const EditRule& rule, const TriangleMesh& mesh, Task& task) {
    DeformReport::Edit report;
    report.name = rule.name;
    const auto start = Clock::now();
    std::optional<ShapeEstimate> estimate = estimate_for(rule, task, prepared_, mesh, report);
    const auto solve = [&](FormFeatureDeformer& deformer, const DeformEdit& edit) {
      estimate ? deformer.deform(edit, *estimate) : deformer.deform(edit);
      if (estimate && rule.turn == EditRule::Turn::Found)
        settle(rule, task, edit, mesh, deformer, *estimate, report);
      deformer.correct();
    };
    if (rule.keep_centres && scales_features(task.edit)) {
      DeformEdit unscaled = task.edit;
      unscaled.feature_scales.clear();
      FormFeatureDeformer deformer(mesh, task.problem);
      solve(deformer, unscaled);
      task = with_kept_centres(std::move(task), kept_, deformer.positions());
    }
    FormFeatureDeformer deformer(mesh, task.problem);
    report.set_up_s = seconds_since(start);
    const auto begin = Clock::now();
    solve(deformer, task.edit);
    report.edit_s = seconds_since(begin);
    report.last_correction = deformer.correct();
    count_into(report, deformer);
    report.largest_displacement = largest_move(states_.back(), deformer.positions());
    report_.edits.push_back(report);
    if (!report.found)
      report_.warnings.push_back(rule.name + ": how the sheet turns did not settle in " +
                                 std::to_string(report.rounds) + " rounds");
    for (const auto& note : deformer.notes()) report_.warnings.push_back(rule.name + ": " + note);
    states_.push_back(unmoved_as_before(mesh.points(), deformer.positions()));
    attached_.follow(mesh.points(), states_.back(), task.problem.features);
  }

  /// Features lean on the sheet beside them, which they bend themselves.
  void settle(const EditRule& rule, const Task& task, const DeformEdit& edit,
              const TriangleMesh& mesh, FormFeatureDeformer& deformer, ShapeEstimate& estimate,
              DeformReport::Edit& report) const {
    constexpr int most_rounds = 20;
    constexpr double settled = 0.05;  // degrees
    report.found = false;
    for (report.rounds = 1; report.rounds < most_rounds && !report.found; ++report.rounds) {
      report.found = lean_on(rule, task, kept_.features.size(), mesh, deformer.positions(),
                             estimate) < settled;
      deformer.deform(edit, estimate);
    }
  }

  /// The mesh in the format of its file.
  void write_mesh() {
    const MeshWriteOptions options{scene_.wide_nodes, out_.folder()};
    const Points places = of_nodes(states_.back(), file_);
    report_.rounding = file_.write(out_.file(scene_.mesh_out), places, options).largest;
    report_.files.push_back(scene_.mesh_out);
    for (const auto& beside : file_.files_beside()) report_.files.push_back(beside.string());
    if (report_.rounding > 1e-9 * original().size())
      report_.warnings.push_back(scene_.mesh_out +
                                 ": the file's number fields round coordinates by up to " +
                                 number(report_.rounding) + " " + scene_.unit +
                                 (report_.format.starts_with("Nastran") && !scene_.wide_nodes
                                      ? "; wide_nodes = true writes the moved nodes in wide fields"
                                      : ""));
  }

  // In the order in which the constructor makes them.
  const DeformScene& scene_;
  const Progress& progress_;
  OutputFolder out_;
  DeformReport report_;
  Stopwatch watch_;
  const MeshFile file_;
  const PreparedMesh prepared_;
  VertexSelector select_;
  const AttachedNodes attached_;
  const Kept kept_;
  std::vector<Points> states_;  // before the first edit, and after each
  std::vector<Task> tasks_;     // of each edit
};

}  // namespace

DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const Progress& progress) {
  DeformRun run(scene, folder, progress);
  run.edit();
  run.measure();
  run.write();
  run.draw();
  return run.finish();
}

}  // namespace batten
