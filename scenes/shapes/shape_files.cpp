// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/shape_files.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/mesh_neighbours.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/lines/scene_neighbours.h"
#include "batten/scenes/shapes/stress_setup.h"
#include "batten/skinning/facets/welded_mesh.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

RunContext::RunContext(const Scene& scene, const std::filesystem::path& folder)
    : out(folder), watch(report.timings) {
  report.name = scene.name;
  report.unit = scene.unit;
  report.is_sculpted = scene.is_sculpted();
  report.surface.boundary =
      scene.skin.boundary == SceneSkin::FixedBoundary::Corners ? "corners" : "curves";
  report.surface.fair = scene.skin.fair_name();
}

void RunContext::require_replaceable(const Scene& scene) const {
  std::vector<std::string> names{scene.step, scene.vtu,      scene.vtp,
                                 scene.mesh, scene.calculix, "report.json"};
  for (const ScenePicture& picture : scene.pictures) names.push_back(picture.file);
  out.require_replaceable(names);
}

void RunContext::finish(const Progress& progress) {
  watch.total();
  write_report(report, failed_checks(report, tolerance), out, progress);
}

BuiltModel model_of(RunContext& run, const Scene& scene, const Progress& progress) {
  progress.update("curves", 0);
  const FairedLines lines = faired_lines(scene, progress);
  run.report.curves = lines.reports;
  run.report.reading_notes = lines.reading_notes;
  run.report.warnings = lines.warnings;
  run.watch.lap("curves");
  BuiltModel made = build_model(scene, lines.lines, progress);
  run.require_replaceable(scene);
  run.tolerance = made.fit_tolerance;
  run.watch.lap("model");
  return made;
}

namespace {

// The root mean square is weighted by surface area.
void compare_into(Report& report, const Scene& scene,
                  const std::vector<const SkinnedRegion*>& regions, const Progress& progress) {
  const auto faces = cad_plugin().read_cad_surfaces(scene.compare, unit_in_metres(scene.unit));
  if (faces.empty())
    throw InputError(scene.compare.string() +
                     ": found no faces to compare with, expected at least one");
  const TriangleRule whole = split_triangle_rule(2);
  Report::Comparison c;
  c.file = scene.compare.filename().string();
  double squares = 0, area = 0;
  size_t first = 0;
  Box3 box(regions.front()->surface.position({0, Vec3::Unit(0)}));
  for (size_t r = 0; r < regions.size(); ++r) {
    const Surface& surface = regions[r]->surface;
    const Trim* trim = surface.trim().get();
    const ParametricMesh& mesh = surface.mesh();
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      progress.update("comparing",
                      (static_cast<double>(r) + static_cast<double>(t) / mesh.triangle_count()) /
                          static_cast<double>(regions.size()));
      if (trim && trim->side(t) == Trim::Side::Outside) continue;
      const TriangleRule rule = trim && trim->side(t) == Trim::Side::Cut ? trim->rule(t, 2) : whole;
      for (long p = 0; p < rule.weights.size(); ++p) {
        if (!(rule.weights[p] > 0)) continue;
        const SurfaceJet jet = surface.jet({t, rule.L.row(p).transpose()});
        const double nearest = cad_plugin().distance(faces, jet.x, first);
        const double weight = rule.weights[p] * mesh.shape(t).area * jet.area_vector().norm();
        squares += weight * nearest * nearest;
        area += weight;
        c.max = std::max(c.max, nearest);
        box.extend(jet.x);
        ++c.points;
      }
    }
  }
  c.rms = std::sqrt(squares / area);
  const double length = box.sizes().maxCoeff();
  c.max_relative = c.max / length;
  c.rms_relative = c.rms / length;
  report.comparison = c;
}

using Regions = std::vector<const SkinnedRegion*>;

