#include "batten/mesh/regions/dual_laplacian_deformer.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/regions/dual_rows.h"

namespace batten {
namespace {

const DualLaplacianOptions& checked(const DualLaplacianOptions& options) {
  if (options.most_rounds < 1 || !(options.tolerance >= 0) || !(options.membrane > 0) ||
      !std::isfinite(options.membrane) || !(options.primal >= 0) || !std::isfinite(options.primal))
    throw InputError("options of the dual Laplacian: " + std::to_string(options.most_rounds) +
                     " rounds, tolerance " + number(options.tolerance) + ", membrane " +
                     number(options.membrane) + ", primal " + number(options.primal) +
                     ", expected 1 or more, 0 or more, above 0, 0 or more");
  return options;
}

DualRowOptions row_options(const DualLaplacianOptions& options) {
  return {options.border == DualLaplacianOptions::Border::EdgeMiddles,
          options.lengths == DualLaplacianOptions::Lengths::Fitted, options.membrane,
          options.primal};
}

}  // namespace

struct DualLaplacianDeformer::Data {
  DualLaplacianOptions options;
  TurningSolver solver;
};

DualLaplacianDeformer::DualLaplacianDeformer(const TriangleMesh& mesh,
                                             std::vector<std::vector<int>> faces,
                                             std::vector<int> fixed, std::vector<Handle> handles,
                                             const DualLaplacianOptions& options)
    : data_(new Data{checked(options),
                     TurningSolver(mesh, held_by(std::move(fixed), std::move(handles)),
                                   dual_rows(mesh, faces.empty() ? faces_of(mesh) : faces,
                                             row_options(options)),
                                   "the dual Laplacian")}) {}
DualLaplacianDeformer::~DualLaplacianDeformer() = default;
DualLaplacianDeformer::DualLaplacianDeformer(DualLaplacianDeformer&&) noexcept = default;
DualLaplacianDeformer& DualLaplacianDeformer::operator=(DualLaplacianDeformer&&) noexcept = default;

const Points& DualLaplacianDeformer::deform(std::span<const HandleMove> moves) {
  return data_->solver.deform(moves, nullptr, data_->options.most_rounds, data_->options.tolerance);
}
const Points& DualLaplacianDeformer::deform(std::span<const HandleMove> moves,
                                            const Points& guess) {
  return data_->solver.deform(moves, &guess, data_->options.most_rounds, data_->options.tolerance);
}
const Points& DualLaplacianDeformer::positions() const { return data_->solver.positions(); }
const EstimateReport& DualLaplacianDeformer::report() const { return data_->solver.report(); }
const std::vector<Mat3>& DualLaplacianDeformer::face_turns() const { return data_->solver.turns(); }

}  // namespace batten
