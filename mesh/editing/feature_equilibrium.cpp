// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/editing/feature_equilibrium.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

/// Directions whose stiffness is less, relative to the largest one of the body, have none.
constexpr double kNegligible = 1e-6;
/// The same relative to the stiffest body, for bodies without any: single vertices.
constexpr double kRounding = 1e-12;
/// Damping of the steps of bodies that the stiffness does not couple.
constexpr double kDamping = 0.5;

template <class Matrix>
auto symmetric(const Matrix& K) {
  return (0.5 * (K + K.transpose())).eval();
}

Mat3 stiffness(const Mat3& first_moment_rate) {
  return first_moment_rate.trace() * Mat3::Identity() - first_moment_rate.transpose();
}

Vec3 axial(const Mat3& T) { return {T(1, 2) - T(2, 1), T(2, 0) - T(0, 2), T(0, 1) - T(1, 0)}; }

}  // namespace

FeatureEquilibrium::FeatureEquilibrium(FormFeatureDeformer& deformer, std::vector<int> body)
    : body_(std::move(body)) {
  const int bodies = body_.empty() ? 0 : 1 + *std::max_element(body_.begin(), body_.end());
  if (bodies <= 0) return;
  member_.resize(bodies);
  for (int f = isize(body_) - 1; f >= 0; --f)
    if (body_[f] >= 0) member_[body_[f]] = f;
  stiffness_ = deformer.feature_stiffness(body_);
  K_ = stiffness_.S;
  movements_ = constraint_moments_ = stiffness_.v;
  rotated_directions_.resize(bodies);
  find_free_directions();
  step_.resize(3L * bodies);
  moments_ = before_ = after_ = accelerated_ = Points::Zero(3L * bodies, 3);
  accelerator_.resize(3L * bodies);
}

void FeatureEquilibrium::find_free_directions() {
  const auto own_stiffness = [&](long f) {
    return symmetric(stiffness(stiffness_.S.block<3, 3>(3 * f, is_coupled() ? 3 * f : 0)));
  };
  double stiffest = 0;
  for (long f = 0; f < isize(member_); ++f)
    stiffest = std::max(stiffest, own_stiffness(f).trace() / 3);
  for (long f = 0; f < isize(member_); ++f) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(own_stiffness(f));
    const Vec3& values = solver.eigenvalues();
    const double least = std::max(kNegligible * values[2], kRounding * stiffest);
    Mat3 directions = Mat3::Zero();
    for (int k = 0; k < 3; ++k)
      if (values[k] > least)
        directions += solver.eigenvectors().col(k) * solver.eigenvectors().col(k).transpose();
    free_directions_.push_back(directions);
    mean_stiffness_.push_back(values[2] > least ? values.sum() / 3 : stiffest > 0 ? stiffest : 1);
  }
}

void FeatureEquilibrium::linearize(FormFeatureDeformer& deformer, const ShapeEstimate& estimate) {
  const Points& of_features = deformer.feature_moments();
  moments_.setZero();
  for (long f = 0; f < isize(body_); ++f)
    if (body_[f] >= 0) moments_.middleRows<3>(3L * body_[f]) += of_features.middleRows<3>(3 * f);
  for (long f = 0; f < isize(member_); ++f) {
    const Mat3& own = rotation(estimate, f);
    rotated_directions_[f] = own * free_directions_[f] * own.transpose();
    step_.segment<3>(3 * f) = -rotated_directions_[f] * axial(moments_.middleRows<3>(3 * f));
  }
  for (long f = 0; f < isize(member_); ++f)
    for (long k = 0; k < K_.cols() / 3; ++k) {
      const long h = is_coupled() ? k : f;
      K_.block<3, 3>(3 * f, 3 * k) =
          rotated_directions_[f] *
          stiffness(rotation(estimate, f) * stiffness_.S.block<3, 3>(3 * f, 3 * k) *
                    rotation(estimate, h).transpose()) *
          rotated_directions_[h];
      if (h == f)
        K_.block<3, 3>(3 * f, 3 * k) +=
            mean_stiffness_[f] * (Mat3::Identity() - rotated_directions_[f]);
    }
  if (!stiffness_.n.empty()) add_point_constraints(estimate);
}