/// Writes a file by calling `write` with a list of region indices, at first all of them. If it
/// rejects regions of a network without naming them, each one is tried separately, on a copy of the
/// report. The valid regions are written; report.failed_checks lists the others.
template <class Write>
void write_valid_regions(Report& report, const OutputFolder& out, const std::string& file,
                         const Regions& regions, bool of_network, const Write& write) {
  std::string why;
  std::vector<const SkinnedRegion*> unwritable;
  const auto refused = [&](const std::vector<int>& some, Report& into) {
    unwritable.clear();
    Report next = into;
    try {
      write(some, next);
    } catch (const CancelledError&) {
      throw;
    } catch (const FileError&) {
      throw;
    } catch (const Error& e) {
      if (!of_network) throw;
      why = e.what();
      if (const auto* error = dynamic_cast<const UnwritableRegions*>(&e))
        unwritable = error->regions();
      return true;
    }
    into = std::move(next);
    return false;
  };
  std::vector<int> good(regions.size());
  std::iota(good.begin(), good.end(), 0);
  while (!good.empty() && refused(good, report)) {
    const std::string of_all = why;
    const auto found = unwritable;
    std::vector<int> rest;
    for (const int r : good) {
      Report trial = report;
      if (found.empty() ? !refused({r}, trial)
                        : std::count(found.begin(), found.end(), regions[r]) == 0)
        rest.push_back(r);
      else
        report.failed_checks.push_back(
            {file, "does not contain face '" + regions[r]->name + "': " + why});
    }
    if (rest.size() == good.size()) rest.clear();  // no single region is responsible
    if (rest.empty()) report.failed_checks.push_back({file, "is not written: " + of_all});
    good = std::move(rest);
  }
  if (good.empty()) {
    std::filesystem::remove(out.file(file));  // left by a trial
    return;
  }
  report.files.push_back(file);
}

template <class Whole>
std::vector<Whole> picked(const std::vector<Whole>& all, const std::vector<int>& which) {
  std::vector<Whole> some;
  for (const int i : which) some.push_back(all[i]);
  return some;
}

// Inverted surfaces cannot be fitted with a face.
Regions with_faces(Report& report, const SurfaceModel& model) {
  std::set<int> over;
  for (const SurfaceDefect& defect : model.defects)
    if (defect.kind == SurfaceDefect::Kind::Jacobian) over.insert(defect.regions[0]);
  Regions regions;
  for (int r = 0; r < isize(model.regions); ++r) {
    const ModelRegion& region = model.regions[r];
    if (region.skinned && !over.count(r)) regions.push_back(&*region.skinned);
    if (region.skinned && over.count(r))
      report.warnings.push_back("the STEP file does not contain face '" + region.plan.name +
                                "': its surface is inverted");
  }
  return regions;
}

StepReport exact_step(Report& report, const Scene& scene, const StepFileOptions& words,
                      const std::vector<const SkinnedRegion*>& regions,
                      const std::filesystem::path& file) {
  const std::string warning = cad_plugin().step_size_warning(regions);
  if (!warning.empty())
    report.warnings.push_back(warning +
                              "; step_form = \"face\" writes one STEP face for each face");
  StepOptions options;
  options.file = words;
  options.z12_as_hct = true;
  const StepReport step =
      cad_plugin().write_step(file, regions, unit_in_metres(scene.unit), options);
  if (step.unmeasured > 0)
    report.failed_checks.push_back(
        {"step", "has " + format_count(step.unmeasured, "point") + " that could not be measured"});
  if (regions.front()->surface.kind() == TriangleElement::Z12)
    report.warnings.push_back(scene.step +
                              ": STEP has no form for the rational Z12 triangles; written as HCT "
                              "triangles with the same edges, max distance " +
                              format_number(step.max_deviation.value_or(std::nan(""))) + " " +
                              scene.unit);
  return step;
}

// The given surfaces at smooth joins, by the name of the curve.
std::map<std::string, std::shared_ptr<const NeighbourEdge>> tangent_neighbours(
    const SurfaceModel& model) {
  std::map<std::string, std::shared_ptr<const NeighbourEdge>> all;
  for (const ModelJoin& join : model.joins)
    if (join.neighbour && join.kind == ModelJoin::Kind::Smooth) all[join.line] = join.neighbour;
  return all;
}

