#include "batten/apps/commands/run_network.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/apps/commands/fair_lines.h"
#include "batten/apps/commands/make_model.h"
#include "batten/apps/commands/output_folder.h"
#include "batten/apps/commands/promises.h"
#include "batten/apps/commands/run_parts.h"
#include "batten/apps/commands/shape_files.h"
#include "batten/io/step_model.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace {

// A number that is not one must win over those that are.
void raise(double& most, double value) {
  if (!(value <= most) && !std::isnan(most)) most = value;
}
void lower(double& least, double value) {
  if (!(value >= least) && !std::isnan(least)) least = value;
}

SkinQuality worst_of(const SurfaceModel& model) {
  SkinQuality worst;
  bool first = true;
  for (const ModelRegion& r : model.regions) {
    if (!r.skinned) continue;
    const SkinQuality& q = r.quality;
    if (first) worst.min_jacobian_ratio = q.min_jacobian_ratio;
    first = false;
    raise(worst.max_line_residual, q.max_line_residual);
    raise(worst.max_line_gap, q.max_line_gap);
    raise(worst.max_line_deviation, q.max_line_deviation);
    raise(worst.max_normal_jump_deg, q.max_normal_jump_deg);
    lower(worst.min_jacobian_ratio, q.min_jacobian_ratio);
    raise(worst.max_shear, q.max_shear);
    raise(worst.rms_strain, q.rms_strain);
    worst.singular_nodes += q.singular_nodes;
  }
  worst.area = model.area;
  return worst;
}

// Of an arc that several regions have: it counts as embedded where one of them has it so.
void measure_lines(Report& report, const MadeModel& made) {
  struct Embedding {
    int points = 0;
    double gap = 0;
  };
  std::map<std::string, Embedding> embedded;
  for (const ModelRegion& r : made.model.regions) {
    if (!r.skinned) continue;
    for (const EmbeddedLine& e : r.skinned->embedded) {
      Embedding& of = embedded[e.line.name];
      of.points = std::max(of.points, static_cast<int>(e.points.size()));
      raise(of.gap, line_gap(r.skinned->surface, e));
    }
  }
  std::vector<char> outline(made.network.arcs().size()), inner(outline.size());
  for (const ModelRegion& r : made.model.regions) {
    for (const ArcLoop& loop : r.plan.loops)
      for (const ArcUse& use : loop) outline[static_cast<size_t>(use.arc)] = 1;
    for (const int a : r.plan.inner) inner[static_cast<size_t>(a)] = 1;
  }
  for (size_t a = 0; a < outline.size(); ++a) {
    if (!outline[a] && !inner[a]) continue;
    const NetworkArc& arc = made.network.arcs()[a];
    Report::Line line{
        arc.name,      outline[a] ? CharacterLine::Role::Outline : CharacterLine::Role::Inner,
        false,         arc.length,
        arc.deviation, arc.curve.node_count()};
    if (const auto e = embedded.find(arc.name); e != embedded.end()) {
      line.embedded = true;
      line.points = e->second.points;
      line.gap = e->second.gap;
    }
    report.lines.push_back(line);
  }
}

void measure_model(Report& report, const MadeModel& made, const Scene& scene) {
  measure_lines(report, made);
  report.network = network_report(made.network, made.found, made.model, made.fit_tolerance,
                                  scene.network->join_tolerance);
  auto& s = report.surface;
  s.regions = 0;
  for (const ModelRegion& r : made.model.regions) {
    if (!r.skinned) continue;
    ++s.regions;
    s.triangles += r.skinned->surface.mesh().triangle_count();
  }
  s.dofs = made.model.dofs;
  s.element = scene.skin.options.element == TriangleElement::HCT ? "hct" : "z12";
  s.hold = "lines";
  s.size = made.network.size();
  s.quality = worst_of(made.model);
  s.bending_energy = made.bending_energy;
  s.max_smooth_join_deg = made.model.max_join_deg;
  report.warnings.insert(report.warnings.end(), made.model.warnings.begin(),
                         made.model.warnings.end());
  for (const ModelRegion& r : made.model.regions)
    for (const std::string& w : r.warnings)
      report.warnings.push_back("region '" + r.plan.name + "': " + w);
  if (!made.found.optimal)
    report.warnings.push_back(
        "the search for regions was cut short: others may cost less; say yours by [[region]]");
}

