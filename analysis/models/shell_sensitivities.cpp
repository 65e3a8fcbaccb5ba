#include "batten/analysis/models/shell_sensitivities.h"

#include <algorithm>
#include <utility>

#include "batten/core/errors.h"

namespace batten {
namespace {

const Points& load_named(const std::vector<ShellLoadCase>& cases, const std::string& name) {
  const auto found = std::find_if(cases.begin(), cases.end(),
                                  [&](const ShellLoadCase& one) { return one.name == name; });
  if (found != cases.end()) return found->load;
  std::vector<std::string> names;
  for (const ShellLoadCase& one : cases) names.push_back(one.name);
  throw InputError("found no load case '" + name + "'" + did_you_mean(name, names));
}

}  // namespace

ShellSensitivities::ShellSensitivities(const ModelLayout& layout, const Points& shape,
                                       ShellProblem problem, const std::vector<Goal>& goals,
                                       double norm_exponent)
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
    solved.F = load_named(cases, goal.load_case);
    solved.u = shell_.solve(solved.F);
    solved.G =
        point_force(layout, nearest_location(layout, shape, goal.at), goal.direction.normalized());
    solved.adjoint_of_G = shell_.adjoint(solved.G);
    solved.adjoint_of_F = shell_.adjoint(solved.F);
    if (norm_exponent > 0) {
      solved.norm = von_mises_norm(shell_.assembler(), solved.u, norm_exponent);
      solved.adjoint_of_norm = shell_.adjoint(solved.norm.gradient);
    }
    goals_.push_back(std::move(solved));
  }
}

std::vector<ShellSensitivities::Quantities> ShellSensitivities::values() const {
  std::vector<Quantities> values;
  for (const SolvedGoal& g : goals_)
    values.push_back({g.G.cwiseProduct(g.u).sum(), g.F.cwiseProduct(g.u).sum(), g.norm.value});
  return values;
}

ShellSensitivities::Change ShellSensitivities::change_to(const Points& shape) const {
  ShellDefinition definition = problem_.definition(shell_.layout(), shape);
  ShellSystem system = shell_.assemble_system(shape, definition);
  // The boundary of a support may move across a vertex, which adds or removes constraints.
  if (system.ties.constraints.coupled_constraints().size() !=
      shell_.constraints().coupled_constraints().size()) {
    definition = shell_.definition();
    system = shell_.assemble_system(shape, definition);
  }
  auto cases = problem_.load_cases(shell_.layout(), shape, definition);
  return {std::move(system), std::move(cases)};
}

ShellSensitivities::Quantities ShellSensitivities::changes(const SolvedGoal& g,
                                                           const Change& change) const {
  const Points& load = load_named(change.cases, g.load_case);
  const auto goal_change = [&](const Points& a, const Points& G) {
    return shell_.goal_change(g.u, g.F, a, G, change.system, load);
  };
  Quantities changes{goal_change(g.adjoint_of_G, g.G), goal_change(g.adjoint_of_F, g.F), 0};
  // Of the work Fᵀu itself: its load is the goal, and varies too.
  changes.compliance += (load - g.F).cwiseProduct(g.u).sum();
  if (norm_exponent_ > 0)
    changes.von_mises_norm = goal_change(g.adjoint_of_norm, g.norm.gradient) +
                             von_mises_norm(change.system.assembler, g.u, norm_exponent_).value -
                             g.norm.value;
  return changes;
}

// A step that is small compared with the model, and large compared with rounding; 0: the rate is 0.
double ShellSensitivities::step_along(const Points& shape_rate) const {
  if (shape_rate.rows() != shell_.shape().rows())
    throw InputError("found a change of the shape with " + std::to_string(shape_rate.rows()) +
                     " dofs, expected " + std::to_string(shell_.shape().rows()) + " of the shell");
  constexpr double small = 1e-5;
  const double largest = shape_rate.cwiseAbs().maxCoeff();
  return largest > 0 ? small * shell_.layout().size() / largest : 0;
}

std::vector<ShellSensitivities::Quantities> ShellSensitivities::along(
    const Points& shape_rate) const {
  std::vector<Quantities> derivatives(goals_.size());
  const double step = step_along(shape_rate);
  if (step == 0) return derivatives;
  const Change up = change_to(shell_.shape() + step * shape_rate),
               down = change_to(shell_.shape() - step * shape_rate);
  for (size_t i = 0; i < goals_.size(); ++i) {
    const Quantities above = changes(goals_[i], up), below = changes(goals_[i], down);
    derivatives[i] = {(above.displacement - below.displacement) / (2 * step),
                      (above.compliance - below.compliance) / (2 * step),
                      (above.von_mises_norm - below.von_mises_norm) / (2 * step)};
  }
  return derivatives;
}

double ShellSensitivities::mass_along(const Points& shape_rate) const {
  const double step = step_along(shape_rate);
  if (step == 0) return 0;
  const auto mass_of = [&](const Points& shape) {
    return shell_mass(ShellAssembler(
        shell_.layout().surface(shape),
        triangle_sections(shell_.layout(), problem_.definition(shell_.layout(), shape))));
  };
  return (mass_of(shell_.shape() + step * shape_rate) -
          mass_of(shell_.shape() - step * shape_rate)) /
         (2 * step);
}

std::optional<Points> shape_derivative(const ShapeOfChange& shape_of, double step) {
  const auto up = shape_of(step), down = shape_of(-step);
  if (up && down) return Points((*up - *down) / (2 * step));
  if (!up && !down) return std::nullopt;
  const auto here = shape_of(0);
  if (!here) return std::nullopt;
  return up ? Points((*up - *here) / step) : Points((*here - *down) / step);
}

}  // namespace batten