// The primitives that faces continue with all of their edges, by the name of the face: those on
// which the edges of the given faces lie exactly.
void add_continued_primitives(const SurfaceModel& model, double size,
                              std::map<std::string, FittedPrimitive>& primitives) {
  constexpr double exact = 1e-7;  // of the size
  for (size_t r = 0; r < model.regions.size(); ++r) {
    const ModelRegion& region = model.regions[r];
    if (!region.skinned) continue;
    Points positions(0, 3), normals(0, 3);
    bool all = true;
    for (const ModelJoin& join : model.joins) {
      if (std::find(join.regions.begin(), join.regions.end(), static_cast<int>(r)) ==
          join.regions.end())
        continue;
      const auto side = side_of(*region.skinned, 0, join.line);
      all = all && side && join.neighbour && join.kind == ModelJoin::Kind::Smooth;
      if (all) join.neighbour->sample(side->left, positions, normals);
    }
    if (!all || positions.rows() == 0) continue;
    const FittedPrimitive found = fit_primitive(positions, normals, exact * size);
    if (found.kind != FittedPrimitive::Kind::Free) primitives[region.skinned->name] = found;
  }
}

StepReport face_step(Report& report, const Scene& scene, const BuiltModel& made,
                     const StepFileOptions& words, const std::vector<const SkinnedRegion*>& regions,
                     const std::filesystem::path& file) {
  StepFaceOptions options;
  options.file = words;
  constexpr double usual = 1e-4;
  options.tolerance = scene.step_tolerance > 0 ? scene.step_tolerance : usual * report.surface.size;
  if (report.target) options.primitives = report.target->primitives;
  options.neighbours = tangent_neighbours(made.model);
  if (!options.neighbours.empty())
    add_continued_primitives(made.model, report.surface.size, options.continued_primitives);
  const StepReport step =
      cad_plugin().write_step_faces(file, regions, unit_in_metres(scene.unit), options);
  report.step->tolerance = options.tolerance;
  for (const StepPatch& patch : step.patches) {
    report.step->poles_u = std::max(report.step->poles_u, patch.poles_u);
    report.step->poles_v = std::max(report.step->poles_v, patch.poles_v);
    ++report.step->faces_by_kind[patch.surface];
  }
  return step;
}

/// True if each face of the model is a whole analytic face of one CAD file, or a part of it, and lies
/// on it within the tolerance: nothing but the faces of that file has been fitted or sculpted.
bool reproduces_target(const Report& report, const Scene& scene, const BuiltModel& made,
                       const Regions& regions) {
  if (!report.target || !report.target->analytic || !report.target->reached ||
      scene.is_sculpted() || scene.step_form == Scene::StepForm::Exact || scene.step_lines ||
      scene.targets.size() != 1 || scene.lines.size() != 1 || scene.network.symmetry)
    return false;
  const SceneLine& lines = scene.lines.front();
  return lines.creases && lines.file == scene.targets.front().file && lines.only.empty() &&
         lines.skip.empty() && made.found && regions.size() == made.model.regions.size() &&
         regions.size() == scene.network.regions.size() &&
         report.target->back_excluded * 100 <= report.target->back_points;
}

/// Numbers of CAD faces per surface, from the names "face 3" or "face 3.1" of the model's faces.
std::map<std::string, int> kinds_of_target(const BuiltModel& made) {
  std::map<std::string, std::string> kinds;
  for (const ModelRegion& region : made.model.regions) {
    const std::string& name = region.plan.name;
    const std::string kind = primitive_name(region.shape.kind);
    kinds[name.substr(0, name.find('.'))] = kind.empty() ? "swept surface" : kind;
  }
  std::map<std::string, int> counts;
  for (const auto& [face, kind] : kinds) ++counts[kind];
  return counts;
}