void FeatureEquilibrium::add_point_constraints(const ShapeEstimate& estimate) {
  const auto set_moments = [&](const MatX& arms, MatX& moments) {
    for (long k = 0; k < arms.cols(); ++k)
      for (long f = 0; f < isize(member_); ++f) {
        const Vec3 arm = rotation(estimate, f) * arms.block<3, 1>(3 * f, k);
        moments.block<3, 1>(3 * f, k) = rotated_directions_[f] * arm.cross(stiffness_.n[k]);
      }
  };
  set_moments(stiffness_.v, movements_);
  set_moments(stiffness_.w, constraint_moments_);
  if (is_coupled()) {
    K_ += constraint_moments_ * stiffness_.H * movements_.transpose();
    return;
  }
  for (long f = 0; f < isize(member_); ++f)
    K_.middleRows<3>(3 * f) += constraint_moments_.middleRows<3>(3 * f) * stiffness_.H *
                               movements_.middleRows<3>(3 * f).transpose();
}

void FeatureEquilibrium::add_moments(long body, double sign) {
  const Mat3 T = moments_.middleRows<3>(3 * body);
  const Mat3& free = rotated_directions_[body];
  diagonal_block(body) += sign * free * (T - T.trace() * Mat3::Identity()) * free;
}

// Richardson's iteration with the factored symmetric part as the preconditioner.
void FeatureEquilibrium::solve_unsymmetric(const Eigen::Ref<const MatX>& K, Eigen::Ref<VecX> step) {
  constexpr int most = 10;
  constexpr double enough = 1e-3;  // relative: Newton's method is not more accurate
  const VecX load = step;
  VecX residual = load;
  step.setZero();
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most; ++k) {
    const double size = residual.norm();
    if (!(size > enough * load.norm()) || !(size < before)) break;
    before = size;
    step += factor_.solve(residual);
    residual = load - K * step;
  }
}

// The first matrix of these that is positive definite is factored: K; K without first moments; that
// with more and more of the mean stiffness of the bodies on its diagonal.
void FeatureEquilibrium::solve(long first, long count) {
  constexpr double least_shift = 1e-3, largest_shift = 1e6;
  const auto K = K_.middleRows(3 * first, 3 * count);
  auto step = step_.segment(3 * first, 3 * count);
  bool has_moments = true;
  for (long f = first; f < first + count; ++f) add_moments(f, 1);
  for (double shift = 0; shift < largest_shift;) {
    symmetric_ = symmetric(K);
    for (long f = 0; f < count; ++f)
      symmetric_.diagonal().segment<3>(3 * f).array() += shift * mean_stiffness_[first + f];
    factor_.compute(symmetric_);
    if (factor_.info() == Eigen::Success) {
      if (has_moments)
        solve_unsymmetric(K, step);
      else
        factor_.solveInPlace(step);
      return;
    }
    if (has_moments)
      for (long f = first; f < first + count; ++f) add_moments(f, -1);
    else
      shift = std::max(10 * shift, least_shift);
    has_moments = false;
  }
  step.setZero();  // the numbers are not finite
}

double FeatureEquilibrium::rotate_features(FormFeatureDeformer& deformer, ShapeEstimate& estimate) {
  if (member_.empty()) return 0;
  linearize(deformer, estimate);
  if (is_coupled()) {
    solve(0, isize(member_));
  } else {
    for (long f = 0; f < isize(member_); ++f) solve(f, 1);
    step_ *= kDamping;
  }
  constexpr double longest = 0.5;  // radians: a step that the linearization may still describe
  double largest = 0;
  for (long f = 0; f < isize(member_); ++f) {
    auto step = step_.segment<3>(3 * f);
    const double angle = step.norm();
    if (!(angle <= longest)) step *= longest / angle;
    largest = std::max(largest, angle);
    before_.middleRows<3>(3 * f) = rotation(estimate, f);
    after_.middleRows<3>(3 * f) = rotation_matrix(step) * rotation(estimate, f);
  }
  const bool combined = !is_coupled() && accelerator_.accelerate(before_, after_, accelerated_);
  const Points& rotations = combined ? accelerated_ : after_;
  for (size_t f = 0; f < body_.size(); ++f)
    if (body_[f] >= 0)
      estimate.feature_rotations[f] = nearest_rotation(rotations.middleRows<3>(3L * body_[f]));
  return largest * 180 / std::numbers::pi;
}

}  // namespace batten
