// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_modes.h"

#include <Spectra/SymGEigsSolver.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// Product y = Dᵀ (A + B) D x for a matrix A of one coordinate, applied to x, y and z, and a matrix B
// of all three, which may be empty.
class ReducedProduct {
 public:
  using Scalar = double;
  ReducedProduct(const AffineReduction& reduction, const SparseMatrix& A, const SparseMatrix& B)
      : D_(reduction.D()), A_(A), B_(B) {}
  Eigen::Index rows() const { return D_.cols(); }
  Eigen::Index cols() const { return D_.cols(); }
  void perform_op(const double* x, double* y) const {
    throw_if_cancelled();
    const VecX q = D_ * Eigen::Map<const VecX>(x, D_.cols());
    const Eigen::Map<const Points> points(q.data(), A_.rows(), 3);
    const Points forces = A_.selfadjointView<Eigen::Lower>() * points;
    VecX all = Eigen::Map<const VecX>(forces.data(), forces.size());
    if (B_.size() > 0) all += B_.selfadjointView<Eigen::Lower>() * q;
    Eigen::Map<VecX>(y, D_.cols()) = D_.transpose() * all;
  }

 private:
  const SparseMatrix &D_, &A_, &B_;
};

// Product y = DᵀKD x, and its inverse by the factor.
class ReducedStiffness {
 public:
  using Scalar = double;
  explicit ReducedStiffness(const ConstrainedSolver& solver) : solver_(solver) {}
  Eigen::Index rows() const { return solver_.reduction().free_count(); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    throw_if_cancelled();
    const SparseMatrix& D = solver_.reduction().D();
    const VecX q = D * Eigen::Map<const VecX>(x, rows());
    Eigen::Map<VecX>(y, rows()) = D.transpose() * (solver_.K().selfadjointView<Eigen::Lower>() * q);
  }
  void solve(const double* x, double* y) const {
    MatX b = Eigen::Map<const VecX>(x, rows());
    solver_.solve_reduced(b);
    Eigen::Map<VecX>(y, rows()) = b.col(0);
  }

 private:
  const ConstrainedSolver& solver_;
};

struct EigenPairs {
  VecX values;  // largest first
  std::vector<Points> vectors;
};

// Eigenpairs of (A + B) u = μ K u (ReducedProduct) with the largest μ, or with the largest
// magnitude. Empty if the iteration does not converge.
std::optional<EigenPairs> largest_eigenpairs(const ConstrainedSolver& solver, const SparseMatrix& A,
                                             const SparseMatrix& B, int count,
                                             Spectra::SortRule which, int restarts = 300) {
  const int n = solver.reduction().free_count();
  if (count < 1 || 2 * count >= n)
    throw InputError("found " + std::to_string(count) + " modes for " + std::to_string(n) +
                     " unknowns, expected 1 or more, and fewer than half of the unknowns");
  ReducedProduct product(solver.reduction(), A, B);
  ReducedStiffness stiffness(solver);
  // Additional dimensions for multiple eigenvalues, which occur on symmetric shells.
  const int krylov_dimension = std::min(n, 2 * count + 20);
  Spectra::SymGEigsSolver<ReducedProduct, ReducedStiffness, Spectra::GEigsMode::RegularInverse>
      lanczos(product, stiffness, count, krylov_dimension);
  lanczos.init();
  constexpr double tolerance = 1e-10;
  lanczos.compute(which, restarts, tolerance, Spectra::SortRule::LargestAlge);
  if (lanczos.info() != Spectra::CompInfo::Successful) return std::nullopt;
  EigenPairs pairs;
  pairs.values = lanczos.eigenvalues();
  const MatX vectors = lanczos.eigenvectors();
  for (long k = 0; k < vectors.cols(); ++k) {
    // Homogeneous part, without prescribed displacements.
    const VecX q = solver.reduction().D() * vectors.col(k);
    pairs.vectors.push_back(Eigen::Map<const Points>(q.data(), A.rows(), 3));
  }
  return pairs;
}

[[noreturn]] void throw_not_converged(int count) {
  throw NoSolutionError("the iteration for " + std::to_string(count) +
                        " modes did not converge; compute a few more modes");
}

}  // namespace