/// Writes the faces of the target's file, with their names and colours, in the unit of the scene.
/// nullopt, without a file, if they are not as closed as the model (the faces of many IGES files
/// share no edges) or if OpenCASCADE does not accept them.
std::optional<StepReport> target_step(Report& report, const Scene& scene, const BuiltModel& made,
                                      const std::filesystem::path& file) {
  const double unit = unit_in_metres(scene.unit);
  CadConvertOptions options;
  options.unit_in_metres = unit;
  options.ap242 = scene.step_ap242;
  const CadConversion made_of = cad_plugin().convert_cad(scene.targets.front().file, file, options);
  const bool closed = std::all_of(made.model.shells.begin(), made.model.shells.end(),
                                  [](const ModelShell& shell) { return shell.closed; });
  const CadContents& after = made_of.after;
  if (after.faces != made_of.before.faces || (closed && after.closed_shells != after.shells)) {
    std::filesystem::remove(file);
    return std::nullopt;
  }
  StepReport step = cad_plugin().check_step(file, unit, {});
  const std::string source = scene.targets.front().file.filename().string();
  if (!step.valid) {
    std::filesystem::remove(file);
    report.warnings.push_back(scene.step + ": OpenCASCADE finds the faces of " + source +
                              " invalid; the fitted faces are written instead");
    return std::nullopt;
  }
  step.continuity = cad_plugin().measure_continuity(file, unit, {});
  step.max_normal_jump_deg = 0;  // check_step() counts the creases of the part
  step.max_deviation = std::max(report.target->max, report.target->back_max);
  report.step->tolerance = report.target->tolerance;
  report.step->faces_by_kind = kinds_of_target(made);
  report.step->source = source;
  return step;
}

// Warns of smooth joins whose faces meet at an angle in the file.
void warn_of_joins(Report& report, const Scene& scene) {
  const Report::Step& step = *report.step;
  const Report::Step::Join* worst = nullptr;
  long missed = 0;
  for (const auto& join : step.joins) {
    if (!join.exceeds_tolerance) continue;
    ++missed;
    if (!worst || join.angle_deg > worst->angle_deg) worst = &join;
  }
  if (!worst) return;
  report.warnings.push_back(scene.step + ": " + std::to_string(missed) + " of " +
                            format_count(isize(step.joins), "smooth edge") +
                            (missed == 1 ? " exceeds" : " exceed") + " the angle of " +
                            format_number(StepFaceOptions{}.join_deg) +
                            " degrees in the file, worst '" + worst->line + "' with " +
                            format_number(worst->angle_deg) + " (step_form = \"exact\" keeps the " +
                            format_number(worst->surface_deg) + " degrees of the surface)");
}

/// Joins the faces of the STEP file to the given faces along their common edges, one file of given
/// faces after the other.
void join_neighbours(Report& report, const Scene& scene, const BuiltModel& made,
                     const std::filesystem::path& file) {
  Report::Step& s = *report.step;
  double apart = 0;
  size_t smooth = 0;
  for (const ModelJoin& join : made.model.joins) {
    if (!join.neighbour) continue;
    apart = std::max(apart, join.neighbour->distance());
    smooth += join.kind == ModelJoin::Kind::Smooth;
  }
  CadJoinOptions options;
  options.model_unit_in_metres = unit_in_metres(scene.unit);
  options.tolerance = 2 * (apart + made.fit_tolerance + s.max_gap + s.tolerance);
  options.ap242 = scene.step_ap242;
  Report::Step::Neighbours& found = s.neighbours.emplace();
  for (const SceneNeighbour& given : scene.neighbours) {
    if (MeshFile::can_read(given.file)) continue;
    options.only = given.faces;
    options.without = given.without;
    const CadJoinReport joined = cad_plugin().join_cad_files(given.file, file, file, options);
    const int before = joined.faces - joined.added;
    found.file += (found.file.empty() ? "" : ", ") + given.file.filename().string();
    found.faces += before;
    s.faces = joined.faces;
    s.solids = joined.solids;
    s.shells = joined.shells;
    s.valid = joined.valid;
    s.volume = joined.volume;
    s.free_edges = joined.continuity.free_edges;
    using Kind = EdgeContinuity::Kind;
    s.creases = joined.continuity.count(Kind::Crease);
    s.tangent = joined.continuity.count(Kind::Tangent);
    s.curvature = joined.continuity.count(Kind::Curvature);
    s.max_smooth_deg = joined.continuity.max_smooth_deg();
    std::vector<double> angles;
    for (const EdgeContinuity& edge : joined.continuity.inner) {
      if ((edge.faces[0] > before) == (edge.faces[1] > before)) continue;
      ++found.edges;
      found.smooth_edges += edge.kind != Kind::Crease;
      found.max_gap = std::max(found.max_gap, edge.gap);
      angles.push_back(edge.angle_deg);
    }
    // The smooth joins of the model are the edges with the smallest angles.
    std::sort(angles.begin(), angles.end());
    const size_t count = std::min(smooth, angles.size());
    if (count > 0) found.max_smooth_deg = std::max(found.max_smooth_deg, angles[count - 1]);
  }
}

