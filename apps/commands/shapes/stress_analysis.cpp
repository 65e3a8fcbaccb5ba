#include "batten/apps/commands/shapes/stress_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "batten/analysis/models/shell_modes.h"
#include "batten/analysis/models/shell_stresses.h"
#include "batten/apps/commands/shapes/stress_files.h"
#include "batten/apps/commands/shapes/stress_setup.h"
#include "batten/core/errors.h"
#include "batten/fem/refinement.h"
#include "batten/skinning/surfaces/model_joins.h"

namespace batten {
namespace {

/// One load case or combination, with its solution.
struct CaseResult {
  StressReport::Case report;
  Points load, displacement;
  Location max_location;  // location of the largest displacement
};

std::vector<CaseResult> solve_cases(const Scene& scene, const ShellModel& shell,
                                    const ShellDefinition& definition) {
  const auto loads = case_loads(scene, shell.layout(), shell.shape(), definition);
  std::vector<CaseResult> results;
  for (const std::string& name : scene.stress->cases()) {
    results.emplace_back();
    results.back().report.name = name;
    results.back().load = loads.at(name);
  }
  for (const SceneStress::Combination& sum : scene.stress->combinations) {
    results.emplace_back();
    results.back().report.name = sum.name;
    results.back().report.combination = true;
    results.back().load = Points::Zero(shell.shape().rows(), 3);
    for (const auto& [load_case, factor] : sum.parts)
      results.back().load += factor * loads.at(load_case.text);
  }
  if (results.empty()) {  // prescribed displacements only
    results.emplace_back();
    results.back().report.name = "supports";
    results.back().load = Points::Zero(shell.shape().rows(), 3);
  }
  for (CaseResult& a : results) a.displacement = shell.solve(a.load);
  return results;
}

void measure_balance(const ShellModel& shell, CaseResult& a) {
  StressReport::Case& c = a.report;
  const Resultant load = resultant(shell.layout(), shell.shape(), a.load);
  c.force = load.force;
  Vec3 sum = load.force;
  double size = 0;
  for (const SupportReaction& r : shell.reactions(a.displacement, a.load)) {
    c.reactions.push_back({r.support, r.resultant.force, r.resultant.moment});
    sum += r.resultant.force;
    size += r.resultant.force.norm();
  }
  size = std::max(size, load.force.norm());
  c.equilibrium_residual = size > 0 ? sum.norm() / size : 0;
  c.energy = shell.energy(a.displacement);
}

// Visits vertices inside the trim and, in cut triangles, quadrature points of their inside.
template <class Visit>
void visit_sample_points(const Surface& surface, const Visit& visit) {
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    if (!trim || trim->side(t) != Trim::Side::Cut) {
      for (int i = 0; i < 3; ++i) visit(Location{t, Vec3::Unit(i)});
      continue;
    }
    const TriangleRule rule = trim->rule(t, 1);
    for (long p = 0; p < rule.weights.size(); ++p) visit(Location{t, rule.L.row(p).transpose()});
  }
}

void measure_displacement(const ShellModel& shell, CaseResult& a) {
  const Surface& surface = shell.assembler().surface();
  const Surface moved = shell.layout().surface(a.displacement);
  StressReport::Case& c = a.report;
  visit_sample_points(surface, [&](const Location& where) {
    const Vec3 u = moved.position(where);
    if (!(u.norm() > c.displacement)) return;
    c.displacement = u.norm();
    a.max_location = where;
    c.displacement_vector = u;
    c.max_displacement_at = surface.position(where);
    c.max_displacement_region =
        shell.layout().region(shell.layout().region_of(where.triangle)).name();
  });
}

// Estimates the error of the largest displacement with its adjoint solution. Adds to `where`
// (empty, or one entry per triangle) the contribution of each triangle to this error and to the
// energy error.
void estimate_displacement_error(const ShellModel& shell, const ShellStresses& stresses,
                                 CaseResult& a, VecX& where) {
  StressReport::Case& c = a.report;
  const auto add = [&](const VecX& parts) {
    const double sum = parts.cwiseAbs().sum();
    if (where.size() == parts.size() && sum > 0) where += parts.cwiseAbs() / sum;
    return std::abs(parts.sum());
  };
  if (where.size() > 0) add(stresses.goal_error_per_triangle(stresses));
  if (!(c.displacement > 0)) return;
  const Vec3 direction = c.displacement_vector / c.displacement;
  const Points adjoint =
      shell.adjoint(point_force(shell.layout(), {{}, a.max_location, 0}, direction));
  c.displacement_error = add(stresses.goal_error_per_triangle(ShellStresses(shell, adjoint)));
}

// Edge length √(twice the mean area of triangles).
double edge_length(const ParametricMesh& mesh, const Surface& surface, int t) {
  const double area =
      mesh.shape(t).area * surface.jet({t, Vec3::Constant(1.0 / 3)}).area_vector().norm();
  return std::sqrt(2 * area);
}

void measure_stress(const Scene& scene, const ShellModel& shell, const ShellDefinition& definition,
                    const ShellStresses& stresses, StressReport::Case& c) {
  const auto peak = stresses.peak();
  c.stress = peak.value;
  c.side = peak.height > 0 ? "top" : "bottom";
  c.max_stress_at = peak.at;
  c.max_stress_face_point = peak.at + 0.5 * peak.height * stresses.at(peak.where).thickness *
                                          shell.assembler().surface().jet(peak.where).normal();
  c.max_stress_region = shell.layout().region(shell.layout().region_of(peak.where.triangle)).name();
  c.spread = peak.spread;
  c.error = stresses.energy_norm_error();
  if (scene.stress->yield > 0 && c.stress > 0) c.safety = scene.stress->yield / c.stress;
  const Surface& surface = shell.assembler().surface();
  constexpr double near = 3;  // in edge lengths
  const double reach = near * edge_length(surface.mesh(), surface, peak.where.triangle);
  const auto look = [&](const Vec3& p) { c.near_singularity |= (p - peak.at).norm() < reach; };
  for (const SceneStress::Load& load : scene.stress->loads)
    if (load.type == SceneStress::Load::Type::Point) look(load.point);
  for (const PointSupport& support : definition.points)
    look(surface.position(support.position.where));
}

// Measures thickness relative to the radii of curvature, and element size.
void measure_theory(const ShellModel& shell, StressReport& report) {
  const Surface& surface = shell.assembler().surface();
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const Curvatures bend = curvatures(surface.jet({t, Vec3::Constant(1.0 / 3)}));
    const double k = std::max(std::abs(bend.k1), std::abs(bend.k2));
    const double thickness = shell.assembler().section(t).thickness;
    report.thickness_over_radius = std::max(report.thickness_over_radius, thickness * k);
    report.edge_over_boundary_layer =
        std::max(report.edge_over_boundary_layer,
                 edge_length(surface.mesh(), surface, t) * std::sqrt(k / thickness));
  }
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

void find_buckling(const Scene& scene, const ShellModel& shell, CaseResult& a, StressFiles& files) {
  const ShellBuckling found = buckling(shell, a.displacement, scene.stress->buckling);
  std::vector<std::string> captions;
  for (const double factor : found.factors) {
    a.report.buckling.push_back(factor);
    captions.push_back(a.report.name + ": buckling at " + three_digits(factor) + " times the load");
  }
  a.report.buckling_requested = true;
  if (!captions.empty())
    files.write_mode_shapes(a.report.name + " buckling", found.shapes, captions);
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

// Solves and evaluates all cases in order. each(shell, answer, stresses) may add results to a case.
template <class Each>
StressReport solved(const Scene& scene, const ShellModel& shell, const ShellDefinition& definition,
                    VecX& where, const Progress& progress, const Each& each) {
  StressReport report;
  report.material = scene.stress->material;
  report.unknowns = shell.unknowns();
  report.yield = scene.stress->yield;
  report.weakly_constrained_motions = shell.rigid_body_modes().weakly_constrained;
  report.smallest_lever = shell.rigid_body_modes().smallest_lever;
  measure_theory(shell, report);
  for (CaseResult& a : solve_cases(scene, shell, definition)) {
    progress.update("stress of " + a.report.name, 0);
    measure_balance(shell, a);
    measure_displacement(shell, a);
    const ShellStresses stresses(shell, a.displacement);
    estimate_displacement_error(shell, stresses, a, where);
    measure_stress(scene, shell, definition, stresses, a.report);
    each(a, stresses);
    report.cases.push_back(a.report);
  }
  return report;
}

}  // namespace

StressEvaluator::MaxValues StressEvaluator::at(const ModelLayout& layout, const Points& dofs) {
  if (shell_ && shell_->layout().mesh() == layout.mesh()) {
    shell_->update_shape(dofs);
  } else {
    require_consistent_units(scene_);
    definition_ = shell_definition(scene_, layout, dofs);
    shell_.emplace(layout, dofs, definition_);
  }
  MaxValues largest;
  displacement_.resize(0, 3);
  for (CaseResult& a : solve_cases(scene_, *shell_, definition_)) {
    measure_displacement(*shell_, a);
    largest.displacement = std::max(largest.displacement, a.report.displacement);
    const double peak = ShellStresses(*shell_, a.displacement).peak().value;
    if (displacement_.size() > 0 && peak < largest.von_mises) continue;
    largest.von_mises = peak;
    governing_case_ = a.report.name;
    displacement_ = std::move(a.displacement);
  }
  return largest;
}

StressEvaluator::Field StressEvaluator::field(const std::vector<Location>& places) const {
  const ShellStresses stresses(*shell_, displacement_);
  const Surface moved = shell_->layout().surface(displacement_);
  Field field;
  field.load_case = governing_case_;
  for (const Location& where : places) {
    const ShellStress stress = stresses.at(where);
    const Vec3 u = moved.position(where);
    field.von_mises.push_back(
        static_cast<float>(std::max(von_mises(stress.at(1)), von_mises(stress.at(-1)))));
    for (const double x : u) field.displacement.push_back(static_cast<float>(x));
  }
  return field;
}

StressEvaluator::ModeShapes StressEvaluator::mode_shapes(const std::vector<Location>& places,
                                                         int count) const {
  const ShellModes modes = natural_modes(*shell_, std::min(count, shell_->unknowns() / 2 - 1));
  ModeShapes mode_shapes;
  for (size_t m = 0; m < modes.shapes.size(); ++m) {
    const Surface shape = shell_->layout().surface(modes.shapes[m]);
    std::vector<float> moved;
    double largest = 0;
    for (const Location& where : places) {
      const Vec3 u = shape.position(where);
      largest = std::max(largest, u.norm());
      for (const double x : u) moved.push_back(static_cast<float>(x));
    }
    for (float& x : moved) x = static_cast<float>(x / std::max(largest, 1e-300));
    mode_shapes.frequencies.push_back(modes.frequencies[static_cast<long>(m)]);
    mode_shapes.displacements.push_back(std::move(moved));
  }
  return mode_shapes;
}

StressReport stresses_of(const Scene& scene, const SolvedShape& shape, VecX& where,
                         const BackendFactory& factors, const Progress& progress) {
  require_consistent_units(scene);
  const ShellDefinition definition = shell_definition(scene, *shape.layout, shape.dofs);
  const ShellModel shell(*shape.layout, shape.dofs, definition,
                         ShellModel::RigidBodyHandling::Refused, factors);
  where = VecX::Zero(shape.layout->mesh()->triangle_count());
  return solved(scene, shell, definition, where, progress,
                [](CaseResult&, const ShellStresses&) {});
}

void analyse(RunContext& run, const Scene& scene, const SolvedShape& shape,
             const BackendFactory& factors, const Progress& progress) {
  if (!shape.layout) return;
  require_consistent_units(scene);
  progress.update("stress", 0);
  const ShellDefinition definition = shell_definition(scene, *shape.layout, shape.dofs);
  const ShellModel shell(*shape.layout, shape.dofs, definition,
                         ShellModel::RigidBodyHandling::Refused, factors);
  run.watch.lap("stress");
  StressFiles files(run, scene, shell);
  VecX ignored_indicators;
  StressReport report = solved(
      scene, shell, definition, ignored_indicators, progress,
      [&](CaseResult& a, const ShellStresses& stresses) {
        files.write_case(a.report.name, a.displacement, a.report.displacement, stresses);
        constexpr double balanced = 1e-8;
        if (!(a.report.equilibrium_residual <= balanced))
          run.report.failed_checks.push_back(
              {"stress.equilibrium_residual of " + a.report.name,
               "is " + format_number(a.report.equilibrium_residual) + ", expected at most 1e-8"});
        if (scene.stress->buckling > 0) find_buckling(scene, shell, a, files);
      });
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

// A case with its goal functional: the displacement at the location of its maximum, in its
// direction.
struct Goal {
  const StressReport::Case& of;
  Points F, u, G;
  Points of_G, of_F;  // adjoint solutions
};

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

// Derivative of the dofs of the shape, by central differences if the parameter permits both
// directions.
std::optional<Points> shape_change(const Scene& scene, const BuiltModel& made,
                                   const SolvedShape& shape, const Parameter& p,
                                   const Progress& progress) {
  const double step = step_of(p);
  const auto at = [&](double by) -> std::optional<Points> {
    const auto other = moved(scene, p, by);
    if (!other) return std::nullopt;
    return solve_shape(*shape.layout, *other, made, {{}, progress.cancelled}).dofs;
  };
  const auto up = at(step), down = at(-step);
  if (up && down) return Points((*up - *down) / (2 * step));
  if (!up && !down) return std::nullopt;
  const Points here = solve_shape(*shape.layout, scene, made, {{}, progress.cancelled}).dofs;
  return up ? Points((*up - here) / step) : Points((here - *down) / step);
}

}  // namespace

void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress) {
  const ShellDefinition definition = shell_definition(scene, *shape.layout, shape.dofs);
  const ShellModel shell(*shape.layout, shape.dofs, definition);
  const auto loads = case_loads(scene, *shape.layout, shape.dofs, definition);
  std::vector<Goal> goals;
  for (const StressReport::Case& c : run.report.stress->cases) {
    const auto F = loads.find(c.name);
    if (c.combination || F == loads.end() || !(c.displacement > 0)) continue;
    const ShellLocation place = nearest_location(*shape.layout, shape.dofs, c.max_displacement_at);
    const Points G = point_force(*shape.layout, place, c.displacement_vector.normalized());
    goals.push_back(
        {c, F->second, shell.solve(F->second), G, shell.adjoint(G), shell.adjoint(F->second)});
  }
  std::set<std::string> of_lines;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { of_lines.insert(name); });
  for (const Parameter& p : scene.parameters()) {
    if (of_lines.count(p.name)) continue;
    progress.update("sensitivity to " + p.name, 0);
    const auto change = shape_change(scene, made, shape, p, progress);
    if (!change) continue;
    const double largest = change->cwiseAbs().maxCoeff();
    if (!(largest > 0)) continue;
    // A step that is small compared with the model, and large compared with rounding.
    const double step = 1e-5 * shape.layout->size() / largest;
    const Points up = shape.dofs + step * *change, down = shape.dofs - step * *change;
    const auto up_loads = case_loads(scene, *shape.layout, up, definition),
               down_loads = case_loads(scene, *shape.layout, down, definition);
    const ShellSystem up_system = shell.assemble_system(up),
                      down_system = shell.assemble_system(down);
    for (const Goal& g : goals) {
      const auto derivative = [&](const Points& a, const Points& G) {
        return (shell.goal_change(g.u, g.F, a, G, up_system, up_loads.at(g.of.name)) -
                shell.goal_change(g.u, g.F, a, G, down_system, down_loads.at(g.of.name))) /
               (2 * step);
      };
      // Of the work Fᵀu itself: its load is the goal, and varies too.
      const double work =
          derivative(g.of_F, g.F) +
          (up_loads.at(g.of.name) - down_loads.at(g.of.name)).cwiseProduct(g.u).sum() / (2 * step);
      run.report.stress->sensitivities.push_back(
          {p.name, g.of.name, derivative(g.of_G, g.G), work});
    }
  }
  run.watch.lap("sensitivities");
}