ShellModes natural_modes(const ShellModel& shell, int count) {
  for (int r = 0; r < shell.layout().region_count(); ++r)
    if (const double density = shell.section(r).density(); !(density > 0))
      throw InputError("natural frequencies need a density, found " + format_number(density));
  const SparseMatrix M = shell.mass();
  const auto found = largest_eigenpairs(shell.solver(), M, {},
                                        count + isize(shell.rigid_body_modes().unconstrained),
                                        Spectra::SortRule::LargestAlge);
  if (!found) throw_not_converged(count);
  const EigenPairs& pairs = *found;
  const VecX positions = shell.layout().position_dofs();
  const VecX nodal_mass = M.selfadjointView<Eigen::Lower>() * positions;
  ShellModes modes;
  modes.mass = positions.dot(nodal_mass);
  modes.rigid_body_count = isize(shell.rigid_body_modes().unconstrained);
  modes.frequencies.resize(pairs.values.size());
  for (long k = 0; k < pairs.values.size(); ++k) {
    const double square = 1 / pairs.values[k] - shell.shift();
    modes.frequencies[k] =
        k < modes.rigid_body_count ? 0 : std::sqrt(std::max(0.0, square)) / (2 * std::numbers::pi);
    const Points& u = pairs.vectors[k];
    const double mass = u.cwiseProduct(M.selfadjointView<Eigen::Lower>() * u).sum();
    modes.shapes.push_back(u / std::sqrt(mass));
    modes.participation.push_back(modes.shapes.back().transpose() * nodal_mass);
  }
  return modes;
}

namespace {

// Largest displacement of a vertex.
double largest_displacement(const VecX& positions, const Points& q) {
  double largest = 0;
  for (long m = 0; m < positions.size(); ++m)
    if (positions[m] > 0) largest = std::max(largest, q.row(m).norm());
  return largest;
}

// False for shells that only bend, such as flat plates under pressure: their membrane forces are
// rounding errors. `G`: geometric stiffness, whose entries are as large as the membrane forces.
bool has_membrane_forces(const ShellModel& shell, const Points& q, const SparseMatrix& G) {
  double stiffest = 0;
  for (int r = 0; r < shell.layout().region_count(); ++r)
    stiffest = std::max(stiffest, shell.section(r).membrane_stiffness());
  double force = 0;
  for (long k = 0; k < G.nonZeros(); ++k) force = std::max(force, std::abs(G.valuePtr()[k]));
  constexpr double rounding = 1e-12;  // strains of plates: 1e-15 of the slopes
  const double slope =
      largest_displacement(shell.layout().position_dofs(), q) / shell.layout().size();
  return force > rounding * stiffest * slope;
}

}  // namespace

ShellBuckling buckling(const ShellModel& shell, const Points& q, int count,
                       const SparseMatrix& follower, const ShellTemperature& temperature) {
  const SparseMatrix G = -shell.geometric_stiffness(q, temperature);
  if (!has_membrane_forces(shell, q, G)) return {};
  // If nothing buckles, the largest μ is 0 with infinitely many eigenvectors, and the iteration does
  // not converge. All eigenvalues that are not near 0 are then negative, which the search by
  // magnitude confirms.
  constexpr int few = 30;
  const auto largest = [&](Spectra::SortRule which, int restarts) {
    return largest_eigenpairs(shell.solver(), G, follower, count, which, restarts);
  };
  auto found = largest(Spectra::SortRule::LargestAlge, few);
  if (!found) {
    found = largest(Spectra::SortRule::LargestMagn, few);
    if (!found || found->values[0] > 0) found = largest(Spectra::SortRule::LargestAlge, 10 * few);
    if (!found) throw_not_converged(count);
  }
  const EigenPairs& pairs = *found;
  ShellBuckling result;
  const long positive = (pairs.values.array() > 0).count();
  result.factors = pairs.values.head(positive).cwiseInverse();
  const VecX positions = shell.layout().position_dofs();
  for (long k = 0; k < positive; ++k)
    result.shapes.push_back(pairs.vectors[k] / largest_displacement(positions, pairs.vectors[k]));
  return result;
}

}  // namespace batten
