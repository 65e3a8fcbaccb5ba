#include "batten/apps/commands/shapes/stress_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include "batten/analysis/models/shell_modes.h"
#include "batten/analysis/models/shell_refinement.h"
#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/apps/commands/shapes/stress_files.h"
#include "batten/apps/commands/shapes/stress_setup.h"
#include "batten/core/errors.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {
namespace {

std::string region_at(const ModelLayout& layout, const Location& where) {
  return layout.region(layout.region_of(where.triangle)).name();
}

bool is_combination(const SceneStress& stress, const std::string& name) {
  return std::any_of(stress.combinations.begin(), stress.combinations.end(),
                     [&](const SceneStress::Combination& sum) { return sum.name == name; });
}

StressReport::Case case_report(const SceneStress& stress, const ModelLayout& layout,
                               const ShellCaseResult& result) {
  StressReport::Case c;
  c.name = result.name;
  c.combination = is_combination(stress, result.name);
  c.force = result.load.force;
  for (const SupportReaction& r : result.reactions)
    c.reactions.push_back({r.support, r.resultant.force, r.resultant.moment});
  c.equilibrium_residual = result.equilibrium_residual;
  c.energy = result.energy;
  const MaxDisplacement& moved = result.max_displacement;
  c.displacement = moved.value;
  c.displacement_error = moved.error;
  c.displacement_vector = moved.vector;
  c.max_displacement_at = moved.at;
  if (moved.value > 0) c.max_displacement_region = region_at(layout, moved.where);
  const ShellStresses::Peak& peak = result.max_stress;
  c.stress = peak.value;
  c.side = peak.height > 0 ? "top" : "bottom";
  c.max_stress_at = peak.at;
  c.max_stress_face_point = result.max_stress_point;
  c.max_stress_region = region_at(layout, peak.where);
  c.spread = peak.spread;
  c.near_singularity = result.near_singularity;
  c.error = result.energy_norm_error;
  if (stress.yield > 0 && c.stress > 0) c.safety = stress.yield / c.stress;
  return c;
}

// The report without cases and frequencies.
StressReport shell_report(const SceneStress& stress, const ShellModel& shell) {
  StressReport report;
  report.material = stress.material;
  report.unknowns = shell.unknowns();
  report.yield = stress.yield;
  report.weakly_constrained_motions = shell.rigid_body_modes().weakly_constrained;
  report.smallest_lever = shell.rigid_body_modes().smallest_lever;
  const ThinShellRatios ratios = thin_shell_ratios(shell);
  report.thickness_over_radius = ratios.thickness_over_radius;
  report.edge_over_boundary_layer = ratios.edge_over_boundary_layer;
  return report;
}

void warn(const StressReport& s, std::vector<std::string>& warnings) {
  constexpr double thin = 0.1, coarse = 1.5;
  if (s.thickness_over_radius > thin)
    warnings.push_back("the ratio of thickness to radius of curvature reaches " +
                       format_number(s.thickness_over_radius) +
                       ", but thin shell theory is only valid up to about 0.1");
  if (s.edge_over_boundary_layer > coarse)
    warnings.push_back(
        "element edges are up to " + format_number(s.edge_over_boundary_layer) +
        " times √(radius × thickness) long and may be too stiff above 1.5: compare with a smaller "
        "edge_length");
  for (const std::string& motion : s.weakly_constrained_motions)
    warnings.push_back("the supports hardly prevent a rigid-body motion: " + motion +
                       ", with a lever arm of " + format_number(100 * s.smallest_lever) +
                       " % of the size, so that results depend strongly on their exact position");
  for (const auto& c : s.cases)
    if (c.near_singularity)
      warnings.push_back("case '" + c.name +
                         "': the maximum stress is next to a point load or point support, a "
                         "singularity where it grows without limit under mesh refinement");
}

std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

void find_buckling(const Scene& scene, const ShellModel& shell, const Points& displacement,
                   StressReport::Case& c, StressFiles& files) {
  const ShellBuckling found = buckling(shell, displacement, scene.stress->buckling);
  std::vector<std::string> captions;
  for (const double factor : found.factors) {
    c.buckling.push_back(factor);
    captions.push_back(c.name + ": buckling at " + three_digits(factor) + " times the load");
  }
  c.buckling_requested = true;
  if (!captions.empty()) files.write_mode_shapes(c.name + " buckling", found.shapes, captions);
}

void find_modes(const Scene& scene, const ShellModel& shell, StressReport& report,
                StressFiles& files) {
  const ShellModes modes = natural_modes(shell, scene.stress->modes);
  std::vector<std::string> captions;
  for (const double f : modes.frequencies) {
    report.frequencies.push_back(f);
    captions.push_back(three_digits(f) + " Hz");
  }
  files.write_mode_shapes("modes", modes.shapes, captions);
}

}  // namespace

