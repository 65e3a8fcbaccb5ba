#include "batten/apps/commands/shape_files.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/io/cad_lines.h"
#include "batten/io/calculix.h"
#include "batten/io/step.h"
#include "batten/io/step_face.h"
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

}  // namespace

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
  Vec3 low = regions.front()->surface.position({0, Vec3::Unit(0)}), high = low;
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
        low = low.cwiseMin(jet.x);
        high = high.cwiseMax(jet.x);
        ++c.points;
      }
    }
  }
  c.rms = std::sqrt(squares / area);
  const double length = (high - low).maxCoeff();
  c.max_relative = c.max / length;
  c.rms_relative = c.rms / length;
  report.comparison = c;
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

void write_files(Report& report, const Scene& scene, const SkinnedRegion& region,
                 const VtkOptions& vtk, const OutputFolder& out, Stopwatch& watch,
                 const Progress& progress) {
  if (!scene.compare.empty()) {
    compare_into(report, scene, {&region}, progress);
    watch.lap("compare");
  }
  progress.at("files", 0);
  if (!scene.step.empty()) {
    progress.at("STEP", 0);
    write_step_into(report, scene, region, out);
    watch.lap("step");
  }
  if (!scene.vtp.empty() || !scene.vtu.empty()) {
    progress.at("VTK", 0);
    if (!scene.vtp.empty()) write_vtp(out.file(scene.vtp), {&region}, vtk);
    if (!scene.vtu.empty()) write_vtu(out.file(scene.vtu), {&region}, vtk);
    for (const auto& file : {scene.vtp, scene.vtu})
      if (!file.empty()) report.files.push_back(file);
    watch.lap("vtk");
  }
  if (!scene.calculix.empty()) {
    write_calculix(out.file(scene.calculix), region, deck_of(scene, region));
    report.files.push_back(scene.calculix);
    watch.lap("calculix");
  }
}

PictureScene picture_of(const PictureScene& look, const SkinnedRegion& region) {
  PictureScene picture = look;
  picture.regions = {&region};
  return picture;
}

}  // namespace batten
