#include "batten/constraints/theta_integrator.h"

#include <cmath>

#include "batten/core/errors.h"

namespace batten {
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
      throw InputError("a matrix of " + std::to_string(A->rows()) + " × " +
                       std::to_string(A->cols()) + " for " +
                       std::to_string(constraints.dof_count()) + " dofs");
  if (!(o.density >= 0) || !(o.damping >= 0) || !(o.density + o.damping > 0) ||
      !std::isfinite(o.density + o.damping))
    throw InputError("density " + format_number(o.density) + " and damping " +
                     format_number(o.damping) + ": expected both 0 or more, and not both 0");
  if (!(o.dt > 0) || !std::isfinite(o.dt))
    throw InputError("a time step of " + format_number(o.dt) + ": expected one above 0");
  if (!(o.theta >= 0.5) || !(o.theta <= 1))
    throw InputError("theta = " + format_number(o.theta) + ": expected 0.5 to 1");
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
    throw InputError("a motion of " + std::to_string(K_.rows()) + " dofs started with " +
                     std::to_string(x.rows()) + " positions and " + std::to_string(v.rows()) +
                     " velocities");
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
  return options_.density * v_.cwiseProduct(product(M_, v_)).sum();
}

double ThetaIntegrator::potential(const Points& F) const {
  return x_.cwiseProduct(product(K_, x_) - 2 * F).sum();
}

}  // namespace batten
