#include "batten/analysis/models/shell_evaluator.h"

#include <algorithm>
#include <utility>

#include "batten/analysis/models/shell_modes.h"
#include "batten/core/cancellation.h"
#include "batten/core/errors.h"

namespace batten {

ShellEvaluator::MaxValues ShellEvaluator::at(const ModelLayout& layout, const Points& shape,
                                             const Progress& progress) {
  const ProgressScope scope(progress);
  displacement_.resize(0, 3);
  if (shell_ && shell_->layout().mesh() == layout.mesh())
    shell_->update_shape(shape);
  else
    shell_.emplace(layout, shape, problem_.definition(layout, shape));
  const std::vector<ShellLoadCase> cases =
      problem_.load_cases(shell_->layout(), shell_->shape(), shell_->definition());
  if (cases.empty()) throw InputError("found no load case, expected at least one");
  MaxValues largest;
  Points governing;
  for (const ShellLoadCase& one : cases) {
    update_progress("solving", static_cast<double>(&one - cases.data()) /
                                   static_cast<double>(cases.size()));
    Points q = shell_->solve(one.load);
    largest.displacement = std::max(largest.displacement, max_displacement(*shell_, q).value);
    const double peak = ShellStresses(*shell_, q).peak().value;
    if (governing.size() > 0 && peak < largest.von_mises) continue;
    largest.von_mises = peak;
    governing_case_ = one.name;
    governing = std::move(q);
  }
  displacement_ = std::move(governing);
  return largest;
}

void ShellEvaluator::require_shape() const {
  if (displacement_.size() == 0)
    throw InputError("found no shape of the shell, expected one that at() has evaluated");
}

ShellEvaluator::Field ShellEvaluator::field(const std::vector<Location>& locations,
                                            const Progress& progress) const {
  const ProgressScope scope(progress);
  require_shape();
  const ShellStresses stresses(*shell_, displacement_);
  const Surface moved = shell_->layout().surface(displacement_);
  Field field;
  field.load_case = governing_case_;
  for (const Location& where : locations) {
    poll_every<1024>(&where - locations.data());
    const ShellStress stress = stresses.at(where);
    const Vec3 u = moved.position(where);
    field.von_mises.push_back(
        static_cast<float>(std::max(von_mises(stress.at(1)), von_mises(stress.at(-1)))));
    for (const double x : u) field.displacement.push_back(static_cast<float>(x));
  }
  return field;
}

ShellEvaluator::ModeShapes ShellEvaluator::mode_shapes(const std::vector<Location>& locations,
                                                       int count,
                                                       const Progress& progress) const {
  const ProgressScope scope(progress);
  require_shape();
  const ShellModes modes = natural_modes(*shell_, std::min(count, shell_->unknowns() / 2 - 1));
  ModeShapes mode_shapes;
  for (size_t m = 0; m < modes.shapes.size(); ++m) {
    const Surface shape = shell_->layout().surface(modes.shapes[m]);
    std::vector<float> moved;
    double largest = 0;
    for (const Location& where : locations) {
      poll_every<4096>(&where - locations.data());
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

}  // namespace batten