namespace {

// Mean edge length of a shape's elements.
double mean_edge(const SolvedShape& shape) {
  double area = 0, triangles = 0;
  for (const SkinnedRegion& region : shape.regions) {
    const Surface& surface = region.surface;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      area += surface.mesh().shape(t).area *
              surface.jet({t, Vec3::Constant(1.0 / 3)}).area_vector().norm();
      ++triangles;
    }
  }
  return std::sqrt(2 * area / triangles);
}

StressReport::Mesh mesh_of(const StressReport& report, double edge_length) {
  StressReport::Mesh mesh{edge_length, report.unknowns, 0, 0, 0};
  for (const StressReport::Case& c : report.cases) {
    mesh.displacement = std::max(mesh.displacement, c.displacement);
    mesh.stress = std::max(mesh.stress, c.stress);
    mesh.error = std::max(mesh.error, std::pow(c.error, 2));
    if (c.displacement > 0)
      mesh.error = std::max(mesh.error, c.displacement_error / c.displacement);
  }
  return mesh;
}

// The same surface with bisected triangles.
SolvedShape halved(const SolvedShape& shape, const std::vector<int>& triangles) {
  std::vector<char> marks(static_cast<size_t>(shape.layout->mesh()->triangle_count()), 0);
  for (const int t : triangles) marks[t] = 1;
  ModelLayout finer = *shape.layout;
  finer.refine(marks);
  SolvedShape result = shape;
  result.dofs = interpolate_onto(*shape.layout, shape.dofs, finer);
  result.unloaded = interpolate_onto(*shape.layout, shape.unloaded, finer);
  result.regions.clear();
  for (int r = 0; r < finer.region_count(); ++r)
    result.regions.push_back(finer.skinned(r, result.dofs));
  result.layout = std::make_shared<const ModelLayout>(std::move(finer));
  return result;
}

}  // namespace

RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress) {
  RefinedShape result{shape, {}, false};
  if (!shape.layout) return result;
  constexpr int most = 20;
  constexpr double fraction = 0.7;  // of the error, in the bisected triangles
  SolvedShape next = shape;
  for (int round = 0; round < most; ++round) {
    progress.update("mesh " + std::to_string(round + 1), 0);
    VecX where;
    try {
      const StressReport report = stresses_of(scene, next, where, factors, progress);
      result.meshes.push_back(mesh_of(report, mean_edge(next)));
      result.shape = next;
      result.converged = result.meshes.back().error <= accuracy;
      if (result.converged) break;
      next = halved(next, dorfler_marking(where, fraction));
    } catch (const InputError&) {
      if (round == 0) throw;  // otherwise keep the largest mesh that fits into memory
      break;
    }
  }
  return result;
}

}  // namespace batten
