// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/constrained_solver.h"

#include <cmath>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"

namespace batten {

Points solve_constrained(const ConstraintSet& constraints, const SparseMatrix& K, const Points& F) {
  return ConstrainedSolver(constraints, K).solve(F);
}

ConstrainedSolver::ConstrainedSolver(const ConstraintSet& constraints, SparseMatrix K,
                                     const std::vector<int>& dof_order,
                                     std::unique_ptr<LinearSolverBackend> solver)
    : reduction_(constraints),
      dof_order_(dof_order),
      solver_(solver ? std::move(solver) : std::make_unique<SparseCholesky>()) {
  factor(K);
}

void ConstrainedSolver::solve_reduced(Eigen::Ref<MatX> b) const { solver_->solve_in_place(b); }

void ConstrainedSolver::update(const ConstraintSet& constraints, SparseMatrix K) {
  reduction_ = AffineReduction(constraints);
  factor(K);
}

void ConstrainedSolver::factor(SparseMatrix& K) {
  K_.swap(K);  // a move would copy: Eigen's sparse matrices cannot be moved
  const SparseMatrix reduced = reduction_.reduce(K_);
  if (!solver_->has_pattern_of(reduced))
    solver_->analyze(reduced, reduction_.choose_ordering(reduced, K_, dof_order_));
  if (!solver_->factorize(reduced)) throw NoSolutionError(solver_->message());
  fixed_part_ = reduction_.reduce_load(K_, Points::Zero(reduction_.dof_count(), 3));
}

Points ConstrainedSolver::solve(const Points& F) const {
  MatX load = fixed_part_;
  if (reduction_.coupled())
    load += reduction_.D().transpose() * Eigen::Map<const VecX>(F.data(), F.size());
  else
    load += reduction_.D().transpose() * F;
  // A coordinate without load and without prescribed values stays zero.
  std::vector<long> loaded;
  for (long c = 0; c < load.cols(); ++c)
    if (!load.col(c).isZero(0)) loaded.push_back(c);
  if (static_cast<long>(loaded.size()) == load.cols()) {
    solve_reduced(load);
    return reduction_.expand(load);
  }
  MatX y = MatX::Zero(load.rows(), load.cols());
  if (!loaded.empty()) {
    MatX part = load(Eigen::all, loaded);
    solve_reduced(part);
    y(Eigen::all, loaded) = part;
  }
  return reduction_.expand(y);
}

Points ConstrainedSolver::solve_refined(const Points& F) const {
  Points q = solve(F);
  if (K_.rows() != q.size())
    throw InputError("solve_refined() needs a stiffness matrix of the stacked dofs, 3n by 3n");
  using Long = long double;
  const Eigen::Map<const VecX> x(q.data(), q.size()), f(F.data(), F.size());
  Eigen::Matrix<Long, Eigen::Dynamic, 1> residual = f.cast<Long>();
  for (long j = 0; j < K_.cols(); ++j) {
    poll_every<8192>(j);
    for (SparseMatrix::InnerIterator it(K_, j); it; ++it) {
      const Long k = it.value();
      residual[it.row()] -= k * x[j];
      if (it.row() != j) residual[j] -= k * x[it.row()];
    }
  }
  MatX step = reduction_.D().transpose() * residual.cast<double>();
  solve_reduced(step);
  const VecX more = reduction_.D() * step;
  q += Eigen::Map<const Points>(more.data(), q.rows(), 3);
  return q;
}

std::optional<Points> ConstrainedSolver::solve_similar(const AffineReduction& reduction,
                                                       const SparseMatrix& K, const Points& F,
                                                       const Points& start, double tolerance,
                                                       int max_iterations) const {
  if (K.rows() != F.size() || start.rows() != F.rows())
    throw InputError("solve_similar() needs a stiffness matrix of the stacked dofs, 3n by 3n");
  if (reduction.free_dofs() != reduction_.free_dofs()) return std::nullopt;
  const auto times_K = [&K](const VecX& x) -> VecX {
    return K.selfadjointView<Eigen::Lower>() * x;
  };
  const auto precondition = [this](const VecX& r) {
    MatX z = r;
    solve_reduced(z);
    return VecX(z);
  };
  VecX y(reduction.D().cols());
  for (long f = 0; f < y.size(); ++f)
    y[f] = start.data()[reduction.free_dofs()[static_cast<size_t>(f)]];
  VecX x = reduction.D() * y + reduction.d0().col(0);
  const auto residual = [&]() -> VecX {
    return reduction.D().transpose() * (Eigen::Map<const VecX>(F.data(), F.size()) - times_K(x));
  };
  VecX r = residual(), z = precondition(r), direction = z;
  double rz = r.dot(z);
  bool confirmed = true;  // r is the residual of x, not only updated
  for (int iteration = 0;; ++iteration) {
    throw_if_cancelled();
    if (!std::isfinite(rz)) return std::nullopt;
    if (rz <= tolerance * tolerance) {
      if (confirmed) return Points(Eigen::Map<const Points>(x.data(), F.rows(), 3));
      r = residual();
      direction = z = precondition(r);
      rz = r.dot(z);
      confirmed = true;
      if (rz <= tolerance * tolerance) continue;
    }
    if (iteration >= max_iterations) return std::nullopt;
    const VecX step = reduction.D() * direction, K_step = times_K(step);
    const double curvature = step.dot(K_step);
    if (!(curvature > 0)) return std::nullopt;
    const double length = rz / curvature;
    x += length * step;
    r -= length * (reduction.D().transpose() * K_step);
    z = precondition(r);
    const double before = rz;
    rz = r.dot(z);
    direction = z + (rz / before) * direction;
    confirmed = false;
  }
}

namespace {

Points product(const SparseMatrix& A, const Points& x) {
  return A.selfadjointView<Eigen::Lower>() * x;
}

}  // namespace

ThetaIntegrator::ThetaIntegrator(const ConstraintSet& constraints, SparseMatrix K, SparseMatrix M,
                                 const Options& options)
    : reduction_(constraints),
      K_(std::move(K)),
      M_(std::move(M)),
      zero_matrix_(K_.rows(), K_.cols()),
      options_(options) {
  const auto& o = options_;
  for (const SparseMatrix* A : {&K_, &M_})
    if (A->rows() != constraints.dof_count() || A->cols() != constraints.dof_count())
      throw InputError("found a matrix of " + std::to_string(A->rows()) + " × " +
                       std::to_string(A->cols()) + ", expected " +
                       std::to_string(constraints.dof_count()) + " rows and columns");
  if (!(o.density >= 0) || !(o.damping >= 0) || !(o.density + o.damping > 0) ||
      !std::isfinite(o.density + o.damping))
    throw InputError("found density " + format_number(o.density) + " and damping " +
                     format_number(o.damping) + ", expected 0 or more, and not both 0");
  if (!(o.dt > 0) || !std::isfinite(o.dt))
    throw InputError("found the time step " + format_number(o.dt) + ", expected a number above 0");
  if (!(o.theta >= 0.5) || !(o.theta <= 1))
    throw InputError("found theta = " + format_number(o.theta) + ", expected 0.5 to 1");
  const double inertia = o.density / (o.theta * o.dt) + o.damping;
  const SparseMatrix A = inertia * M_ + (o.theta * o.dt) * K_;
  const SparseMatrix reduced = reduction_.reduce(A);
  cholesky_.analyze(reduced);
  if (!cholesky_.factorize(reduced)) throw NoSolutionError(cholesky_.message());
  x_ = reduction_.expand(MatX::Zero(reduced.rows(), reduction_.coupled() ? 1 : 3));
  v_ = Points::Zero(K_.rows(), 3);
}

void ThetaIntegrator::start(Points x, Points v) {
  if (x.rows() != K_.rows() || v.rows() != K_.rows())
    throw InputError("found " + std::to_string(x.rows()) + " positions and " +
                     std::to_string(v.rows()) + " velocities, expected " +
                     std::to_string(K_.rows()) + ", one for each dof");
  x_ = std::move(x);
  v_ = std::move(v);
}

const Points& ThetaIntegrator::step(const Points& F) {
  const auto& o = options_;
  const Points rhs = F - product(K_, x_) + o.density / (o.theta * o.dt) * product(M_, v_);
  const MatX y = cholesky_.solve(reduction_.reduce_load(zero_matrix_, rhs));
  const MatX dy = reduction_.D() * y;
  const Points v = Eigen::Map<const Points>(dy.data(), x_.rows(), 3);
  x_ += o.dt * v;
  v_ += (v - v_) / o.theta;
  return x_;
}

double ThetaIntegrator::kinetic() const {
  return 0.5 * options_.density * v_.cwiseProduct(product(M_, v_)).sum();
}

double ThetaIntegrator::potential(const Points& F) const {
  return x_.cwiseProduct(0.5 * product(K_, x_) - F).sum();
}

}  // namespace batten
