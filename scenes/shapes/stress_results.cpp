// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_results.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "batten/analysis/models/harmonic_response.h"
#include "batten/analysis/models/shell_modes.h"
#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/analysis/models/theory_limits.h"
#include "batten/core/errors.h"
#include "batten/scenes/shapes/shape_derivatives.h"
#include "batten/scenes/shapes/stress_places.h"
#include "batten/scenes/shapes/stress_probes.h"
#include "batten/scenes/shapes/stress_setup.h"
#include "batten/scenes/shapes/stress_spectrum.h"

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
  if (!stress.plies.empty()) c.ply = peak.ply + 1;
  for (const auto& [criterion, reserve] :
       {std::pair{"Tsai-Hill", &result.tsai_hill}, std::pair{"Hoffman", &result.hoffman}})
    if (*reserve)
      c.reserves.push_back({criterion, (*reserve)->factor, (*reserve)->ply + 1, (*reserve)->at,
                            region_at(layout, (*reserve)->where)});
  c.max_stress_at = peak.at;
  c.max_stress_face_point = result.max_stress_point;
  c.max_stress_region = region_at(layout, peak.where);
  c.spread = peak.spread;
  c.near_singularity = result.near_singularity;
  for (const StiffenerResult& s : result.stiffeners)
    c.stiffeners.push_back({s.name,
                            s.largest_stress,
                            s.stress_at,
                            {s.least.axial, s.largest.axial},
                            {s.least.bending, s.largest.bending},
                            {s.least.lateral_bending, s.largest.lateral_bending},
                            {s.least.torque, s.largest.torque}});
  c.error = result.energy_norm_error;
  if (stress.yield > 0 && c.stress > 0) c.safety = stress.yield / c.stress;
  return c;
}

// The report without cases and frequencies.
StressReport shell_report(const SceneStress& stress, const ShellModel& shell) {
  StressReport report;
  report.material = stress.material.name;
  report.unknowns = shell.unknowns();
  report.yield = stress.yield;
  report.weakly_constrained_motions = shell.rigid_body_modes().weakly_constrained;
  report.smallest_lever = shell.rigid_body_modes().smallest_lever;
  const ThinShellRatios ratios = thin_shell_ratios(shell);
  report.thickness_over_radius = ratios.thickness_over_radius;
  report.edge_over_boundary_layer = ratios.edge_over_boundary_layer;
  return report;
}

// What the linear theory of thin shells neglects.
void warn_of_limits(const StressReport::Case& c, double size, const std::string& unit,
                    std::vector<std::string>& warnings) {
  constexpr double little = 0.1, large = 0.1;
  const auto percent = [](double share) { return format_number(std::round(100 * share)) + " %"; };
  if (c.displacement > large * size)
    warnings.push_back("case '" + c.name + "': the displacement of " +
                       format_number(c.displacement) + " " + unit + " is " +
                       percent(c.displacement / size) +
                       " of the size of the shell: check the units of loads and modulus");
  else if (c.nonlinearity > little)
    warnings.push_back(
        "case '" + c.name +
        "': the displacements are too large for a linear analysis: they would change "
        "by about " +
        percent(c.nonlinearity) + ", and the stresses with them");
  if (c.shear_share > little)
    warnings.push_back("case '" + c.name +
                       "': the shell is thick for its loads: transverse shear, which thin shells "
                       "neglect, would increase the displacements by about " +
                       percent(c.shear_share));
}

std::string singular_warning(const StressReport::Case& c, const std::string& unit) {
  constexpr size_t most = 4;  // points in the text
  std::string points;
  double radius = 0;
  for (const auto& place : c.singular_places) {
    const auto index = static_cast<size_t>(&place - c.singular_places.data());
    if (index < most) points += (index > 0 ? ", " : "") + format_point(place.at);
    if (index == most) points += ", …";
    radius = std::max(radius, place.radius);
  }
  return "case '" + c.name + "': the stress is singular at " + points +
         ": there it grows without limit as the elements become smaller (a point force or point "
         "support, a re-entrant corner, the end of a support). The largest stress is that at a "
         "distance of " +
         format_number(radius) + " " + unit + " or more";
}