void write_step_into(Report& report, const Scene& scene, const MadeModel& made,
                     const OutputFolder& out) {
  StepFaceOptions options;
  options.name = scene.name;
  constexpr double usual = 1e-4;
  options.tolerance = scene.step_tolerance > 0 ? scene.step_tolerance : usual * made.network.size();
  const StepModelReport step = write_step_model(out.file(scene.step), made.network, made.model,
                                                unit_in_metres(scene.unit), options);
  Report::Step& s = report.step.emplace();
  s.file = scene.step;
  s.form = "face";
  s.faces = step.faces;
  s.bytes = step.bytes;
  s.tolerance = options.tolerance;
  for (const StepFacePatch& patch : step.patches) {
    s.poles_u = std::max(s.poles_u, patch.poles_u);
    s.poles_v = std::max(s.poles_v, patch.poles_v);
  }
  s.max_deviation = step.deviation;
  s.max_gap = step.edge_gap;
  s.valid = step.valid;
  s.shells = step.shells;
  s.solids = step.solids;
  s.free_edges = step.free_edges;
  s.volume = step.volume;
  for (const auto& w : step.warnings) report.warnings.push_back(scene.step + ": " + w);
  report.files.push_back(scene.step);
}

void write_model_files(Report& report, const Scene& scene, const MadeModel& made,
                       const OutputFolder& out, Stopwatch& watch, const Progress& progress) {
  const auto regions = made.model.skinned();
  if (regions.empty()) return;
  if (!scene.compare.empty()) {
    compare_into(report, scene, regions, progress);
    watch.lap("compare");
  }
  // One region that a file cannot have does not take the others' files away.
  const auto unless_refused = [&](const std::string& file, const auto& write) {
    try {
      write();
    } catch (const InputError& e) {
      report.missed.push_back({file, std::string("is not written: ") + e.what()});
    }
  };
  if (!scene.step.empty()) {
    progress.at("STEP", 0);
    unless_refused(scene.step, [&] { write_step_into(report, scene, made, out); });
    watch.lap("step");
  }
  if (scene.vtp.empty() && scene.vtu.empty()) return;
  progress.at("VTK", 0);
  VtkOptions vtk;
  vtk.lines = vtk_lines(made.network, made.model);
  const auto write_vtk = [&](const std::string& file, const auto& write) {
    if (file.empty()) return;
    unless_refused(file, [&] {
      write(out.file(file), regions, vtk);
      report.files.push_back(file);
    });
  };
  write_vtk(scene.vtp, write_vtp);
  write_vtk(scene.vtu, write_vtu);
  watch.lap("vtk");
}

PictureScene model_picture(const PictureScene& look, const MadeModel& made) {
  PictureScene picture = look;
  picture.regions = made.model.skinned();
  for (const int a : made.found.bare)
    picture.loose.push_back(made.network.arcs()[static_cast<size_t>(a)].curve);
  return picture;
}

// Pictures need a display; a result without them is still a result, but not what was asked for.
void draw_pictures(Report& report, const Scene& scene, const MadeModel& made,
                   const OutputFolder& out, const Progress& progress) {
  for (const auto& picture : scene.pictures) {
    try {
      require_display();
      progress.at("picture " + picture.file, 0);
      draw_picture(out.file(picture.file), model_picture(picture.look, made), picture.size);
      report.files.push_back(picture.file);
    } catch (const InputError& e) {
      report.missed.push_back({picture.file, std::string("is not drawn: ") + e.what()});
    }
  }
}

}  // namespace

Report run_network(const Scene& scene, const std::filesystem::path& folder,
                   const Progress& progress) {
  OutputFolder out(folder);
  Report report;
  report.name = scene.name;
  report.unit = scene.unit;
  report.parameters = scene.parameters();
  Stopwatch watch(report.timings);

  progress.at("lines", 0);
  const FairedLines lines = faired_lines(scene, progress);
  report.curves = lines.reports;
  watch.lap("lines");
  const MadeModel made = make_model(scene, lines.lines, progress);
  watch.lap("model");
  measure_model(report, made, scene);
  watch.lap("measure");
  write_model_files(report, scene, made, out, watch, progress);
  if (!scene.pictures.empty()) {
    draw_pictures(report, scene, made, out, progress);
    watch.lap("pictures");
  }
  watch.total();

  const auto broken = broken_network_promises(report);
  report.missed.insert(report.missed.end(), broken.begin(), broken.end());
  report.files.push_back("report.json");
  write_whole_file(out.file("report.json"), [&](std::ostream& file) { file << to_json(report); });
  progress.at("files", 1);
  out.commit();
  return report;
}

void view_network(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                  const Progress& progress) {
  require_display();
  const MadeModel made = make_model(scene, faired_lines(scene, progress).lines, progress);
  draw_picture(file, model_picture(look, made));
}

}  // namespace batten
