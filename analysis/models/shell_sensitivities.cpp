// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_sensitivities.h"

#include <algorithm>
#include <utility>

#include "batten/core/errors.h"

namespace batten {
namespace {

const ShellLoadCase& case_named(const std::vector<ShellLoadCase>& cases, const std::string& name) {
  const auto found = std::find_if(cases.begin(), cases.end(),
                                  [&](const ShellLoadCase& one) { return one.name == name; });
  if (found != cases.end()) return *found;
  std::vector<std::string> names;
  for (const ShellLoadCase& one : cases) names.push_back(one.name);
  throw InputError("found no load case '" + name + "'" + did_you_mean(name, names));
}

}  // namespace

ShellSensitivities::ShellSensitivities(const ModelLayout& layout, const Points& shape,
                                       ShellProblem problem, const std::vector<Goal>& goals,
                                       std::optional<double> norm_exponent)
    : problem_(std::move(problem)),
      shell_(layout, shape, problem_.definition(layout, shape)),
      norm_exponent_(norm_exponent) {
  const std::vector<ShellLoadCase> cases =
      problem_.load_cases(shell_.layout(), shape, shell_.definition());
  for (const Goal& goal : goals) {
    if (!(goal.direction.norm() > 0))
      throw InputError("load case '" + goal.load_case +
                       "': found a direction of length 0, expected one above 0");
    SolvedGoal solved;
    solved.load_case = goal.load_case;
    const ShellLoadCase& load_case = case_named(cases, goal.load_case);
    solved.F = load_case.load;
    solved.u = shell_.solve(solved.F);
    solved.G =
        point_force(layout, nearest_location(layout, shape, goal.at), goal.direction.normalized());
    solved.adjoint_of_G = shell_.adjoint(solved.G);
    solved.adjoint_of_F = shell_.adjoint(solved.F);
    if (norm_exponent) {
      solved.norm =
          von_mises_norm(shell_.assembler(), solved.u, *norm_exponent, load_case.temperature);
      solved.adjoint_of_norm = shell_.adjoint(solved.norm.gradient);
    }
    goals_.push_back(std::move(solved));
  }
}

std::vector<ShellSensitivities::Quantities> ShellSensitivities::values() const {
  std::vector<Quantities> values;
  const double mass = shell_mass(shell_.assembler()) +
                      added_mass(shell_.layout(), shell_.shape(), shell_.definition());
  for (const SolvedGoal& g : goals_)
    values.push_back(
        {g.G.cwiseProduct(g.u).sum(), g.F.cwiseProduct(g.u).sum(), g.norm.value, mass});
  return values;
}

ShellSensitivities::Change ShellSensitivities::change_to(const Points& shape, bool follows) const {
  const ShellDefinition definition =
      follows ? problem_.definition(shell_.layout(), shape) : shell_.definition();
  return {shell_.assemble_system(shape, definition),
          problem_.load_cases(shell_.layout(), shape, definition),
          added_mass(shell_.layout(), shape, definition)};
}

std::array<ShellSensitivities::Change, 2> ShellSensitivities::changes_along(
    const Points& step) const {
  const auto same_rows = [this](const Change& change) {
    const ConstraintSet &own = shell_.constraints(), &other = change.system.ties.constraints;
    return own.constraints().size() == other.constraints().size() &&
           own.coupled_constraints().size() == other.coupled_constraints().size();
  };
  std::array<Change, 2> both = {change_to(shell_.shape() + step, true),
                                change_to(shell_.shape() - step, true)};
  // The border of a support may move across a vertex, which adds or removes constraints.
  if (!same_rows(both[0]) || !same_rows(both[1]))
    both = {change_to(shell_.shape() + step, false), change_to(shell_.shape() - step, false)};
  return both;
}

ShellSensitivities::Quantities ShellSensitivities::changes(const SolvedGoal& g,
                                                           const Change& change) const {
  const ShellLoadCase& load_case = case_named(change.cases, g.load_case);
  const Points& load = load_case.load;
  const auto goal_change = [&](const Points& a, const Points& G) {
    return shell_.goal_change(g.u, g.F, a, G, change.system, load);
  };
  Quantities changes{goal_change(g.adjoint_of_G, g.G), goal_change(g.adjoint_of_F, g.F), 0, 0};
  // Of the work Fᵀu itself: its load is the goal, and varies too.
  changes.compliance += (load - g.F).cwiseProduct(g.u).sum();
  if (norm_exponent_)
    changes.von_mises_norm =
        goal_change(g.adjoint_of_norm, g.norm.gradient) +
        von_mises_norm(change.system.assembler, g.u, *norm_exponent_, load_case.temperature).value -
        g.norm.value;
  return changes;
}

std::vector<ShellSensitivities::Quantities> ShellSensitivities::along(
    const Points& shape_rate) const {
  if (shape_rate.rows() != shell_.shape().rows())
    throw InputError("found a change of the shape with " + std::to_string(shape_rate.rows()) +
                     " dofs, expected " + std::to_string(shell_.shape().rows()) + " of the shell");
  if (!shape_rate.allFinite())
    throw InputError("found a change of the shape that is not finite, expected finite dofs");
  std::vector<Quantities> derivatives(goals_.size());
  const double largest = shape_rate.cwiseAbs().maxCoeff();
  if (largest == 0) return derivatives;
  // A step that is small compared with the model and the thickness, and large compared with
  // rounding.
  constexpr double of_size = 1e-5, of_thickness = 0.1;
  double most = of_size * shell_.layout().size();
  for (const ShellSection& section : shell_.definition().sections)
    most = std::min(most, of_thickness * section.thickness);
  const double step = most / largest;
  const auto [up, down] = changes_along(step * shape_rate);
  const double mass = mass_of(up) - mass_of(down);
  for (size_t i = 0; i < goals_.size(); ++i) {
    const Quantities above = changes(goals_[i], up), below = changes(goals_[i], down);
    derivatives[i] = {(above.displacement - below.displacement) / (2 * step),
                      (above.compliance - below.compliance) / (2 * step),
                      (above.von_mises_norm - below.von_mises_norm) / (2 * step),
                      mass / (2 * step)};
  }
  return derivatives;
}

}  // namespace batten