void warn(const StressReport& s, double size, const std::string& unit,
          std::vector<std::string>& warnings) {
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
  for (const auto& c : s.cases) warn_of_limits(c, size, unit, warnings);
  for (const auto& c : s.cases)
    if (!c.singular_places.empty()) warnings.push_back(singular_warning(c, unit));
  constexpr double uncertain = 0.1;
  for (const auto& c : s.cases)
    if (s.meshes.empty() && !c.combination && !c.near_singularity &&
        c.spread > uncertain * c.stress)
      warnings.push_back("case '" + c.name + "': the largest stress is uncertain by about " +
                         format_number(std::round(100 * c.spread / c.stress)) +
                         " % on these elements; an accuracy of 0.02 refines them");
  for (const auto& c : s.cases)
    if (c.near_singularity)
      warnings.push_back("case '" + c.name +
                         "': the maximum stress is next to a point load or point support, a "
                         "singularity where it grows without limit under mesh refinement");
}

void find_buckling(const Scene& scene, const ShellModel& shell, const ShellLoadCase& load_case,
                   const Points& displacement, StressReport::Case& c, StressVisitor& visitor) {
  const ShellBuckling found = buckling(shell, displacement, scene.stress->buckling,
                                       load_case.follower, load_case.temperature);
  c.buckling.assign(found.factors.begin(), found.factors.end());
  c.buckling_requested = true;
  visitor.visit_buckling(c, found.shapes);
}

void estimate_limits(const ShellModel& shell, const ShellLoadCase& load_case,
                     const ShellCaseResult& result, const ShellStresses& stresses,
                     StressReport::Case& c) {
  // Springs store the rest of the work.
  const double work = std::abs(0.5 * load_case.load.cwiseProduct(result.displacement).sum());
  c.nonlinearity = nonlinearity(shell, result.displacement, std::max(result.energy, work),
                                load_case.temperature);
  if (result.energy > 0)
    c.shear_share = transverse_shear_energy(shell.assembler(), stresses) / result.energy;
}

/// Steady vibrations of the points of `results`, and of the point of the largest displacement.
void find_vibrations(const Scene& scene, const ShellModel& shell, const ShellModes& modes,
                     const ShellLoadCase& load_case, const ShellCaseResult& result,
                     StressReport::Case& c, StressVisitor& visitor) {
  const SceneStress::Harmonic& range = *scene.stress->harmonic;
  const HarmonicResponse response(modes, load_case.load, range.damping);
  std::vector<double> frequencies;
  for (int k = 0; k <= range.steps; ++k)
    frequencies.push_back(std::lerp(range.from, range.to, static_cast<double>(k) / range.steps));
  for (const double f : modes.frequencies)  // the peaks
    if (f > range.from && f < range.to) frequencies.push_back(f);
  std::sort(frequencies.begin(), frequencies.end());
  std::vector<std::string> points = {"largest displacement"};
  std::vector<Location> places = {result.max_displacement.where};
  for (const SceneStress::Result& of : scene.stress->results) {
    if (!of.point) continue;
    points.push_back(of.name);
    places.push_back(place_of(scene, shell.layout(), shell.shape(), *of.point, of.location).where);
  }
  const Surface still = shell.layout().surface(shell.adjoint(load_case.load));
  std::vector<Surface> shapes;
  for (const Points& shape : modes.shapes) shapes.push_back(shell.layout().surface(shape));
  std::vector<std::vector<Eigen::Vector3cd>> amplitudes(frequencies.size());
  for (size_t p = 0; p < places.size(); ++p) {
    std::vector<Vec3> shapes_here;
    for (const Surface& shape : shapes) shapes_here.push_back(shape.position(places[p]));
    StressReport::Case::Vibration largest{points[p], 0, 0};
    for (size_t k = 0; k < frequencies.size(); ++k) {
      amplitudes[k].push_back(response.at(frequencies[k], still.position(places[p]), shapes_here));
      if (const double size = amplitudes[k].back().norm(); size > largest.amplitude)
        largest = {points[p], frequencies[k], size};
    }
    c.vibrations.push_back(std::move(largest));
  }
  visitor.visit_harmonic(c, frequencies, points, amplitudes);
}