bool has_cad_neighbours(const Scene& scene) {
  return std::any_of(scene.neighbours.begin(), scene.neighbours.end(),
                     [](const SceneNeighbour& given) { return !MeshFile::can_read(given.file); });
}

void write_step_into(Report& report, const Scene& scene, const BuiltModel& made,
                     const Regions& regions, const OutputFolder& out) {
  using Form = Scene::StepForm;
  const bool cut = std::any_of(regions.begin(), regions.end(),
                               [](const SkinnedRegion* r) { return r->surface.trim(); });
  if (scene.step_form == Form::Exact && cut && !made.network)
    throw InputError(scene.at({}) +
                     "found step_form = \"exact\" for a surface that is trimmed by embedded "
                     "curves, expected \"face\": trimmed triangles have no exact form");
  Report::Step& s = report.step.emplace(Report::Step{});
  s.form = scene.step_form == Form::Exact ? "exact" : "face";
  s.file = scene.step;
  StepFileOptions words;
  words.name = scene.name;
  words.ap242 = scene.step_ap242;
  if (scene.step_lines)
    words.lines = model_curves(made.model, made.network ? &*made.network : nullptr);
  const std::filesystem::path file = out.file(scene.step);
  std::optional<StepReport> of_target;
  if (reproduces_target(report, scene, made, regions))
    of_target = target_step(report, scene, made, file);
  StepReport step = of_target          ? *std::move(of_target)
                    : s.form == "face" ? face_step(report, scene, made, words, regions, file)
                                       : exact_step(report, scene, words, regions, file);
  constexpr int few_triangles = 10'000;
  if (scene.step_form == Form::Auto && scene.neighbours.empty() && !cut && regions.size() == 1 &&
      !step.reached && regions.front()->surface.mesh().triangle_count() <= few_triangles) {
    report.warnings.push_back("a single fitted face in '" + scene.step + "' would deviate by " +
                              format_number(step.max_deviation.value_or(std::nan(""))) + " " +
                              scene.unit +
                              " from the surface; written with three faces per triangle instead");
    s.form = "exact";
    s.tolerance = s.poles_u = s.poles_v = 0;
    s.faces_by_kind.clear();
    step = exact_step(report, scene, words, regions, out.file(scene.step));
  }
  s.faces = step.faces;
  s.bytes = step.bytes;
  s.lines = step.curves;
  if (step.curves != isize(words.lines))
    report.failed_checks.push_back(
        {"step.curves",
         "is " + std::to_string(step.curves) + ", expected " + std::to_string(words.lines.size())});
  s.max_deviation = step.max_deviation.value_or(std::nan(""));
  s.max_gap = step.max_gap;
  s.max_normal_jump_deg = s.form == "face" ? 0 : step.max_normal_jump_deg;
  s.valid = step.valid;
  if (const auto& edges = step.continuity) {
    using Kind = EdgeContinuity::Kind;
    s.creases = edges->count(Kind::Crease);
    s.tangent = edges->count(Kind::Tangent);
    s.curvature = edges->count(Kind::Curvature);
    s.max_smooth_deg = edges->max_smooth_deg();
  }
  const auto neighbours = tangent_neighbours(made.model);
  s.joins.clear();
  for (const StepJoin& join : step.joins) {
    const bool of_surfaces = join.reached && join.angle_deg > StepFaceOptions{}.join_deg;
    std::array<std::string, 2> faces = join.regions;
    if (const auto given = neighbours.find(join.line);
        given != neighbours.end() && faces[1].empty())
      faces[1] = given->second->names().front();
    s.joins.push_back({join.line, faces, join.angle_deg, join.surface_deg, !join.reached,
                       of_surfaces ? "the surfaces meet at up to " +
                                         format_number(join.surface_deg) + " degrees there"
                                   : ""});
  }
  s.max_join_deg = step.max_join_deg;
  warn_of_joins(report, scene);
  s.shells = step.shells;
  s.solids = step.solids;
  s.free_edges = step.free_edges;
  s.volume = step.volume;
  if (has_cad_neighbours(scene) && scene.step_neighbours)
    join_neighbours(report, scene, made, out.file(scene.step));
  for (const auto& w : step.warnings) report.warnings.push_back(scene.step + ": " + w);
}