void analyse(RunContext& run, const Scene& scene, const SolvedShape& shape,
             const BackendFactory& factors, const Progress& progress) {
  if (!shape.layout) return;
  progress.update("stress", 0);
  const ShellProblem problem = shell_problem(scene);
  const ShellDefinition definition = problem.definition(*shape.layout, shape.dofs);
  const ShellModel shell(*shape.layout, shape.dofs, definition,
                         ShellModel::RigidBodyHandling::Refused, factors);
  run.watch.lap("stress");
  StressFiles files(run, scene, shell);
  StressReport report = shell_report(*scene.stress, shell);
  const auto add = [&](const ShellCaseResult& result, const ShellStresses& stresses) {
    StressReport::Case c = case_report(*scene.stress, shell.layout(), result);
    files.write_case(c.name, result.displacement, c.displacement, stresses);
    constexpr double balanced = 1e-8;
    if (!(c.equilibrium_residual <= balanced))
      run.report.failed_checks.push_back(
          {"stress.equilibrium_residual of " + c.name,
           "is " + format_number(c.equilibrium_residual) + ", expected at most 1e-8"});
    if (scene.stress->buckling > 0) find_buckling(scene, shell, result.displacement, c, files);
    report.cases.push_back(std::move(c));
  };
  evaluate_load_cases(shell, problem.load_cases(*shape.layout, shape.dofs, definition), add,
                      nullptr, progress);
  if (scene.stress->modes > 0) find_modes(scene, shell, report, files);
  warn(report, run.report.warnings);
  run.report.stress = std::move(report);
  run.watch.lap("stress files");
}

namespace {

std::string format_rounded_point(const Vec3& p) {
  std::string text;
  for (int c = 0; c < 3; ++c) text += (c ? ", " : "(") + three_digits(p[c]);
  return text + ")";
}

}  // namespace

std::string stress_summary(const StressReport& report, const std::string& unit) {
  std::string text =
      summary_line("stress", std::to_string(report.unknowns) + " unknowns" +
                                 (report.material.empty() ? "" : ", " + report.material));
  for (const auto& m : report.meshes)
    text +=
        summary_line(&m == &report.meshes[0] ? "meshes" : "",
                     "edge length " + three_digits(m.edge_length) + " " + unit + ": " +
                         std::to_string(m.unknowns) + " unknowns, displacement " +
                         three_digits(m.displacement) + ", von Mises " + three_digits(m.stress) +
                         ", error " + three_digits(100 * m.error) + " %");
  for (const auto& c : report.cases) {
    std::string stress = "von Mises " + three_digits(c.stress) + " at " +
                         format_rounded_point(c.max_stress_at) + ", " + c.side + " of '" +
                         c.max_stress_region + "', ± " + three_digits(c.spread);
    if (c.safety > 0) stress += "; safety factor " + three_digits(c.safety);
    text += summary_line(c.combination ? "combination" : "case", "'" + c.name + "': " + stress);
    if (c.calculix)
      text += summary_line("", "CalculiX, " + c.calculix->elements + ": displacement " +
                                   three_digits(c.calculix->displacement) + " " + unit +
                                   ", at the same point " +
                                   three_digits(c.calculix->displacement_there) + "; von Mises " +
                                   three_digits(c.calculix->stress) + ", at the same point " +
                                   three_digits(c.calculix->stress_there));
    if (c.buckling_requested)
      text += summary_line(
          "", c.buckling.empty() ? "does not buckle under this load"
                                 : "buckles at " + three_digits(c.buckling[0]) + " times its load");
    text += summary_line("", "displacement " + three_digits(c.displacement) + " " + unit + " at " +
                                 format_rounded_point(c.max_displacement_at) + ", ± " +
                                 three_digits(c.displacement_error) + "; error about " +
                                 three_digits(100 * c.error) + " % in energy norm");
  }
  for (const auto& d : report.sensitivities)
    text += summary_line(&d == &report.sensitivities[0] ? "sensitivity" : "",
                         "to '" + d.parameter + "', case '" + d.load_case + "': displacement " +
                             three_digits(d.displacement) + " " + unit + ", work of the loads " +
                             three_digits(d.compliance) + ", per unit of the parameter");
  std::string hertz;
  for (const double f : report.frequencies) hertz += (hertz.empty() ? "" : ", ") + three_digits(f);
  if (!hertz.empty()) text += summary_line("frequencies", hertz + " Hz");
  return text;
}

