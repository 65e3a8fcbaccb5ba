#include "batten/apps/commands/shapes/shape_files.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/apps/commands/runs/promises.h"
#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/io/cad/step.h"
#include "batten/io/cad/step_face.h"
#include "batten/io/decks/calculix.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {

ShapeRun::ShapeRun(const Scene& scene, const std::filesystem::path& folder)
    : out(folder), watch(report.timings) {
  report.name = scene.name;
  report.unit = scene.unit;
  report.is_sculpted = scene.is_sculpted();
  report.surface.hold = scene.skin.hold == SceneSkin::Hold::Corners ? "corners" : "lines";
  report.surface.fair = scene.skin.fair_word();
}

void ShapeRun::finish(const Progress& progress) {
  watch.total();
  write_report(report, broken_promises(report, tolerance), out, progress);
}

MadeModel model_of(ShapeRun& run, const Scene& scene, const Progress& progress) {
  progress.at("lines", 0);
  const FairedLines lines = faired_lines(scene, progress);
  run.report.curves = lines.reports;
  run.report.surprises = lines.surprises;
  run.watch.lap("lines");
  MadeModel made = make_model(scene, lines.lines, progress);
  run.tolerance = made.fit_tolerance;
  run.watch.lap("model");
  return made;
}

namespace {

// The root mean square is taken over the area of the surfaces.
void compare_into(Report& report, const Scene& scene,
                  const std::vector<const SkinnedRegion*>& regions, const Progress& progress) {
  const auto faces = read_cad_surfaces(scene.compare, unit_in_metres(scene.unit));
  if (faces.empty())
    throw InputError(scene.compare.string() + ": found no faces, expected some to compare with");
  const TriangleRule whole = split_triangle(2);
  Report::Comparison c;
  c.file = scene.compare.filename().string();
  double squares = 0, area = 0;
  Box3 box(regions.front()->surface.position({0, Vec3::Unit(0)}));
  for (size_t r = 0; r < regions.size(); ++r) {
    const Surface& surface = regions[r]->surface;
    const Trim* trim = surface.trim().get();
    const ParametricMesh& mesh = surface.mesh();
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      progress.at("comparing",
                  (static_cast<double>(r) + static_cast<double>(t) / mesh.triangle_count()) /
                      static_cast<double>(regions.size()));
      if (trim && trim->side(t) == Trim::Side::Outside) continue;
      const TriangleRule rule = trim && trim->side(t) == Trim::Side::Cut ? trim->rule(t, 2) : whole;
      for (long p = 0; p < rule.weights.size(); ++p) {
        if (!(rule.weights[p] > 0)) continue;
        const SurfaceJet jet = surface.jet({t, rule.L.row(p).transpose()});
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& face : faces) nearest = std::min(nearest, face.distance(jet.x));
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

// No face can be fitted to a surface that turns over.
std::vector<const SkinnedRegion*> with_faces(Report& report, const SurfaceModel& model) {
  std::set<int> over;
  for (const SurfaceFlaw& flaw : model.flaws)
    if (flaw.kind == SurfaceFlaw::Kind::Jacobian) over.insert(flaw.regions[0]);
  std::vector<const SkinnedRegion*> regions;
  for (int r = 0; r < count_of(model.regions); ++r) {
    const ModelRegion& region = model.regions[r];
    if (region.skinned && !over.count(r)) regions.push_back(&*region.skinned);
    if (region.skinned && over.count(r))
      report.warnings.push_back("region '" + region.plan.name +
                                "' is left out of the STEP file: its surface turns over");
  }
  return regions;
}

StepReport exact_step(Report& report, const Scene& scene,
                      const std::vector<const SkinnedRegion*>& regions,
                      const std::filesystem::path& file) {
  const std::string warning = step_size_warning(regions);
  if (!warning.empty())
    report.warnings.push_back(warning + "; step_form = \"face\" makes one face of each region");
  StepOptions options;
  options.name = scene.name;
  options.z12_as_hct = true;
  const StepReport step = write_step(file, regions, unit_in_metres(scene.unit), options);
  if (step.unmeasured > 0)
    report.missed.push_back(
        {"step", "has " + std::to_string(step.unmeasured) + " places that could not be measured"});
  if (regions.front()->surface.kind() == TriangleElement::Z12)
    report.warnings.push_back(scene.step +
                              ": Z12 is rational and no STEP surface; written by HCT triangles "
                              "that share its edges, largest distance " +
                              number(step.max_deviation.value_or(std::nan(""))) + " " + scene.unit);
  return step;
}

StepReport face_step(Report& report, const Scene& scene,
                     const std::vector<const SkinnedRegion*>& regions,
                     const std::filesystem::path& file) {
  StepFaceOptions options;
  options.name = scene.name;
  constexpr double usual = 1e-4;
  options.tolerance = scene.step_tolerance > 0 ? scene.step_tolerance : usual * report.surface.size;
  const StepReport step = write_step_faces(file, regions, unit_in_metres(scene.unit), options);
  report.step->tolerance = options.tolerance;
  for (const StepPatch& patch : step.patches) {
    report.step->poles_u = std::max(report.step->poles_u, patch.poles_u);
    report.step->poles_v = std::max(report.step->poles_v, patch.poles_v);
  }
  return step;
}

void write_step_into(Report& report, const Scene& scene, const MadeModel& made,
                     const OutputFolder& out) {
  using Form = Scene::StepForm;
  const auto regions = with_faces(report, made.model);
  if (regions.empty()) throw InputError("no region has a surface that does not turn over");
  const bool cut = std::any_of(regions.begin(), regions.end(),
                               [](const SkinnedRegion* r) { return r->surface.trim(); });
  if (scene.step_form == Form::Exact && cut && !made.network)
    throw InputError(scene.at({}) +
                     "found step_form = \"exact\" for a surface that embedded lines cut, expected "
                     "\"face\": cut triangles have no exact form");
  Report::Step& s = report.step.emplace();
  s.form = scene.step_form == Form::Exact ? "exact" : "face";
  s.file = scene.step;
  StepReport step;
  try {
    step =
        (s.form == "face" ? face_step : exact_step)(report, scene, regions, out.file(scene.step));
    constexpr int few_triangles = 10'000;
    if (scene.step_form == Form::Auto && !cut && !made.network && !step.reached &&
        regions.front()->surface.mesh().triangle_count() <= few_triangles) {
      report.warnings.push_back("one face in '" + scene.step + "' would be " +
                                number(step.max_deviation.value_or(std::nan(""))) + " " +
                                scene.unit + " off the surface: it has three a triangle");
      s.form = "exact";
      s.tolerance = s.poles_u = s.poles_v = 0;
      step = exact_step(report, scene, regions, out.file(scene.step));
    }
  } catch (...) {
    report.step.reset();
    throw;
  }
  s.faces = step.faces;
  s.bytes = step.bytes;
  s.max_deviation = step.max_deviation.value_or(std::nan(""));
  s.max_gap = step.max_gap;
  s.max_normal_jump_deg = s.form == "face" ? 0 : step.max_normal_jump_deg;
  s.valid = step.valid;
  s.shells = step.shells;
  s.solids = step.solids;
  s.free_edges = step.free_edges;
  s.volume = step.volume;
  for (const auto& w : step.warnings) report.warnings.push_back(scene.step + ": " + w);
  report.files.push_back(scene.step);
}

ShellDeck deck_of(const Scene& scene, const MadeModel& made) {
  const SceneStress& stress = *scene.stress;
  ShellDeck deck;
  deck.thickness = stress.thickness;
  deck.young = stress.young;
  deck.poisson = stress.poisson;
  deck.density = stress.density;
  deck.pressure = stress.pressure;
  deck.gravity = stress.gravity;
  deck.units = "lengths in " + scene.unit;
  std::vector<std::string> names;
  for (const ModelLine& line : made.model.layout->lines()) names.push_back(line.name);
  for (const auto& support : stress.supports) {
    const size_t before = deck.supports.size();
    for (const auto& name : names)
      if (is_part_of(name, support.line.text))
        deck.supports.push_back({name, support.clamped ? ShellDeck::Support::Kind::Clamped
                                                       : ShellDeck::Support::Kind::Pinned});
    if (deck.supports.size() == before)
      throw InputError(scene.at(support.line.place) + "found a support on the line '" +
                       support.line.text + "', expected " + one_of(support.line.text, names));
  }
  const std::vector<std::string> regions = made.region_names();
  for (const auto& pressure : stress.pressures) {
    if (std::find(regions.begin(), regions.end(), pressure.region.text) == regions.end())
      throw InputError(scene.at(pressure.region.place) + "found a pressure on the region '" +
                       pressure.region.text + "', expected " +
                       one_of(pressure.region.text, regions));
    deck.pressures.push_back({pressure.region.text, pressure.pressure});
  }
  return deck;
}

void write_vtk_files(Report& report, const Scene& scene, const MadeModel& made,
                     const MadeShape& shape, const OutputFolder& out, const auto& unless_refused) {
  VtkOptions vtk;
  if (made.network) vtk.lines = vtk_lines(*made.network, made.model);
  // Displacements are from what the lines alone make.
  std::vector<Surface> unloaded;
  if (report.is_sculpted || report.sculpting)
    for (int r = 0; r < shape.layout->region_count(); ++r)
      unloaded.push_back(shape.layout->skinned(r, shape.unloaded).surface);
  for (const Surface& surface : unloaded) vtk.references.push_back(&surface);
  const auto write_vtk = [&](const std::string& file, const auto& write) {
    if (file.empty()) return;
    unless_refused(file, [&] {
      write(out.file(file), shape.all(), vtk);
      report.files.push_back(file);
    });
  };
  write_vtk(scene.vtp, write_vtp);
  write_vtk(scene.vtu, write_vtu);
}

}  // namespace

void write_files(ShapeRun& run, const Scene& scene, const MadeModel& made, const MadeShape& shape,
                 const Progress& progress) {
  if (shape.regions.empty()) return;
  Report& report = run.report;
  if (!scene.compare.empty()) {
    compare_into(report, scene, shape.all(), progress);
    run.watch.lap("compare");
  }
  // One region that a file cannot have does not take the others' files away.
  const auto unless_refused = [&](const std::string& file, const auto& write) {
    try {
      write();
    } catch (const InputError& e) {
      if (!made.network) throw;
      report.missed.push_back({file, std::string("is not written: ") + e.what()});
    }
  };
  progress.at("files", 0);
  if (!scene.step.empty()) {
    progress.at("STEP", 0);
    unless_refused(scene.step, [&] { write_step_into(report, scene, made, run.out); });
    run.watch.lap("step");
  }
  if (!scene.vtp.empty() || !scene.vtu.empty()) {
    progress.at("VTK", 0);
    write_vtk_files(report, scene, made, shape, run.out, unless_refused);
    run.watch.lap("vtk");
  }
  if (!scene.calculix.empty()) {
    // A support or pressure on what is not there is the scene's mistake.
    const ShellDeck deck = deck_of(scene, made);
    unless_refused(scene.calculix, [&] {
      write_calculix(run.out.file(scene.calculix), shape.all(), deck);
      report.files.push_back(scene.calculix);
    });
    run.watch.lap("calculix");
  }
}

PictureScene picture_of(const PictureScene& look, const MadeModel& made, const MadeShape& shape) {
  PictureScene picture = look;
  picture.regions = shape.all();
  if (made.found)
    for (const int a : made.found->bare) picture.loose.push_back(made.network->arcs()[a].curve);
  return picture;
}

void draw_pictures(ShapeRun& run, const Scene& scene, const MadeModel& made, const MadeShape& shape,
                   const Progress& progress) {
  Report& report = run.report;
  for (const auto& picture : scene.pictures) {
    if (!can_draw(report, picture.file)) continue;
    progress.at("picture " + picture.file, 0);
    try {
      draw_picture(run.out.file(picture.file), picture_of(picture.look, made, shape), picture.size);
      report.files.push_back(picture.file);
    } catch (const InputError& e) {
      if (!made.network) throw;
      report.missed.push_back({picture.file, std::string("is not drawn: ") + e.what()});
    }
  }
}

}  // namespace batten
