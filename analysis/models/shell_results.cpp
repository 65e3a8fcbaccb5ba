// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_results.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/analysis/models/inertia_relief.h"
#include "batten/analysis/models/triangle_maximum.h"
#include "batten/core/cancellation.h"
#include "batten/fem/surface.h"

namespace batten {
namespace {

// Visits vertices, edge midpoints and centroids inside the trim and, in cut triangles, points of the
// boundary and quadrature points of their inside.
template <class Visit>
void visit_sample_points(const Surface& surface, const Visit& visit) {
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<2048>(t);
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    if (!trim || trim->side(t) != Trim::Side::Cut) {
      for (int i = 0; i < 3; ++i) {
        visit(Location{t, Vec3::Unit(i)});
        visit(Location{t, 0.5 * (Vec3::Ones() - Vec3::Unit(i))});
      }
      visit(Location{t, Vec3::Constant(1.0 / 3)});
      continue;
    }
    const TriangleRule rule = trim->rule(t, 1);
    for (long p = 0; p < rule.weights.size(); ++p) visit(Location{t, rule.L.row(p).transpose()});
    for (const Vec3& L : trim->boundary_points(t)) visit(Location{t, L});
  }
}

void measure_balance(const ShellModel& shell, const Points& load, ShellCaseResult& result) {
  result.load = resultant(shell.layout(), shell.shape(), load);
  result.reactions = shell.reactions(result.displacement, load);
  Resultant sum = result.load;
  ForceMagnitudes size = magnitudes(shell.layout(), shell.shape(), load);
  for (const SupportReaction& r : result.reactions) {
    sum.force += r.resultant.force;
    sum.moment += r.resultant.moment;
    size.force += r.magnitudes.force;
    size.moment += r.magnitudes.moment;
  }
  const Resultant ties = shell.tie_resultant(result.displacement, load);
  sum.force += ties.force;
  sum.moment += ties.moment;
  sum.moment -= centre(shell.layout(), shell.shape()).cross(sum.force);
  const auto relative = [](const Vec3& a, double b) { return b > 0 ? a.norm() / b : 0.0; };
  result.equilibrium_residual =
      std::max(relative(sum.force, size.force), relative(sum.moment, size.moment));
  result.tie_moment = relative(ties.moment, size.moment);
  result.energy = shell.energy(result.displacement);
}

// Estimates the error of the largest displacement with its adjoint solution. Adds to `indicators`,
// if there are any, the contribution of each triangle to this error and to the energy error.
void estimate_displacement_error(const ShellModel& shell, const ShellStresses& stresses,
                                 MaxDisplacement& largest, VecX* indicators) {
  const auto add = [&](const VecX& parts) {
    const double sum = parts.cwiseAbs().sum();
    if (indicators && sum > 0) *indicators += parts.cwiseAbs() / sum;
    return std::abs(parts.sum());
  };
  if (indicators) add(stresses.goal_error_per_triangle(stresses));
  if (!(largest.value > 0)) return;
  const Vec3 direction = largest.vector / largest.value;
  const Points adjoint =
      shell.adjoint(point_force(shell.layout(), {{}, largest.where, 0}, direction));
  largest.error = add(stresses.goal_error_per_triangle(ShellStresses(shell, adjoint)));
}

void measure_stress(const ShellModel& shell, const ShellLoadCase& load_case,
                    const ShellStresses& stresses, ShellCaseResult& result) {
  const Surface& surface = shell.assembler().surface();
  const ShellStresses::Peak peak = load_case.singular_places.empty()
                                       ? stresses.peak()
                                       : stresses.largest_outside(load_case.singular_places);
  result.max_stress = peak;
  const double middle = shell.assembler().section(peak.where.triangle).offset;
  result.max_stress_point = peak.at + (middle + 0.5 * peak.height) *
                                          stresses.at(peak.where).thickness *
                                          surface.jet(peak.where).normal();
  result.tsai_hill = stresses.smallest_reserve_factor(FailureCriterion::TsaiHill);
  result.hoffman = stresses.smallest_reserve_factor(FailureCriterion::Hoffman);
  result.energy_norm_error = stresses.energy_norm_error();
  result.near_singularity =
      singular_point_near(shell, load_case, load_case.singular_places, peak).has_value();
}

}  // namespace

