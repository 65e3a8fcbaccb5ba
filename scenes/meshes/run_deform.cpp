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
#include "batten/mesh/rotation_fitting.h"
#include "batten/scenes/meshes/morph_solver.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

// Pictures of a deformed mesh.

/// Draws the pictures of a scene. `states`: positions of all vertices before the first edit and
/// after each edit.
void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<DeformTask>& tasks,
                   const SharedConstraints& shared, const OutputFolder& out);

namespace {

double largest_move(const Points& before, const Points& after, int* where = nullptr) {
  long row = 0;
  const double largest = before.rows() > 0 ? (after - before).rowwise().norm().maxCoeff(&row) : 0;
  if (where) *where = static_cast<int>(row);
  return largest;
}

void measure_into(DeformReport& report, const MeshFile& file, const TriangleMesh& original,
                  const Points& all_after, const SharedConstraints& shared) {
  const Points before = node_positions(original.points(), file),
               after = node_positions(all_after, file);
  const MeshTopology& topology = original.topology();
  for (const FormFeature& f : shared.features) {
    const Similarity fit = fit_similarity(before, after, f.vertices);
    const double angle = Eigen::AngleAxisd(fit.R).angle() * 180 / std::numbers::pi;
    const auto centre = VertexCombination::mean_of(f.vertices);
    Box3 box;
    for (const int v : f.vertices) box.extend(before.row(v).transpose());
    report.features.push_back({f.name, isize(f.vertices), box.diagonal().norm(), fit.max_error,
                               fit.scale, angle, (centre.at(after) - centre.at(before)).norm()});
  }
  for (const MeshCurve& c : shared.curves)
    report.curves.push_back({c.name, isize(c.vertices), c.shape.curve.segment_count(),
                             c.shape.fairing, c.shape.wavelength, c.shape.largest_shift,
                             distance_from(c, after) / original.size(), c.shape.before,
                             c.shape.after});
  std::vector<int> feature_of(before.rows(), -1);
  for (size_t f = 0; f < shared.features.size(); ++f)
    for (const int v : shared.features[f].vertices) feature_of[v] = static_cast<int>(f);
  auto loops = topology.boundary_loops();
  for (auto& loop : loops)
    for (int& v : loop) v = topology.node_of(v);
  for (size_t l = 0; l < loops.size(); ++l) {
    DeformReport::Hole hole;
    hole.loop = static_cast<int>(l) + 1;
    hole.vertices = isize(loops[l]);
    const int owner = feature_of[loops[l][0]];
    if (owner >= 0 && std::all_of(loops[l].begin(), loops[l].end(),
                                  [&](int v) { return feature_of[v] == owner; }))
      hole.feature = shared.features[owner].name;
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

/// Reports how the attached elements moved.
void measure_attached_into(DeformReport& report, const MeshFile& file,
                           const AttachedNodes& attached, const Points& before,
                           const Points& after) {
  const auto& elements = file.other_elements();
  std::map<std::string, int> count;
  for (const NonShellElement& e : elements) ++count[e.name];
  const AttachedMotion motion = attached.motion(before, after);
  report.attached.elements.assign(count.begin(), count.end());
  report.attached.connections = motion.connections;
  report.attached.max_rigid_error = motion.max_rigid_error;
  report.attached.worst_connection = motion.worst_connection;
  report.attached.moved_with_shells = motion.moved_nodes;
  for (const int e : motion.inverted_solids)
    report.attached.inverted_solids.push_back(elements[e].label);
  if (motion.max_gap_change > 1e-6 * report.size)
    report.warnings.push_back(motion.worst_tie +
                              ": tied nodes leave their surface, the gap changes by up to " +
                              format_number(motion.max_gap_change) + " " + report.unit +
                              ", because handles, fixed nodes or features prescribe their motion");
}

/// Names nodes that belong to no shell and do not move, while the mesh next to them does.
void note_left_behind(DeformReport& report, const MeshFile& file, const TriangleMesh& original,
                      const AttachmentOptions& options, const Points& before, const Points& after) {
  const ShellMesh& shells = file.shells();
  std::vector<char> known(static_cast<size_t>(shells.node_count()), 0);
  for (int f = 0; f < shells.face_count(); ++f)
    for (const int v : shells.face(f)) known[v] = 1;
  std::map<std::string, std::vector<int>> left;  // by the type of an element
  const auto stays = [&](int v) { return !known[v] && before.row(v) == after.row(v); };
  for (const NonShellElement& e : file.other_elements())
    for (const int v : e.nodes)
      if (stays(v)) {
        if (options.of(e.kind) != AttachmentRule::Stay) left["of " + e.name].push_back(v);
        known[v] = 1;
      }
  for (int v = 0; v < shells.node_count(); ++v)
    if (stays(v)) left["of no element"].push_back(v);
  if (left.empty()) return;
  const TriangleTree tree(original);
  for (auto& [kind, nodes] : left) {
    double farthest = 0;
    std::string labels;
    int count = 0;
    for (const int v : nodes) {
      const auto closest = tree.nearest(before.row(v).transpose());
      double moved = 0;
      for (int k = 0; closest && k < 3; ++k) {
        const int corner = original.topology().node_of(
            original.triangles()[closest->triangle][static_cast<size_t>(k)]);
        moved = std::max(moved, (after.row(corner) - before.row(corner)).norm());
      }
      if (!(moved > 1e-9 * report.size)) continue;
      farthest = std::max(farthest, moved);
      constexpr int kMostNamed = 5;
      if (count < kMostNamed)
        labels += (count ? ", " : "") + std::to_string(file.node_label(v));
      else if (count == kMostNamed)
        labels += ", …";
      ++count;
    }
    if (count > 0)
      report.warnings.push_back(format_count(count, "node") + " " + kind + " (" + labels +
                                ") stay in place: no connection leads to a shell, and the shells "
                                "next to them move by up to " +
                                format_number(farthest) + " " + report.unit +
                                "; select them in a handle if they belong to the moved part");
  }
}

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
  DeformRun(const DeformScene& scene, const std::filesystem::path& folder, const Progress& progress)
      : scene_(scene),
        progress_(progress),
        out_(folder),
        watch_(report_.timings),
        source_(read_mesh()),
        file_(source_.file),
        solver_(scene, source_) {}

  /// Checks the names of the output files, see OutputFolder::require_replaceable().
  void require_replaceable() const {
    std::vector<std::string> names{scene_.mesh_out, scene_.vtp, "report.json"};
    if (scene_.modes) names.insert(names.end(), {scene_.modes->before, scene_.modes->after});
    for (const MeshPictureSpec& rule : scene_.pictures) names.push_back(rule.file);
    out_.require_replaceable(names);
  }

  /// Performs the edits in order.
  void edit() {
    solver_.solve(scene_, progress_);
    const std::vector<std::string>& notes = shared().notes;
    report_.warnings.insert(report_.warnings.end(), notes.begin(), notes.end());
    states_ = solver_.states();
    for (const auto& edit : solver_.edits()) add_to_report(*edit);
    watch_.lap("edits");
  }

  void measure() {
    progress_.update("measuring", 0);
    measure_into(report_, file_, original(), states_.back(), shared());
    measure_attached_into(report_, file_, solver_.attached(), original().points(), states_.back());
    note_left_behind(report_, file_, original(), scene_.following, original().points(),
                     states_.back());
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

  /// Writes report.json and commits all files.
  DeformReport finish() {
    watch_.total();
    write_report(report_, failed_checks(report_), out_, progress_);
    out_.commit();
    return std::move(report_);
  }

 private:
  const TriangleMesh& original() const { return solver_.mesh(); }
  const SharedConstraints& shared() const { return solver_.shared(); }

  MeshSource read_mesh() {
    report_.name = scene_.name;
    report_.unit = scene_.unit;
    report_.parameters = scene_.parameters();
    progress_.update("mesh", 0);
    MeshSource source = read_source(scene_.mesh);
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

  void add_to_report(const EditSession& edit) {
    tasks_.push_back(edit.task());
    const std::string& name = edit.rule().name;
    const MeshEditStatistics& statistics = edit.statistics();
    report_.edits.push_back({name, statistics});
    if (!statistics.converged)
      report_.warnings.push_back(name + ": the estimated rotations did not converge in " +
                                 std::to_string(statistics.iterations) + " iterations");
    for (const auto& note : edit.notes()) report_.warnings.push_back(name + ": " + note);
  }

  /// Writes the mesh in the format of its file.
  void write_mesh() {
    const MeshWriteOptions options{scene_.large_field_nodes, out_.folder()};
    const Points places = node_positions(states_.back(), file_);
    const MeshFile::Rounding written = file_.write(out_.file(scene_.mesh_out), places, options);
    report_.rounding = written.largest;
    report_.warnings.insert(report_.warnings.end(), written.notes.begin(), written.notes.end());
    report_.files.push_back(scene_.mesh_out);
    for (const auto& beside : file_.included_files()) report_.files.push_back(beside.string());
    if (report_.rounding > 1e-9 * original().size())
      report_.warnings.push_back(
          scene_.mesh_out + ": the number fields of this deck round coordinates by up to " +
          format_number(report_.rounding) + " " + scene_.unit +
          (report_.format.starts_with("Nastran") && !scene_.large_field_nodes
               ? "; large_field = true writes the moved nodes in large fields"
               : ""));
  }

  // In the order of construction.
  const DeformScene& scene_;
  const Progress& progress_;
  OutputFolder out_;
  DeformReport report_;
  Stopwatch watch_;
  const MeshSource source_;
  const MeshFile& file_;
  MorphSolver solver_;
  std::vector<Points> states_;     // before the first edit, and after each edit
  std::vector<DeformTask> tasks_;  // per edit
};

}  // namespace

DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  DeformRun run(scene, folder, progress);
  run.require_replaceable();
  run.edit();
  run.measure();
  run.write();
  run.draw();
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
  return text + summary_footer(report, folder);
}

}  // namespace batten
