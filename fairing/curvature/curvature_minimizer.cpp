// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curvature/curvature_minimizer.h"

#include "batten/core/errors.h"

#if BATTEN_HAVE_CERES
#include <ceres/ceres.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "batten/core/containers.h"
#include "batten/elements/quadrature.h"
#endif

namespace batten {

#if BATTEN_HAVE_CERES

namespace {

// Quadrature points per segment; more points change no digit of the tested results.
constexpr int kGaussPoints = 8;

// Speeds start at 1. Steps beyond these bounds are rejected to avoid overflow.
bool sensible(double speed_squared) { return speed_squared > 1e-8 && speed_squared < 1e8; }

// Residuals of one segment with respect to the six blocks X, X', X'' of its ends.
class SegmentCost : public ceres::CostFunction {
 public:
  SegmentCost(const CurvatureMinimization& problem, int segment)
      : functional_(problem.functional),
        length_weight_(problem.length_weight),
        parametrization_weight_(problem.parametrization_weight) {
    const double h = problem.curve.length(segment);
    static const SegmentRule rule = gauss_legendre(kGaussPoints);
    for (long p = 0; p < rule.s.size(); ++p) {
      Point point;
      point.root_weight = std::sqrt(h * rule.weights[p]);
      for (int k = 0; k < 3; ++k) point.H.col(k) = quintic_functions(h, rule.s[p], k + 1);
      points_.push_back(point);
    }
    set_num_residuals(rows_each() * kGaussPoints);
    *mutable_parameter_block_sizes() = std::vector<int32_t>(6, 3);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    using Jet = ceres::Jet<double, 9>;  // value with derivatives with respect to X', X'', X'''
    using Jet3 = Eigen::Matrix<Jet, 3, 1>;
    for (size_t p = 0; p < points_.size(); ++p) {
      const Point& point = points_[p];
      Jet3 d[3];
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) {
          double value = 0;
          for (int b = 0; b < 6; ++b) value += point.H(b, k) * blocks[b][c];
          d[k][c] = Jet(value, 3 * k + c);
        }
      if (!sensible(d[0].dot(d[0]).a)) return false;
      const Jet3 root = curvature_root<Jet>(functional_, d[0], d[1], d[2]);
      Jet rows[5] = {root[0], root[1], root[2],
                     speed_change<Jet>(d[0], d[1]) * std::sqrt(parametrization_weight_), Jet(0.0)};
      if (length_weight_ > 0) rows[4] = sqrt(sqrt(d[0].dot(d[0]))) * std::sqrt(length_weight_);
      for (int r = 0; r < rows_each(); ++r) {
        const long row = static_cast<long>(p) * rows_each() + r;
        residuals[row] = point.root_weight * rows[r].a;
        if (!jacobians) continue;
        for (int b = 0; b < 6; ++b) {
          if (!jacobians[b]) continue;
          for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) sum += rows[r].v[3 * k + c] * point.H(b, k);
            jacobians[b][3 * row + c] = point.root_weight * sum;
          }
        }
      }
    }
    return true;
  }

 private:
  struct Point {
    double root_weight = 0;
    Eigen::Matrix<double, 6, 3> H;  // derivatives of the basis functions for X', X'', X'''
  };
  int rows_each() const { return length_weight_ > 0 ? 5 : 4; }

  CurveFunctional functional_;
  double length_weight_, parametrization_weight_;
  std::vector<Point> points_;
};

class SpringCost : public ceres::SizedCostFunction<3, 3, 3, 3, 3, 3, 3> {
 public:
  SpringCost(const CurvatureMinimization& problem, const CurvatureMinimization::Spring& spring)
      : H_(quintic_functions(problem.curve.length(spring.at.segment), spring.at.s)),
        spring_(spring) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Vec3 x = -spring_.point;
    for (int b = 0; b < 6; ++b) x += H_[b] * Eigen::Map<const Vec3>(blocks[b]);
    Eigen::Map<Vec3>{residuals} = spring_.S * x;
    for (int b = 0; jacobians && b < 6; ++b)
      if (jacobians[b])
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[b]} = H_[b] * spring_.S;
    return true;
  }

 private:
  Eigen::Matrix<double, 6, 1> H_;
  CurvatureMinimization::Spring spring_;
};

// Manifold of the positive multiples of a vector: x ⊕ δ = x (δ + √(1 + δ²)), for which no step
// overflows.
class Ray : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 1; }
  bool Plus(const double* x, const double* delta, double* moved) const override {
    const double d = delta[0], factor = d + std::sqrt(1 + d * d);
    Eigen::Map<Vec3>{moved} = factor * Eigen::Map<const Vec3>(x);
    return factor > 0;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Vec3>{jacobian} = Eigen::Map<const Vec3>(x);
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    const double factor = Eigen::Map<const Vec3>(y).norm() / Eigen::Map<const Vec3>(x).norm();
    delta[0] = 0.5 * (factor - 1 / factor);
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    const Eigen::Map<const Vec3> at(x);
    Eigen::Map<Vec3>{jacobian} = at / at.squaredNorm();
    return true;
  }
};

