#include "batten/apps/commands/run_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/apps/commands/fair_lines.h"
#include "batten/apps/commands/make_shape.h"
#include "batten/apps/commands/output_folder.h"
#include "batten/apps/commands/promises.h"
#include "batten/apps/commands/run_parts.h"
#include "batten/io/cad_lines.h"
#include "batten/io/calculix.h"
#include "batten/io/step.h"
#include "batten/io/step_face.h"
#include "batten/io/vtk_files.h"
#include "batten/io/whole_file.h"
#include "batten/skinning/line_fit.h"

namespace batten {
namespace {

/// Largest distance from samples of the user's line to the fitted curve.
double deviation(const CharacterLine& line, const HermiteCurve& fitted) {
  const auto breaks = line.curve->breaks();
  const int samples = std::clamp<int>(2000 / static_cast<int>(breaks.size()), 4, 64);
  double largest = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k <= samples; ++k) {
      const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * k / samples;
      const double d = fitted.closest_point(line.curve->evaluate(t)).distance;
      if (!(d <= largest) && !std::isnan(largest)) largest = d;
    }
  return largest;
}

/// Limits from analytic shapes and hulls (docs/theory/domains.md): good domains are far inside.
void warn_of_strain(Report& report) {
  const SkinQuality& q = report.surface.quality;
  constexpr double most_shear = 5, most_strain = 0.7, least_jacobian = 0.1;
  if (q.max_shear <= most_shear && q.rms_strain <= most_strain &&
      q.min_jacobian_ratio >= least_jacobian)
    return;
  report.warnings.push_back(
      "the flat domain is strained (shear " + number(q.max_shear) + ", strain " +
      number(q.rms_strain) + ", Jacobian " + number(q.min_jacobian_ratio) +
      " of its median): the surface may be uneven there; another domain, settle = true, or inner "
      "lines with treatment = \"embedded\" may suit it better");
}

void measure_into(Report& report, const MadeShape& made) {
  for (const LineRun& run : made.region.runs)
    report.lines.push_back({run.line.name, run.line.role, false, ArcLength(run.line.curve).total(),
                            deviation(run.line, run.fitted), run.fitted.node_count()});
  for (const EmbeddedLine& e : made.region.embedded)
    report.lines.push_back({e.line.name, e.line.role, true, ArcLength(e.line.curve).total(),
                            deviation(e.line, e.fitted), e.fitted.node_count(),
                            static_cast<int>(e.points.size()), line_gap(made.region.surface, e)});
  auto& s = report.surface;
  s.triangles = made.region.surface.mesh().triangle_count();
  s.dofs = made.region.surface.dof_map().count();
  s.element = made.region.surface.kind() == TriangleElement::HCT ? "hct" : "z12";
  s.size = made.region.size;
  s.quality = measure(made.region);
  warn_of_strain(report);
  s.bending_energy = made.sculpt.energy.bending;
  s.max_constraint_residual = made.sculpt.max_constraint_residual;
  s.max_normal_constraint_deg = made.max_normal_constraint_deg;
  s.load_steps = made.sculpt.load_steps;
  s.iterations = made.sculpt.iterations;
  s.last_change = made.sculpt.last_change;
  report.springs = made.sculpt.springs;
  for (const auto& r : made.sculpt.reactions) report.reactions.push_back({r.name, r.force});
}

/// The root mean square is taken over the area of the surface.
void compare_into(Report& report, const Scene& scene, const SkinnedRegion& region,
                  const Progress& progress) {
  const auto faces = read_cad_surfaces(scene.compare, unit_in_metres(scene.unit));
  if (faces.empty())
    throw InputError(scene.compare.string() + ": found no faces, expected some to compare with");
  const TriangleRule whole = split_triangle(2);
  const Trim* trim = region.surface.trim().get();
  const ParametricMesh& mesh = region.surface.mesh();
  Report::Comparison c;
  c.file = scene.compare.filename().string();
  double squares = 0, area = 0;
  Vec3 low = region.surface.position({0, Vec3::Unit(0)}), high = low;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    progress.at("comparing", static_cast<double>(t) / mesh.triangle_count());
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const TriangleRule rule = trim && trim->side(t) == Trim::Side::Cut ? trim->rule(t, 2) : whole;
    for (long p = 0; p < rule.weights.size(); ++p) {
      if (!(rule.weights[p] > 0)) continue;
      const SurfaceJet jet = region.surface.jet({t, rule.L.row(p).transpose()});
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& face : faces) nearest = std::min(nearest, face.distance(jet.x));
      const double weight = rule.weights[p] * mesh.shape(t).area * jet.area_vector().norm();
      squares += weight * nearest * nearest;
      area += weight;
      c.max = std::max(c.max, nearest);
      low = low.cwiseMin(jet.x);
      high = high.cwiseMax(jet.x);
      ++c.points;
    }
  }
  c.rms = std::sqrt(squares / area);
  const double length = (high - low).maxCoeff();
  c.max_relative = c.max / length;
  c.rms_relative = c.rms / length;
  report.comparison = c;
}

