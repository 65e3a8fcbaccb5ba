#include "batten/apps/commands/shapes/stress_sensitivity.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "batten/apps/commands/shapes/stress_setup.h"

namespace batten {
namespace {

// A case with its goal: 1 at the place of its largest displacement, along it.
struct Goal {
  const StressReport::Case& of;
  Points F, u, G;
  Points of_G, of_F;  // adjoints
};

double step_of(const Parameter& p) {
  constexpr double fraction = 1e-3;
  const double range = p.max - p.min;
  return fraction * (std::isfinite(range) && range > 0 ? range : std::max(std::abs(p.value), 1.0));
}

// The scene with a parameter moved, or none where it may not be.
std::optional<Scene> moved(const Scene& scene, const Parameter& p, double by) {
  try {
    Scene other = scene;
    other.set(p.name, p.value + by, "");
    return other;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// The derivative of the shape's dofs, from both sides where the parameter may go there.
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
    // A step of the shape that is small against the model, and large against rounding.
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
      // Of the work Fᵀu itself: its own load is the goal, and changes too.
      const double work =
          derivative(g.of_F, g.F) +
          (up_loads.at(g.of.name) - down_loads.at(g.of.name)).cwiseProduct(g.u).sum() / (2 * step);
      run.report.stress->sensitivities.push_back(
          {p.name, g.of.name, derivative(g.of_G, g.G), work});
    }
  }
  run.watch.lap("sensitivities");
}

}  // namespace batten