void write_vtk_files(Report& report, const Scene& scene, const BuiltModel& made,
                     const SolvedShape& shape, const OutputFolder& out) {
  VtkOptions vtk;
  if (made.network) vtk.lines = vtk_lines(*made.network, made.model);
  // Displacements are relative to the shape of the lines alone.
  std::vector<Surface> unloaded;
  if (report.is_sculpted || report.sculpting)
    for (int r = 0; r < shape.layout->region_count(); ++r)
      unloaded.push_back(shape.layout->skinned(r, shape.unloaded).surface);
  for (const Surface& surface : unloaded) vtk.references.push_back(&surface);
  const Regions regions = shape.all();
  const auto write_vtk = [&](const std::string& file, const auto& write) {
    if (file.empty()) return;
    write_valid_regions(report, out, file, regions, made.network.has_value(),
                        [&](const std::vector<int>& which, Report&) {
                          VtkOptions of_some = vtk;
                          if (!vtk.references.empty())
                            of_some.references = picked(vtk.references, which);
                          write(out.file(file), picked(regions, which), of_some);
                        });
  };
  write_vtk(scene.vtp, write_vtp);
  write_vtk(scene.vtu, write_vtu);
}

/// Writes the triangles of all faces, joined to the given meshes.
void write_mesh_file(Report& report, const Scene& scene, const BuiltModel& made,
                     const Regions& regions, const OutputFolder& out) {
  std::vector<MeshNeighbour> given;
  double spacing = std::numeric_limits<double>::infinity();
  Report::Mesh& mesh = report.mesh.emplace();
  mesh.file = scene.mesh;
  for (const SceneNeighbour& neighbour : scene.neighbours) {
    if (!MeshFile::can_read(neighbour.file)) continue;
    given.push_back(read_mesh_neighbour(neighbour.file, neighbour.faces, neighbour.without));
    mesh.given_faces += given.back().shells.face_count();
    for (const MeshBoundary& boundary : given.back().boundaries)
      spacing = std::min(spacing, boundary.length / isize(boundary.vertices));
  }
  std::vector<std::string> names;
  for (const SkinnedRegion* region : regions) names.push_back(region->name);
  // Facets beside given meshes are about as large as those of the meshes.
  int per_edge = 0;
  if (!given.empty())
    per_edge = std::clamp(static_cast<int>(std::lround(mean_facet_length(regions) / spacing)), 1,
                          display_facets_per_edge(regions));
  const JoinedMesh joined =
      join_meshes(given, welded_mesh(regions, per_edge), names, made.fit_tolerance);
  mesh.faces = joined.mesh.face_count();
  mesh.joined_loops = joined.joined_loops;
  mesh.free_edges = joined.free_edges;
  if (joined.non_manifold_edges > 0)
    report.failed_checks.push_back(
        {"mesh.non_manifold_edges",
         "is " + std::to_string(joined.non_manifold_edges) + ", expected 0"});
  const bool only_openings = !given.empty() && !has_cad_neighbours(scene) && !has_outlines(scene);
  if (only_openings && joined.joined_loops == joined.new_loops &&
      joined.free_edges != joined.open_edges)
    report.failed_checks.push_back({"mesh.free_edges", "is " + std::to_string(joined.free_edges) +
                                                           ", expected " +
                                                           std::to_string(joined.open_edges)});
  if (only_openings && joined.joined_loops < joined.new_loops)
    report.failed_checks.push_back(
        {"mesh.joined_openings", "is " + std::to_string(joined.joined_loops) + ", expected " +
                                     std::to_string(joined.new_loops)});
  for (const auto& file :
       write_mesh(out.file(scene.mesh), joined.mesh, joined.sets, unit_in_metres(scene.unit)))
    if (file.filename() != scene.mesh) report.files.push_back(file.filename().string());
}

