#include "batten/mesh/regions/dual_laplacian_deformer.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/regions/dual_laplacian_energy.h"

namespace batten {
namespace {

const DualLaplacianOptions& checked(const DualLaplacianOptions& options) {
  if (options.max_iterations < 1 || !(options.tolerance >= 0) || !(options.membrane > 0) ||
      !std::isfinite(options.membrane) || !(options.checkerboard_penalty >= 0) ||
      !std::isfinite(options.checkerboard_penalty))
    throw InputError("options of the dual Laplacian: " + std::to_string(options.max_iterations) +
                     " rounds, tolerance " + format_number(options.tolerance) + ", membrane " +
                     format_number(options.membrane) + ", primal " +
                     format_number(options.checkerboard_penalty) +
                     ", expected 1 or more, 0 or more, above 0, 0 or more");
  return options;
}

DualLaplacianEnergyOptions row_options(const DualLaplacianOptions& options) {
  return {options.border == DualLaplacianOptions::Border::EdgeMidpoints,
          options.lengths == DualLaplacianOptions::Lengths::Fitted, options.membrane,
          options.checkerboard_penalty};
}

}  // namespace

struct DualLaplacianDeformer::Data {
  DualLaplacianOptions options;
  LocalGlobalSolver solver;
};

DualLaplacianDeformer::DualLaplacianDeformer(const TriangleMesh& mesh,
                                             std::vector<std::vector<int>> faces,
                                             std::vector<int> fixed, std::vector<Handle> handles,
                                             const DualLaplacianOptions& options)
    : data_(new Data{
          checked(options),
          LocalGlobalSolver(mesh, handle_problem(std::move(fixed), std::move(handles)),
                            dual_laplacian_energy(mesh, faces.empty() ? faces_of(mesh) : faces,
                                                  row_options(options)),
                            "the dual Laplacian")}) {}
DualLaplacianDeformer::~DualLaplacianDeformer() = default;
DualLaplacianDeformer::DualLaplacianDeformer(DualLaplacianDeformer&&) noexcept = default;
DualLaplacianDeformer& DualLaplacianDeformer::operator=(DualLaplacianDeformer&&) noexcept = default;

const Points& DualLaplacianDeformer::deform(std::span<const HandleTransform> moves) {
  return data_->solver.deform(moves, nullptr, data_->options.max_iterations,
                              data_->options.tolerance);
}
const Points& DualLaplacianDeformer::deform(std::span<const HandleTransform> moves,
                                            const Points& guess) {
  return data_->solver.deform(moves, &guess, data_->options.max_iterations,
                              data_->options.tolerance);
}
const Points& DualLaplacianDeformer::positions() const { return data_->solver.positions(); }
const IterationReport& DualLaplacianDeformer::report() const { return data_->solver.report(); }
const std::vector<Mat3>& DualLaplacianDeformer::face_rotations() const {
  return data_->solver.rotations();
}

}  // namespace batten
