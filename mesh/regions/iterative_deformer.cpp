// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/iterative_deformer.h"

#include <utility>

#include "batten/mesh/regions/local_global_solver.h"

namespace batten {
namespace {

DeformProblem handle_problem(std::vector<int> fixed, std::vector<Handle> handles) {
  DeformProblem problem;
  problem.fixed = std::move(fixed);
  problem.handles = std::move(handles);
  return problem;
}

}  // namespace

IterativeDeformer::IterativeDeformer(const TriangleMesh& mesh, std::vector<int> fixed,
                                     std::vector<Handle> handles, ArapEnergy energy,
                                     const std::string& name, int max_iterations, double tolerance)
    : solver_(std::make_unique<LocalGlobalSolver>(
          mesh, handle_problem(std::move(fixed), std::move(handles)), std::move(energy), name)),
      max_iterations_(max_iterations),
      tolerance_(tolerance) {}
IterativeDeformer::~IterativeDeformer() = default;
IterativeDeformer::IterativeDeformer(IterativeDeformer&&) noexcept = default;
IterativeDeformer& IterativeDeformer::operator=(IterativeDeformer&&) noexcept = default;

const Points& IterativeDeformer::deform(std::span<const HandleTransform> moves) {
  return solver_->deform(moves, nullptr, max_iterations_, tolerance_);
}
const Points& IterativeDeformer::deform(std::span<const HandleTransform> moves,
                                        const Points& guess) {
  return solver_->deform(moves, &guess, max_iterations_, tolerance_);
}
const Points& IterativeDeformer::positions() const { return solver_->positions(); }
const IterationReport& IterativeDeformer::report() const { return solver_->report(); }
const std::vector<Mat3>& IterativeDeformer::rotations() const { return solver_->rotations(); }

}  // namespace batten