/// Writes the text of the scene. A file that the user may have changed is kept.
void write_scene_text(Report& report, const Scene& scene, const OutputFolder& out) {
  if (scene.text.empty()) return;
  const std::string name = scene.name + ".toml";
  const std::filesystem::path existing = out.folder() / name;
  std::error_code none;
  if (std::filesystem::exists(existing, none)) {
    if (read_input_file(existing, "a scene") == scene.text)
      report.files.push_back(name);
    else
      report.warnings.push_back(existing.string() +
                                " is kept, although it differs from the scene of this run; remove "
                                "or rename it to get the new one");
    return;
  }
  write_file_atomically(out.file(name), [&](std::ostream& file) { file << scene.text; });
  report.files.push_back(name);
}

}  // namespace

void write_files(RunContext& run, const Scene& scene, const BuiltModel& made,
                 const SolvedShape& shape, const Progress& progress) {
  if (shape.regions.empty()) return;
  Report& report = run.report;
  if (!scene.compare.empty()) {
    compare_into(report, scene, shape.all(), progress);
    run.watch.lap("compare");
  }
  progress.update("files", 0);
  write_scene_text(report, scene, run.out);
  if (!scene.vtp.empty() || !scene.vtu.empty()) {
    progress.update("VTK", 0);
    write_vtk_files(report, scene, made, shape, run.out);
    run.watch.lap("vtk");
  }
  if (!scene.mesh.empty()) {
    const Regions regions = shape.all();
    write_valid_regions(report, run.out, scene.mesh, regions, made.network.has_value(),
                        [&](const std::vector<int>& which, Report& into) {
                          write_mesh_file(into, scene, made, picked(regions, which), run.out);
                        });
    run.watch.lap("mesh");
  }
  if (!scene.calculix.empty()) {
    // Supports or loads on missing entities are errors of the scene.
    const std::vector<std::string> cases = scene.stress->cases();
    if (cases.size() > 1)
      throw InputError(scene.at({}) + "[stress]: found " + std::to_string(cases.size()) +
                       " load cases, which '" + scene.calculix +
                       "' cannot contain, expected one case; use `batten stress`");
    ShellDeck deck;
    try {
      deck = deck_of(scene, *made.model.layout, cases.empty() ? "" : cases[0], scene.calculix);
    } catch (const DeckLimitError& e) {
      throw InputError(std::string(e.what()) + "; use `batten stress`");
    }
    const Regions regions = shape.all();
    write_valid_regions(report, run.out, scene.calculix, regions, made.network.has_value(),
                        [&](const std::vector<int>& which, Report&) {
                          write_calculix(run.out.file(scene.calculix), picked(regions, which),
                                         deck);
                        });
    run.watch.lap("calculix");
  }
}