double triangle_edge_length(const Surface& surface, int triangle) {
  const double area = surface.mesh().shape(triangle).area *
                      surface.jet({triangle, Vec3::Constant(1.0 / 3)}).area_vector().norm();
  return std::sqrt(2 * area);
}

std::optional<Vec3> singular_point_near(const ShellModel& shell, const ShellLoadCase& load_case,
                                        const std::vector<SingularPlace>& known,
                                        const ShellStresses::Peak& peak) {
  const Surface& surface = shell.assembler().surface();
  constexpr double near = 3;  // in edge lengths
  const double reach = near * triangle_edge_length(surface, peak.where.triangle);
  std::optional<Vec3> nearest;
  const auto look = [&](const Vec3& p) {
    const bool is_known = std::any_of(
        known.begin(), known.end(), [&](const SingularPlace& place) { return place.contains(p); });
    const double distance = (p - peak.at).norm();
    if (!is_known && distance < reach && !(nearest && distance >= (*nearest - peak.at).norm()))
      nearest = p;
  };
  for (const Vec3& p : load_case.singular_points) look(p);
  for (const PointSupport& support : shell.definition().points)
    look(surface.position(support.position.where));
  return nearest;
}

MaxDisplacement max_displacement(const Surface& surface, const Surface& moved) {
  MaxDisplacement largest;
  const auto value = [&](const Location& where) { return moved.position(where).norm(); };
  LargestSamples samples;
  visit_sample_points(surface, [&](const Location& where) { samples.take(where, value(where)); });
  if (samples.empty()) return largest;
  const Trim* trim = surface.trim().get();
  constexpr double accuracy = 1e-7;
  largest.where = samples.climb(
      accuracy, value, [&](int t) { return !trim || trim->side(t) == Trim::Side::Inside; });
  largest.vector = moved.position(largest.where);
  largest.value = largest.vector.norm();
  largest.at = surface.position(largest.where);
  return largest;
}

std::vector<ShellCaseResult> evaluate_load_cases(const ShellModel& shell,
                                                 const std::vector<ShellLoadCase>& cases,
                                                 const ShellCaseVisitor& visit,
                                                 VecX* error_indicators, const Progress& progress) {
  const ProgressScope scope(progress);
  if (error_indicators) *error_indicators = VecX::Zero(shell.layout().mesh()->triangle_count());
  std::optional<InertiaRelief> relief;
  if (shell.definition().inertia_relief)
    relief.emplace(shell.layout(), shell.shape(), shell.mass());
  std::vector<ShellCaseResult> results;
  for (const ShellLoadCase& one : cases) {
    progress.update("stress of " + one.name, 0);
    ShellCaseResult& result = results.emplace_back();
    result.name = one.name;
    result.temperature = one.temperature;
    result.displacement = shell.solve(one.load);
    if (relief) result.displacement = relief->without_rigid_motion(result.displacement);
    measure_balance(shell, one.load, result);
    result.max_displacement =
        max_displacement(shell.assembler().surface(), shell.layout().surface(result.displacement));
    const ShellStresses stresses(shell, result.displacement, one.temperature);
    if (!one.temperature.empty())
      result.energy =
          stresses.energy() + shell.stiffeners().energy(result.displacement, one.temperature);
    result.stiffeners = shell.stiffeners().results(result.displacement, one.temperature);
    estimate_displacement_error(shell, stresses, result.max_displacement, error_indicators);
    measure_stress(shell, one, stresses, result);
    if (visit) visit(result, stresses);
  }
  return results;
}

ThinShellRatios thin_shell_ratios(const ShellModel& shell) {
  ThinShellRatios ratios;
  const Surface& surface = shell.assembler().surface();
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const Curvatures bend = curvatures(surface.jet({t, Vec3::Constant(1.0 / 3)}));
    const double k = std::max(std::abs(bend.k1), std::abs(bend.k2));
    const double thickness = shell.assembler().section(t).thickness;
    ratios.thickness_over_radius = std::max(ratios.thickness_over_radius, thickness * k);
    ratios.edge_over_boundary_layer =
        std::max(ratios.edge_over_boundary_layer,
                 triangle_edge_length(surface, t) * std::sqrt(k / thickness));
  }
  return ratios;
}

}  // namespace batten