void write_exact_step(Report& report, const Scene& scene, const SkinnedRegion& region,
                      const OutputFolder& out) {
  const std::vector<const Surface*> surfaces = {&region.surface};
  const std::string warning = step_size_warning(surfaces);
  if (!warning.empty())
    report.warnings.push_back(warning + "; step_form = \"face\" makes one face of it");
  StepOptions options;
  options.name = scene.name;
  options.z12_as_hct = true;
  const StepReport step =
      write_step(out.file(scene.step), surfaces, unit_in_metres(scene.unit), options);
  report.step = Report::Step{};
  report.step->form = "exact";
  report.step->faces = step.faces;
  report.step->bytes = step.bytes;
  report.step->max_deviation = step.max_deviation.value_or(std::nan(""));
  report.step->max_gap = step.max_gap;
  report.step->max_normal_jump_deg = step.max_normal_jump_deg;
  report.step->valid = step.valid;
  if (step.unmeasured > 0)
    report.missed.push_back(
        {"step", "has " + std::to_string(step.unmeasured) + " places that could not be measured"});
  for (const auto& w : step.warnings) report.warnings.push_back(scene.step + ": " + w);
  if (region.surface.kind() == TriangleElement::Z12)
    report.warnings.push_back(
        scene.step + ": Z12 is rational and no STEP surface; written by HCT triangles that share " +
        "its edges, largest distance " + number(report.step->max_deviation) + " " + scene.unit);
}

void write_face_step(Report& report, const Scene& scene, const SkinnedRegion& region,
                     const OutputFolder& out) {
  StepFaceOptions options;
  options.name = scene.name;
  constexpr double usual = 1e-4;
  options.tolerance = scene.step_tolerance > 0 ? scene.step_tolerance : usual * region.size;
  const StepFaceReport step =
      write_step_face(out.file(scene.step), {&region}, unit_in_metres(scene.unit), options);
  report.step = Report::Step{};
  report.step->form = "face";
  report.step->faces = step.faces;
  report.step->bytes = step.bytes;
  report.step->tolerance = options.tolerance;
  report.step->poles_u = step.patches[0].poles_u;
  report.step->poles_v = step.patches[0].poles_v;
  report.step->max_deviation = step.deviation;
  report.step->max_gap = step.edge_gap;
  report.step->valid = step.valid;
  for (const auto& w : step.warnings) report.warnings.push_back(scene.step + ": " + w);
}

void write_step_into(Report& report, const Scene& scene, const SkinnedRegion& region,
                     const OutputFolder& out) {
  using Form = Scene::StepForm;
  if (scene.step_form == Form::Exact && region.surface.trim())
    throw InputError(scene.at({}) +
                     "found step_form = \"exact\" for a surface that embedded lines cut, expected "
                     "\"face\": cut triangles have no exact form");
  constexpr int few_triangles = 10'000;
  const bool face =
      scene.step_form == Form::Face ||
      (scene.step_form == Form::Auto &&
       (region.surface.trim() || region.surface.mesh().triangle_count() > few_triangles));
  (face ? write_face_step : write_exact_step)(report, scene, region, out);
  report.step->file = scene.step;
  report.files.push_back(scene.step);
}

/// A line that was cut at its corners is there as "name.1", "name.2", …
bool is_part_of(const std::string& run, const std::string& line) {
  return run == line || (run.starts_with(line + ".") &&
                         run.find_first_not_of("0123456789", line.size() + 1) == std::string::npos);
}

