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
                                       ShellProblem problem, const std::vector<Goal>& goals)
    : problem_(std::move(problem)), shell_(layout, shape, problem_.definition(layout, shape)) {
  const std::vector<ShellLoadCase> cases = load_cases(shape);
  for (const Goal& goal : goals) {
    if (!(goal.direction.norm() > 0))
      throw InputError("load case '" + goal.load_case +
                       "': found a direction of length 0, expected one above 0");
    const Points& F = load_named(cases, goal.load_case);
    const ShellLocation position = nearest_location(layout, shape, goal.at);
    const Points G = point_force(layout, position, goal.direction.normalized());
    goals_.push_back({goal.load_case, F, shell_.solve(F), G, shell_.adjoint(G), shell_.adjoint(F)});
  }
}

std::vector<ShellLoadCase> ShellSensitivities::load_cases(const Points& shape) const {
  return problem_.load_cases(shell_.layout(), shape, shell_.definition());
}

std::vector<ShellSensitivities::Derivatives> ShellSensitivities::along(
    const Points& shape_rate) const {
  if (shape_rate.rows() != shell_.shape().rows())
    throw InputError("found a change of the shape with " + std::to_string(shape_rate.rows()) +
                     " dofs, expected " + std::to_string(shell_.shape().rows()) + " of the shell");
  std::vector<Derivatives> derivatives;
  const double largest = shape_rate.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return std::vector<Derivatives>(goals_.size());
  // A step that is small compared with the model, and large compared with rounding.
  const double step = 1e-5 * shell_.layout().size() / largest;
  const Points up = shell_.shape() + step * shape_rate, down = shell_.shape() - step * shape_rate;
  const auto up_cases = load_cases(up), down_cases = load_cases(down);
  const ShellSystem up_system = shell_.assemble_system(up),
                    down_system = shell_.assemble_system(down);
  for (const SolvedGoal& g : goals_) {
    const Points &up_load = load_named(up_cases, g.load_case),
                 &down_load = load_named(down_cases, g.load_case);
    const auto derivative = [&](const Points& a, const Points& G) {
      return (shell_.goal_change(g.u, g.F, a, G, up_system, up_load) -
              shell_.goal_change(g.u, g.F, a, G, down_system, down_load)) /
             (2 * step);
    };
    // Of the work Fᵀu itself: its load is the goal, and varies too.
    const double work = derivative(g.adjoint_of_F, g.F) +
                        (up_load - down_load).cwiseProduct(g.u).sum() / (2 * step);
    derivatives.push_back({derivative(g.adjoint_of_G, g.G), work});
  }
  return derivatives;
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
