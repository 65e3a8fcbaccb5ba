// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_evaluator.h"

#include <algorithm>
#include <utility>

#include "batten/analysis/models/inertia_relief.h"
#include "batten/analysis/models/shell_modes.h"
#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"

namespace batten {

// Prepares the shell for a shape: its own system, or one that is similar to it.
void ShellEvaluator::update(const ModelLayout& layout, const Points& shape) {
  similar_.reset();
  reduction_.reset();
  shape_ = shape;
  definition_ = problem_.definition(layout, shape);
  if (shell_ && shell_->layout().mesh() == layout.mesh()) {
    similar_.reset(new ShellSystem(shell_->assemble_system(shape, definition_)));
    reduction_.emplace(similar_->ties.constraints);
    return;
  }
  displacements_.clear();
  shell_.reset();
  shell_.emplace(layout, shape, definition_);
}

// Factors the system of the current shape.
void ShellEvaluator::factor() {
  if (!similar_) return;
  similar_.reset();
  reduction_.reset();
  try {
    shell_->update_shape(shape_, definition_);
  } catch (...) {
    shell_.reset();  // without a valid factorization
    throw;
  }
}

Points ShellEvaluator::solve(const ShellLoadCase& load_case, size_t index) {
  if (similar_ && index < displacements_.size()) {
    if (auto q = shell_->solve(*similar_, *reduction_, load_case.load, displacements_[index]))
      return *q;
  }
  factor();
  return shell_->solve(load_case.load);
}

std::unique_ptr<const ShellEvaluator::Solved> ShellEvaluator::recovered(
    const std::string& name, const Points& displacement,
    const ShellTemperature& temperature) const {
  auto solved = std::make_unique<Solved>(Solved{name, displacement, temperature, nullptr});
  solved->stresses =
      std::make_unique<const ShellStresses>(assembler(), solved->displacement, solved->temperature);
  return solved;
}

ShellEvaluator::MaxValues ShellEvaluator::at(const ModelLayout& layout, const Points& shape,
                                             const Progress& progress) {
  const ProgressScope scope(progress);
  governing_.reset();
  update(layout, shape);
  const std::vector<ShellLoadCase> cases =
      problem_.load_cases(shell_->layout(), shape_, definition_);
  if (cases.empty()) throw InputError("found no load case, expected at least one");
  std::vector<Points> displacements;
  for (size_t i = 0; i < cases.size(); ++i) {
    update_progress("solving", static_cast<double>(i) / static_cast<double>(cases.size()));
    displacements.push_back(solve(cases[i], i));
  }
  displacements_ = std::move(displacements);
  std::optional<InertiaRelief> relief;
  if (definition_.inertia_relief)
    relief.emplace(shell_->layout(), shape_,
                   mass_matrix(shell_->layout(), shape_, definition_, assembler()));
  MaxValues largest;
  for (size_t i = 0; i < cases.size(); ++i) {
    const Points displacement =
        relief ? relief->without_rigid_motion(displacements_[i]) : displacements_[i];
    const Surface moved = shell_->layout().surface(displacement);
    largest.displacement =
        std::max(largest.displacement, max_displacement(assembler().surface(), moved).value);
    auto solved = recovered(cases[i].name, displacement, cases[i].temperature);
    const double peak = solved->stresses->peak().value;
    if (governing_ && !(peak > largest.von_mises)) continue;
    largest.von_mises = peak;
    governing_ = std::move(solved);
  }
  return largest;
}

void ShellEvaluator::require_shape() const {
  if (!governing_)
    throw InputError("found no shape of the shell, expected one that at() has evaluated");
}

ShellEvaluator::Field ShellEvaluator::field(const std::vector<Location>& locations,
                                            const Progress& progress) const {
  const ProgressScope scope(progress);
  require_shape();
  const Surface moved = shell_->layout().surface(governing_->displacement);
  Field field;
  field.load_case = governing_->name;
  field.von_mises.resize(locations.size());
  field.displacement.resize(3 * locations.size());
  parallel_for_each<256>(isize(locations), [&](int i) {
    const auto at = static_cast<size_t>(i);
    const ShellStress stress = governing_->stresses->at(locations[at]);
    field.von_mises[at] = static_cast<float>(stress.largest_von_mises().value);
    const Vec3 u = moved.position(locations[at]);
    for (size_t c = 0; c < 3; ++c)
      field.displacement[3 * at + c] = static_cast<float>(u[static_cast<long>(c)]);
  });
  return field;
}

ShellEvaluator::ModeShapes ShellEvaluator::mode_shapes(const std::vector<Location>& locations,
                                                       int count, const Progress& progress) {
  const ProgressScope scope(progress);
  require_shape();
  if (similar_) {
    // The stresses refer to the similar system.
    const auto before = std::move(governing_);
    factor();
    governing_ = recovered(before->name, before->displacement, before->temperature);
  }
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