ShellDeck deck_of(const Scene& scene, const SkinnedRegion& region) {
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
  for (const auto& run : region.runs) names.push_back(run.line.name);
  for (const auto& embedded : region.embedded) names.push_back(embedded.line.name);
  for (const auto& support : stress.supports) {
    const size_t before = deck.supports.size();
    for (const auto& name : names)
      if (is_part_of(name, support.line.text))
        deck.supports.push_back({name, support.clamped ? ShellDeck::Support::Kind::Clamped
                                                       : ShellDeck::Support::Kind::Pinned});
    if (deck.supports.size() == before)
      throw InputError(scene.at(support.line.place) + "found a support on the line '" +
                       support.line.text + "', expected one of: " + listed(names) +
                       did_you_mean(support.line.text, names));
  }
  return deck;
}

PictureScene picture_of(const PictureScene& look, const SkinnedRegion& region) {
  PictureScene picture = look;
  picture.regions = {&region};
  return picture;
}

void draw_sweep(const RegionLayout& layout, const Scene& scene, const SceneSweep& sweep,
                const std::filesystem::path& file, const Progress& progress) {
  std::vector<MadeShape> shapes;
  for (size_t i = 0; i < sweep.values.size(); ++i) {
    progress.at("sweep of " + sweep.parameter,
                static_cast<double>(i) / static_cast<double>(sweep.values.size()));
    Scene panel = scene;
    panel.set(sweep.parameter, sweep.values[i], "");
    try {
      shapes.push_back(make_shape(layout, panel, {{}, progress.cancelled}));
    } catch (const NoSolutionError& e) {
      throw NoSolutionError("sweep at " + sweep.parameter + " = " + number(sweep.values[i]) + ": " +
                            e.what());
    }
  }
  const int count = static_cast<int>(shapes.size());
  const int columns = sweep.columns > 0
                          ? std::min(sweep.columns, count)
                          : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<PictureScene> panels;
  for (int i = 0; i < count; ++i) {
    PictureScene panel = picture_of(sweep.picture.look, shapes[i].region);
    panel.title +=
        (panel.title.empty() ? "" : ", ") + sweep.parameter + " = " + number(sweep.values[i]);
    panels.push_back(panel);
  }
  draw_contact_sheet(file, panels, columns, sweep.picture.size);
}

/// Pictures need a display; a result without them is still a result, but not what was asked for.
void draw_all(Report& report, const RegionLayout& layout, const Scene& scene, const MadeShape& made,
              const OutputFolder& out, const Progress& progress) {
  if (scene.pictures.empty() && scene.sweeps.empty()) return;
  try {
    require_display();
  } catch (const InputError& e) {
    for (const auto& picture : scene.pictures)
      report.missed.push_back({picture.file, std::string("is not drawn: ") + e.what()});
    for (const auto& sweep : scene.sweeps)
      report.missed.push_back({sweep.picture.file, std::string("is not drawn: ") + e.what()});
    return;
  }
  for (const auto& picture : scene.pictures) {
    progress.at("picture " + picture.file, 0);
    draw_picture(out.file(picture.file), picture_of(picture.look, made.region), picture.size);
    report.files.push_back(picture.file);
  }
  for (const auto& sweep : scene.sweeps) {
    draw_sweep(layout, scene, sweep, out.file(sweep.picture.file), progress);
    report.files.push_back(sweep.picture.file);
  }
}

}  // namespace