// The non-constant blocks of a problem, preconditioned by their Gauss-Newton matrix at x⁰: x = x⁰ ⊕
// L⁻ᵀ z with J⁰ᵀJ⁰ = L Lᵀ. In z this matrix is the identity. The true Hessian differs from it by a
// low-rank matrix plus small terms, which BFGS learns in a few steps.
class InGaussNewtonMetric : public ceres::FirstOrderFunction {
 public:
  explicit InGaussNewtonMetric(ceres::Problem& problem) : problem_(problem) {
    std::vector<double*> all;
    problem.GetParameterBlocks(&all);
    for (double* block : all) {
      if (problem.IsParameterBlockConstant(block)) continue;
      evaluate_.parameter_blocks.push_back(block);
      base_.push_back(Eigen::Map<const Vec3>(block));
    }
    ceres::CRSMatrix J;
    problem.Evaluate(evaluate_, nullptr, nullptr, nullptr, &J);
    const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor, int>> rows(
        J.num_rows, J.num_cols, static_cast<long>(J.values.size()), J.rows.data(), J.cols.data(),
        J.values.data());
    const SparseMatrix columns = rows;
    factor_.compute(SparseMatrix(columns.transpose() * columns));
    size_ = J.num_cols;
  }

  bool regular() const { return factor_.info() == Eigen::Success; }
  int NumParameters() const override { return size_; }

  bool move(const double* z) const {
    const VecX delta =
        factor_.permutationPinv() * VecX(factor_.matrixU().solve(Eigen::Map<const VecX>(z, size_)));
    long at = 0;
    for (size_t b = 0; b < base_.size(); ++b) {
      double* block = evaluate_.parameter_blocks[b];
      Eigen::Map<Vec3> x(block);
      const int size = problem_.ParameterBlockTangentSize(block);
      // On a ray the step is logarithmic, so that gradients are those of Ceres. A step to more than
      // a hundred times the speed is rejected.
      if (size == 1 && !(std::abs(delta[at]) < 5)) return false;
      if (size == 1)
        x = base_[b] * std::exp(delta[at]);
      else
        x = base_[b] + delta.segment<3>(at);
      at += size;
    }
    return delta.allFinite();
  }

  bool Evaluate(const double* z, double* cost, double* gradient) const override {
    std::vector<double> g;
    if (!move(z)) return false;
    if (!problem_.Evaluate(evaluate_, cost, nullptr, gradient ? &g : nullptr, nullptr))
      return false;
    if (gradient)
      Eigen::Map<VecX>(gradient, size_) = factor_.matrixL().solve(
          VecX(factor_.permutationP() * Eigen::Map<const VecX>(g.data(), size_)));
    return std::isfinite(*cost);
  }

 private:
  ceres::Problem& problem_;
  ceres::Problem::EvaluateOptions evaluate_;
  std::vector<Vec3> base_;
  Eigen::SimplicialLLT<SparseMatrix> factor_;
  int size_ = 0;
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// Adds residuals and constraints to `problem`; its parameter blocks are the rows of x.
void set_up(const CurvatureMinimization& given, RowMajor& x, ceres::Problem& problem) {
  const auto blocks = [&](int segment) {
    std::vector<double*> all;
    for (const int node : {segment, given.curve.node_after(segment)})
      for (int k = 0; k < 3; ++k) all.push_back(x.row(3L * node + k).data());
    return all;
  };
  for (int i = 0; i < given.curve.segment_count(); ++i)
    problem.AddResidualBlock(new SegmentCost(given, i), nullptr, blocks(i));
  for (const auto& spring : given.springs)
    problem.AddResidualBlock(new SpringCost(given, spring), nullptr, blocks(spring.at.segment));
  for (int node = 0; node < given.curve.node_count(); ++node) {
    if (given.fixed_position[node]) problem.SetParameterBlockConstant(x.row(3L * node).data());
    if (given.fixed_tangent[node]) problem.SetManifold(x.row(3L * node + 1).data(), new Ray);
  }
}

void solve_levenberg_marquardt(int max_iterations, ceres::Problem& problem,
                               CurvatureMinimizationResult& minimum) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-13;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  minimum.iterations = isize(summary.iterations);
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
}

// Continues with L-BFGS, from a point near the minimum.
void solve_bfgs(int max_iterations, ceres::Problem& problem, CurvatureMinimizationResult& minimum) {
  auto* metric = new InGaussNewtonMetric(problem);
  const ceres::GradientProblem in_metric(metric);  // takes ownership of `metric`
  if (!metric->regular()) return;
  ceres::GradientProblemSolver::Options descent;
  descent.line_search_direction_type = ceres::LBFGS;
  descent.max_lbfgs_rank = 100;
  descent.max_num_iterations = max_iterations;
  descent.function_tolerance = 1e-16;
  descent.gradient_tolerance = 1e-10;
  descent.parameter_tolerance = 1e-14;
  descent.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary found;
  VecX z = VecX::Zero(metric->NumParameters());
  ceres::Solve(descent, in_metric, z.data(), &found);
  metric->move(z.data());
  minimum.iterations += isize(found.iterations);
  minimum.converged = found.termination_type == ceres::CONVERGENCE;
}

}  // namespace

bool have_curvature_fairing() { return true; }

CurvatureMinimizationResult minimize(const CurvatureMinimization& given) {
  RowMajor x = given.curve.dofs();
  ceres::Problem problem;
  set_up(given, x, problem);
  // Levenberg-Marquardt converges well from far away. Close to a minimum with remaining curvature
  // it gains only a constant factor per step, and BFGS takes over.
  constexpr int least_squares_steps = 40;
  CurvatureMinimizationResult minimum;
  solve_levenberg_marquardt(std::min(least_squares_steps, given.max_iterations), problem, minimum);
  if (!minimum.converged && minimum.iterations < given.max_iterations)
    solve_bfgs(given.max_iterations - minimum.iterations, problem, minimum);
  minimum.dofs = x;
  return minimum;
}

#else

bool have_curvature_fairing() { return false; }

CurvatureMinimizationResult minimize(const CurvatureMinimization&) {
  throw InputError(
      "minimum-energy and minimum-variation curves need Ceres: build Batten with "
      "BATTEN_WITH_CERES");
}

#endif

}  // namespace batten
