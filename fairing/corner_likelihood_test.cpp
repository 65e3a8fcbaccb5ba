#include "batten/fairing/corner_likelihood_test.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/format.h"

namespace batten {
namespace {

// Takes from a column its parts along orthonormal ones, and gives it length 1.
void orthonormalize(const Eigen::Ref<const MatX>& Q, Eigen::Ref<VecX> column) {
  for (long k = 0; k < Q.cols(); ++k) column -= Q.col(k).dot(column) * Q.col(k);
  const double size = column.norm();
  if (size > 0) column /= size;
}

}  // namespace

const CornerLikelihoodTest::Shape& CornerLikelihoodTest::shape(int count, int corner, int degree) {
  const auto [found, added] = shapes_.try_emplace({count, corner, degree});
  Shape& s = found->second;
  if (!added) return s;
  const bool arms = corner >= 0;
  const int columns = arms ? 1 + 2 * degree : 1 + degree;
  s.values = MatX::Zero(count, columns);
  s.slopes = MatX::Zero(count, columns);
  for (int i = 0; i < count; ++i) {
    const double x = (arms ? i - corner : i - 0.5 * (count - 1)) / (0.5 * count);
    s.values(i, 0) = 1;
    double power = 1;
    for (int d = 1; d <= degree; ++d) {
      const int column = arms && i > corner ? degree + d : d;
      s.slopes(i, column) = d * power;
      power *= x;
      s.values(i, column) = power;
    }
  }
  // Six columns over [-1, 1] at most: their squares keep enough digits.
  s.inverse = MatX(s.values.transpose().lazyProduct(s.values))
                  .ldlt()
                  .solve(s.values.transpose())
                  .transpose();
  return s;
}

CornerLikelihoodTest::Fit CornerLikelihoodTest::fit(const Shape& shape, const Points& points,
                                                    double noise) {
  Fit fit;
  fit.coefficients.resize(shape.values.cols(), 3);
  Points off = points, velocity = Points::Zero(points.rows(), 3);
  // By columns: Eigen's kernels for large products would take longer to begin than these take.
  for (long c = 0; c < shape.values.cols(); ++c)
    for (int k = 0; k < 3; ++k) {
      const double x = shape.inverse.col(c).dot(points.col(k));
      fit.coefficients(c, k) = x;
      off.col(k) -= x * shape.values.col(c);
      velocity.col(k) += x * shape.slopes.col(c);
    }
  for (long i = 0; i < points.rows(); ++i) {
    const double along = velocity.row(i).squaredNorm();
    const double part = along > 0 ? std::pow(off.row(i).dot(velocity.row(i)), 2) / along : 0;
    fit.chi += (off.row(i).squaredNorm() - part) / (noise * noise);
    fit.along += part / (noise * noise);
  }
  return fit;
}

const MatX& CornerLikelihoodTest::kinks(int count, int corner, int degree) {
  const auto [found, added] = kinks_.try_emplace({count, corner, degree});
  MatX& H = found->second;
  if (!added) return H;
  const int highest = std::min(2 * degree + 1, count - 2);
  const auto [known, is_new] = polynomials_.try_emplace(count);
  MatX& Q = known->second;
  if (is_new) {
    Q.resize(count, std::min(6, count - 1));
    for (int i = 0; i < count; ++i) {
      double power = 1;
      for (long d = 0; d < Q.cols(); ++d) {
        Q(i, d) = power;
        power *= (i - 0.5 * (count - 1)) / (0.5 * count);
      }
    }
    for (long d = 0; d < Q.cols(); ++d) orthonormalize(Q.leftCols(d), Q.col(d));
  }
  H.resize(count, degree);
  for (int i = 0; i < count; ++i) {
    const double x = (i - corner) / (0.5 * count);
    H(i, 0) = std::abs(x);
    if (degree == 2) H(i, 1) = x * std::abs(x);
  }
  for (int d = 0; d < degree; ++d) {
    orthonormalize(Q.leftCols(highest + 1), H.col(d));
    orthonormalize(H.leftCols(d), H.col(d));
  }
  return H;
}

double CornerLikelihoodTest::max_gain(const Points& points, int corner, int degree, double noise) {
  const MatX& H = kinks(static_cast<int>(points.rows()), corner, degree);
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < degree; ++d) sum += std::pow(H.col(d).dot(points.col(k)), 2);
  return sum / (noise * noise);
}

double CornerLikelihoodTest::gain(const Points& points, int corner, double noise, double least_turn,
                                  double least) {
  const auto count = static_cast<int>(points.rows());
  double best = least;
  constexpr double sharpest = 2, slack = 1.15, few = 1;
  for (const int degree : {1, 2}) {
    const int dof = count - 1 - 2 * degree;
    if (dof < 2) continue;
    // Distances across the curve alone may gain a little more.
    if (sharpest * (slack * max_gain(points, corner, degree, noise) + few) <= best) continue;
    const Fit arms = fit(shape(count, corner, degree), points, noise);
    const double good = 1.3 * dof + 3 * std::sqrt(2.0 * dof);
    if (degree == 2 && arms.chi > 2 * good) return -1;
    if (arms.chi > good) continue;
    const Vec3 before = arms.coefficients.row(1), behind = arms.coefficients.row(degree + 1);
    const double turning_angle = degrees_between(before, behind);
    if (!(turning_angle > least_turn)) continue;
    const double sharpness = std::clamp(turning_angle / 50, 0.7, sharpest);
    constexpr double sharp = 75;
    const double of_along = turning_angle > sharp ? 1 / std::max(1.0, arms.along / dof) : 0;
    const auto misfit = [&](const Fit& fit) { return fit.chi + of_along * fit.along; };
    double gain = std::numeric_limits<double>::infinity();
    // Further degrees can only take from the gain.
    for (int d = degree + 1; d <= 2 * degree + 1 && d < count - 1 && gain > best; ++d)
      gain = std::min(gain, sharpness *
                                (misfit(fit(shape(count, -1, d), points, noise)) - misfit(arms)) /
                                std::max(1.0, arms.chi / dof));
    if (std::isfinite(gain)) best = std::max(best, gain);
  }
  return best > least ? best : 0;
}

}  // namespace batten