void apply_settings(Scene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parsed_settings(settings)) scene.set(s.name, s.value, s.where);
}

Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit) {
  Scene scene;
  scene.unit = unit;
  scene.name = outline.front().stem().string();
  for (const auto* files : {&outline, &inner})
    for (const auto& file : *files) {
      SceneLine line;
      line.file = file;
      line.role = files == &inner ? CharacterLine::Role::Inner : CharacterLine::Role::Outline;
      scene.lines.push_back(line);
    }
  scene.step = scene.name + ".step";
  scene.vtp = scene.name + ".vtp";
  return scene;
}

Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress) {
  OutputFolder out(folder);
  Report report;
  report.name = scene.name;
  report.unit = scene.unit;
  report.parameters = scene.parameters();
  report.surface.hold = scene.skin.hold == SceneSkin::Hold::Corners ? "corners" : "lines";
  Stopwatch watch(report.timings);

  progress.at("lines", 0);
  const FairedLines lines = faired_lines(scene, progress);
  report.curves = lines.reports;
  watch.lap("lines");
  RegionLayout layout = lay_out(scene, lines.lines, progress);
  watch.lap("layout");
  const MadeShape made = make_refined_shape(layout, scene, progress);
  report.warnings = layout.warnings();
  watch.lap("sculpt");
  progress.at("measuring", 0);
  measure_into(report, made);
  watch.lap("measure");

  if (!scene.compare.empty()) {
    compare_into(report, scene, made.region, progress);
    watch.lap("compare");
  }

  progress.at("files", 0);
  VtkOptions vtk;
  if (!scene.loads.empty() || !scene.constraints.empty()) vtk.references = {&made.unloaded};
  if (!scene.step.empty()) {
    progress.at("STEP", 0);
    write_step_into(report, scene, made.region, out);
    watch.lap("step");
  }
  if (!scene.vtp.empty() || !scene.vtu.empty()) {
    progress.at("VTK", 0);
    if (!scene.vtp.empty()) write_vtp(out.file(scene.vtp), {&made.region}, vtk);
    if (!scene.vtu.empty()) write_vtu(out.file(scene.vtu), {&made.region}, vtk);
    for (const auto& file : {scene.vtp, scene.vtu})
      if (!file.empty()) report.files.push_back(file);
    watch.lap("vtk");
  }
  if (!scene.calculix.empty()) {
    write_calculix(out.file(scene.calculix), made.region, deck_of(scene, made.region));
    report.files.push_back(scene.calculix);
    watch.lap("calculix");
  }
  if (!scene.pictures.empty() || !scene.sweeps.empty()) {
    draw_all(report, layout, scene, made, out, progress);
    watch.lap("pictures");
  }
  watch.total();

  const auto broken = broken_promises(report, layout.tolerance());
  report.missed.insert(report.missed.end(), broken.begin(), broken.end());
  report.files.push_back("report.json");
  write_whole_file(out.file("report.json"), [&](std::ostream& file) { file << to_json(report); });
  progress.at("files", 1);
  out.commit();
  return report;
}

void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress) {
  require_display();
  RegionLayout layout = lay_out(scene, faired_lines(scene, progress).lines, progress);
  const MadeShape made = make_refined_shape(layout, scene, progress);
  draw_picture(file, picture_of(look, made.region));
}

std::string summary(const Report& report, const std::filesystem::path& folder) {
  const auto& s = report.surface;
  const auto& q = s.quality;
  const std::string unit = " " + report.unit;
  double deviation = 0;
  for (const auto& line : report.lines) deviation = std::max(deviation, line.deviation);

  std::string text = report.name + "\n";
  text += result_line(
      "lines", std::to_string(report.lines.size()) + ", fitted within " + number(deviation) + unit);
  text +=
      result_line("surface", std::to_string(s.triangles) + " triangles, " + std::to_string(s.dofs) +
                                 " unknowns a coordinate, area " + number(q.area) + unit + "²");
  text += s.hold == "lines"
              ? result_line("held lines",
                            "residual " + number(q.max_line_residual) +
                                (q.max_line_gap > 0
                                     ? ", gap of embedded ones " + number(q.max_line_gap) + unit
                                     : "") +
                                ", surface to your lines " + number(q.max_line_deviation) + unit)
              : result_line("held", "corners only, residual " + number(s.max_constraint_residual));
  text += result_line("quality", "Jacobian " + number(q.min_jacobian_ratio) +
                                     " of its median, normal jump " +
                                     number(q.max_normal_jump_deg) + " degrees");
  if (report.step) {
    const auto& step = *report.step;
    const std::string valid = step.valid ? "valid" : "NOT valid";
    text += result_line("STEP", step.form == "exact"
                                    ? std::to_string(step.faces) + " faces, " + valid + ", gap " +
                                          number(step.max_gap) + unit
                                    : "one face of " + std::to_string(step.poles_u) + " × " +
                                          std::to_string(step.poles_v) + " poles, " + valid +
                                          ", within " + number(step.max_deviation) + unit +
                                          ", edges within " + number(step.max_gap) + unit);
  }
  for (const auto& springs : report.springs)
    text += result_line("springs", std::to_string(springs.points - springs.left_out) + " of " +
                                       std::to_string(springs.points) + " points of '" +
                                       springs.name + "', rms " + number(springs.before_rms) +
                                       " -> " + number(springs.rms) + unit);
  if (report.comparison)
    text += result_line("compared", "max " + number(report.comparison->max) + unit + ", rms " +
                                        number(report.comparison->rms) + unit + " from " +
                                        report.comparison->file);
  return text + result_ending(report, folder);
}

}  // namespace batten