namespace {

double step_of(const Parameter& p) {
  constexpr double fraction = 1e-3;
  const double range = p.max - p.min;
  return fraction * (std::isfinite(range) && range > 0 ? range : std::max(std::abs(p.value), 1.0));
}

// The scene with a changed parameter; empty if the value is not permitted.
std::optional<Scene> moved(const Scene& scene, const Parameter& p, double by) {
  try {
    Scene other = scene;
    other.set(p.name, p.value + by, "");
    return other;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress) {
  std::vector<ShellSensitivities::Goal> goals;
  const std::vector<std::string> names = scene.stress->cases();
  for (const StressReport::Case& c : run.report.stress->cases)
    if (std::count(names.begin(), names.end(), c.name) && c.displacement > 0)
      goals.push_back({c.name, c.max_displacement_at, c.displacement_vector});
  const ShellSensitivities sensitivities(*shape.layout, shape.dofs, shell_problem(scene), goals);
  std::set<std::string> of_lines;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { of_lines.insert(name); });
  for (const Parameter& p : scene.parameters()) {
    if (of_lines.count(p.name)) continue;
    progress.update("sensitivity to " + p.name, 0);
    const auto shape_with = [&](double change) -> std::optional<Points> {
      const auto other = change == 0 ? std::optional(scene) : moved(scene, p, change);
      if (!other) return std::nullopt;
      return solve_shape(*shape.layout, *other, made, {{}, progress.cancelled}).dofs;
    };
    const auto rate = shape_derivative(shape_with, step_of(p));
    if (!rate || !(rate->cwiseAbs().maxCoeff() > 0)) continue;
    const auto derivatives = sensitivities.along(*rate);
    for (size_t g = 0; g < goals.size(); ++g)
      run.report.stress->sensitivities.push_back(
          {p.name, goals[g].load_case, derivatives[g].displacement, derivatives[g].compliance});
  }
  run.watch.lap("sensitivities");
}

RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress) {
  RefinedShape result{shape, {}, false};
  if (!shape.layout) return result;
  ShellRefinementOptions options;
  options.accuracy = accuracy;
  options.backend_factory = factors;
  const RefinedShell refined =
      refine_shell(shape.layout, shape.dofs, shell_problem(scene), options, progress);
  result.converged = refined.converged;
  for (const RefinedShell::Mesh& mesh : refined.meshes)
    result.meshes.push_back(
        {mesh.edge_length, mesh.unknowns, mesh.displacement, mesh.von_mises, mesh.error});
  if (refined.meshes.size() == 1) return result;
  SolvedShape& finer = result.shape;
  finer.layout = refined.layout;
  finer.dofs = refined.shape;
  finer.unloaded = interpolate_onto(*shape.layout, shape.unloaded, *refined.layout);
  finer.regions.clear();
  for (int r = 0; r < finer.layout->region_count(); ++r)
    finer.regions.push_back(finer.layout->skinned(r, finer.dofs));
  return result;
}

}  // namespace batten