void find_spectrum_response(const Scene& scene, const ShellModel& shell, StressReport& report,
                            StressVisitor& visitor) {
  const SceneStress::Spectrum& of = *scene.stress->spectrum;
  const ResponseSpectrum spectrum(of.points);
  const ShellModes modes = modes_up_to(shell, spectrum.last_frequency());
  const SpectrumResponse response(shell, modes, spectrum, of.direction, of.damping);
  const SpectrumField field(shell, response);
  report.spectrum = spectrum_report(scene, shell, response, field);
  visitor.visit_spectrum(*report.spectrum, field);
}

void find_modes(const Scene& scene, const ShellModel& shell, StressReport& report,
                StressVisitor& visitor) {
  const ShellModes modes = natural_modes(shell, scene.stress->modes);
  report.frequencies.assign(modes.frequencies.begin(), modes.frequencies.end());
  report.participation = modes.participation;
  report.mass = modes.mass;
  visitor.visit_modes(report.frequencies, modes.shapes);
}

bool is_free(const SceneStress& stress) {
  return stress.supports.empty() && !stress.inertia_relief;
}

// A failed check or a warning if the accuracy was not reached.
void check_accuracy(const RefinedShape& refined, const StressAccuracy& accuracy, RunReport& notes) {
  if (refined.converged) return;
  const auto check = [&](double error, const std::string& of) {
    if (error <= accuracy.value) return;
    if (accuracy.required)
      notes.failed_checks.push_back(
          {"stress.accuracy of " + of,
           "is " + format_number(error) + ", expected at most " + format_number(accuracy.value)});
    else
      notes.warnings.push_back("the estimated error of " + of + " is " +
                               format_number(std::round(1000 * error) / 10) + " %; --accuracy " +
                               format_number(accuracy.value) + " refines the elements further");
  };
  check(refined.meshes.back().error, "the displacements");
  check(refined.meshes.back().stress_error, "the largest stress");
}

}  // namespace

StressAccuracy stress_accuracy(const std::optional<double>& argument) {
  if (!argument) return {};
  if (!(*argument >= 0) || !std::isfinite(*argument))
    throw InputError("accuracy: found " + format_number(*argument) +
                     ", expected a relative error above 0, or 0 for no refinement");
  return {*argument, true};
}

RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape,
                               const StressAccuracy& accuracy, const BackendFactory& factors,
                               const Progress& progress) {
  RefinedShape result{shape};
  if (!shape.layout || accuracy.value == 0 || is_free(*scene.stress)) return result;
  ShellRefinementOptions options;
  options.accuracy = accuracy.value;
  options.backend_factory = factors;
  if (!accuracy.required) {
    constexpr long least = 100000;
    constexpr double times = 3;
    options.max_total_unknowns =
        std::max(least, static_cast<long>(times * 3 * static_cast<double>(shape.dofs.rows())));
  }
  const RefinedShell refined =
      refine_shell(shape.layout, shape.dofs, shell_problem(scene), options, progress);
  result.shell = refined.shell;
  result.converged = refined.converged;
  result.error_ratio = refined.error_ratio;
  result.singular_places = refined.singular_places;
  for (const RefinedShell::Mesh& mesh : refined.meshes)
    result.meshes.push_back({mesh.edge_length, mesh.unknowns, mesh.displacement, mesh.von_mises,
                             mesh.error, mesh.stress_error});
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

StressReport compute_stresses(const Scene& scene, const RefinedShape& refined,
                              const StressAccuracy& accuracy, const BackendFactory& factors,
                              RunReport& notes, StressVisitor& visitor, const Progress& progress) {
  progress.update("stress", 0);
  const SolvedShape& shape = refined.shape;
  const ShellProblem problem = shell_problem(scene);
  const ShellDefinition definition = problem.definition(*shape.layout, shape.dofs);
  const bool free = is_free(*scene.stress);
  using Handling = ShellModel::RigidBodyHandling;
  const std::shared_ptr<const ShellModel> model =
      refined.shell ? refined.shell
                    : std::make_shared<const ShellModel>(
                          *shape.layout, shape.dofs, definition,
                          free ? Handling::Shifted : Handling::Refused, factors);
  const ShellModel& shell = *model;
  visitor.visit_shell(shell);
  StressReport report = shell_report(*scene.stress, shell);
  report.meshes = refined.meshes;
  std::vector<ShellLoadCase> cases =
      free ? std::vector<ShellLoadCase>{}
           : problem.load_cases(*shape.layout, shape.dofs, definition);
  for (size_t c = 0; c < std::min(cases.size(), refined.singular_places.size()); ++c)
    cases[c].singular_places = refined.singular_places[c];
  // Modes up to twice the highest frequency; the static correction stands for the others.
  std::optional<ShellModes> vibration_modes;
  if (scene.stress->harmonic) vibration_modes = modes_up_to(shell, 2 * scene.stress->harmonic->to);
  const auto add = [&](const ShellCaseResult& result, const ShellStresses& stresses) {
    StressReport::Case c = case_report(*scene.stress, shell.layout(), result);
    const ShellLoadCase& load_case = cases[report.cases.size()];
    c.displacement_error *= refined.error_ratio;
    for (const SingularPlace& place : load_case.singular_places)
      c.singular_places.push_back({place.at, place.radius});
    estimate_limits(shell, load_case, result, stresses, c);
    c.results = requested_results(scene, shell, result, stresses);
    visitor.visit_case(c, result, stresses);
    constexpr double balanced = 1e-8;
    if (!(c.equilibrium_residual <= balanced))
      notes.failed_checks.push_back(
          {"stress.equilibrium_residual of " + c.name,
           "is " + format_number(c.equilibrium_residual) + ", expected at most 1e-8"});
    constexpr double little = 1e-3;
    if (result.tie_moment > little)
      notes.warnings.push_back(
          "case '" + c.name +
          "': the faces do not meet exactly: forces across the gaps between them "
          "have a moment of " +
          format_number(std::round(1000 * result.tie_moment) / 10) +
          " % of the moments on the shell; a smaller edge_length closes the gaps");
    if (scene.stress->buckling > 0)
      find_buckling(scene, shell, load_case, result.displacement, c, visitor);
    if (vibration_modes)
      find_vibrations(scene, shell, *vibration_modes, load_case, result, c, visitor);
    report.cases.push_back(std::move(c));
  };
  evaluate_load_cases(shell, cases, add, nullptr, progress);
  if (scene.stress->spectrum) find_spectrum_response(scene, shell, report, visitor);
  if (scene.stress->modes > 0) find_modes(scene, shell, report, visitor);
  warn(report, shell.layout().size(), scene.unit, notes.warnings);
  check_accuracy(refined, accuracy, notes);
  return report;
}

std::vector<StressReport::Sensitivity> compute_sensitivities(const StressReport& report,
                                                             const Scene& scene,
                                                             const BuiltModel& made,
                                                             const SolvedShape& shape,
                                                             const Progress& progress) {
  require_differentiable(scene);
  std::vector<ShellSensitivities::Goal> goals;
  const std::vector<std::string> names = scene.stress->cases();
  for (const StressReport::Case& c : report.cases)
    if (std::count(names.begin(), names.end(), c.name) && c.displacement > 0)
      goals.push_back({c.name, c.max_displacement_at, c.displacement_vector});
  const ShellSensitivities sensitivities(*shape.layout, shape.dofs, shell_problem(scene), goals);
  std::vector<StressReport::Sensitivity> found;
  for (const ShapeDerivative& of : shape_derivatives(scene, made, shape, progress)) {
    if (!(of.rate.cwiseAbs().maxCoeff() > 0)) continue;
    const auto derivatives = sensitivities.along(of.rate);
    for (size_t g = 0; g < goals.size(); ++g)
      found.push_back({of.parameter, goals[g].load_case, derivatives[g].displacement,
                       derivatives[g].compliance});
  }
  return found;
}

}  // namespace batten