void write_step_file(RunContext& run, const Scene& scene, const BuiltModel& made,
                     const Progress& progress) {
  if (scene.step.empty() || made.model.skinned().empty()) return;
  progress.update("STEP", 0);
  const Regions regions = with_faces(run.report, made.model);
  if (regions.empty()) {
    run.report.failed_checks.push_back(
        {scene.step, "is not written: the surface of every face is inverted"});
    return;
  }
  write_valid_regions(run.report, run.out, scene.step, regions, made.network.has_value(),
                      [&](const std::vector<int>& which, Report& into) {
                        write_step_into(into, scene, made, picked(regions, which), run.out);
                      });
  run.watch.lap("step");
}

PictureScene shape_picture(const PictureScene& look, const BuiltModel& made,
                           const SolvedShape& shape) {
  PictureScene picture = look;
  picture.regions = shape.all();
  if (made.found)
    for (const int a : made.found->unused_edges)
      picture.extra_curves.push_back(made.network->edges()[a].curve);
  return picture;
}

void draw_pictures(RunContext& run, const Scene& scene, const BuiltModel& made,
                   const SolvedShape& shape, const Progress& progress) {
  Report& report = run.report;
  for (const auto& picture : scene.pictures) {
    if (!can_draw(report, picture.file)) continue;
    progress.update("picture " + picture.file, 0);
    const Regions regions = shape.all();
    write_valid_regions(report, run.out, picture.file, regions, made.network.has_value(),
                        [&](const std::vector<int>& which, Report&) {
                          PictureScene look = shape_picture(picture.look, made, shape);
                          look.regions = picked(regions, which);
                          draw_picture(run.out.file(picture.file), look, picture.size);
                        });
  }
}

namespace {

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  AtomicFile file(to);
  std::filesystem::copy_file(from, file.temporary(),
                             std::filesystem::copy_options::overwrite_existing);
  file.commit();
}

/// Reduces the scene to a single output; the result is its file name.
std::string require_single_output(Scene& scene, const std::string& ending) {
  scene.step = scene.vtp = scene.vtu = scene.mesh = scene.calculix = "";
  scene.compare.clear();
  if (ending.empty()) return "";
  std::string& output = ending == ".vtp"   ? scene.vtp
                        : ending == ".vtu" ? scene.vtu
                        : ending == ".inp" ? scene.calculix
                                           : scene.step;
  output = &output == &scene.step ? "shape.step" : "shape" + ending;
  return output;
}

}  // namespace

Report export_shape(const Scene& of, const BuiltModel& made_before, const SolvedShape& shape,
                    const std::filesystem::path& file, const Progress& progress) {
  const TemporaryFolder folder(std::filesystem::temp_directory_path(), "batten-export");
  const std::string ending = lower_extension(file);
  Scene scene = of;
  const std::string output = require_single_output(scene, ending);
  if (!scene.calculix.empty() && !scene.stress)
    throw InputError(
        file.string() +
        ": found no [stress] in the scene, expected one with the thickness and material");
  RunContext run(scene, folder.path());
  run.report.parameters = scene.parameters();
  BuiltModel made = made_before;
  run.tolerance = made.fit_tolerance;
  measure_into(run, made, shape, scene, progress);
  write_files(run, scene, made, shape, progress);
  write_step_file(run, scene, made, progress);
  run.finish(progress);
  run.out.commit();
  if (output.empty()) return std::move(run.report);
  const std::filesystem::path written = folder.path() / output;
  if (ending == lower_extension(written) || ending == ".stp") {
    copy_whole(written, file);
    return std::move(run.report);
  }
  ConvertTask task;
  task.from = written;
  task.to = file;
  const ConvertReport converted = run_convert(task, progress);
  run.report.failed_checks.insert(run.report.failed_checks.end(), converted.failed_checks.begin(),
                                  converted.failed_checks.end());
  return std::move(run.report);
}

}  // namespace batten
