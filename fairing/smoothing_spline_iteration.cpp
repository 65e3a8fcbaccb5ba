#include "batten/fairing/smoothing_spline_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fairing/block_averaging.h"
#include "batten/fairing/fair_conditions.h"

namespace batten {

void SmoothingSplineSolver::reduce_conditions() {
  reduction_.reset();
  if (is_unconstrained()) return;
  ConstraintSet set(mesh_.dof_count());
  for (const auto& [dof, value] : fixed_dofs()) set.fix("ends", dof, value);
  add_rows(options_.conditions, at_, mesh_, set);
  // About a point of the curve, so that far from the origin no digits are lost.
  positions_ = VecX::Zero(mesh_.dof_count());
  for (int n = 0; n < mesh_.node_count(); ++n) positions_[mesh_.position_dof(n)] = 1;
  reduction_.emplace(set.translated(positions_, sequence_.points.front()));
}

Points SmoothingSplineSolver::solve(PenalisedLeastSquares& smoothing, double wavelength) const {
  if (!reduction_) return smoothing.solve(wavelength);
  const Vec3 origin = sequence_.points.front();
  const SparseMatrix K = smoothing.matrix(wavelength);
  const SparseMatrix A = reduction_->reduce(K);
  SparseCholesky cholesky;
  cholesky.analyze(A);
  if (!cholesky.factorize(A)) throw NoSolutionError(cholesky.message());
  const auto answer = [&](const SparseMatrix& matrix, const Points& load) {
    return reduction_->expand(cholesky.solve(reduction_->reduce_load(matrix, load)));
  };
  Points q = answer(K, smoothing.load(origin)) + positions_ * origin.transpose();
  // Where conditions act depends on the last digits of the curve.
  const SparseMatrix none(K.rows(), K.cols());
  const Points fixed =
      reduction_->expand(MatX::Zero(reduction_->free_count(), reduction_->coupled() ? 1 : 3));
  constexpr int refinements = 2;
  for (int i = 0; i < refinements; ++i)
    q += answer(none, smoothing.residual(wavelength, q)) - fixed;
  return q;
}

// Solves again with every direction held where the curve is nearest to its place in the end, not
// where it was before.
void SmoothingSplineSolver::iterate_tangent_conditions(PenalisedLeastSquares& smoothing,
                                                       double wavelength) {
  const auto move = [&] {
    double most = 0;
    for (size_t k = 0; k < at_.size(); ++k) {
      if (options_.conditions[k].type != Type::Tangent) continue;
      const double u = curve_.closest_point(options_.conditions[k].at).u;
      most = std::max(most, std::abs(u - at_[k]));
      at_[k] = u;
    }
    return most;
  };
  // In the end rounding moves them to and fro: the best stays.
  constexpr int most_moves = 40;
  constexpr double still = 1e-14;
  double least = std::numeric_limits<double>::infinity();
  HermiteCurve best;
  std::vector<double> best_at;
  for (int k = 0; k < most_moves; ++k) {
    const std::vector<double> held = at_;
    const double moved = move();
    if (moved < least) {
      least = moved;
      best = curve_;
      best_at = held;
    }
    if (moved <= still * length_) break;
    reduce_conditions();
    curve_ = HermiteCurve(mesh_, solve(smoothing, wavelength));
  }
  curve_ = best;
  at_ = best_at;
}

// Moves every point's parameter to the nearest point of the curve and to arc length; returns the
// largest change over the length.
double SmoothingSplineSolver::project_points(bool first) {
  const HermiteArcLength arc(curve_);
  foot_parameters_.resize(count_);
  double change = 0;
  for (int i = 0; i < count_; ++i) {
    const Vec3& p = sequence_.points[i];
    double u = u_[i];
    const bool end = !sequence_.closed && (i == 0 || i == count_ - 1);
    const auto corner = std::lower_bound(sequence_.corners.begin(), sequence_.corners.end(), i);
    if (corner != sequence_.corners.end() && *corner == i) {
      u = mesh_.parameters()[corner_node_[corner - sequence_.corners.begin()]];
    } else if (!end) {
      const double reach = std::max(3 * spacing(), 2 * (curve_.evaluate(u) - p).norm());
      std::vector<double> around;
      for (int k = -4; k <= 4; ++k) {
        const double x = u + reach * k / 4;
        around.push_back(sequence_.closed ? x : std::clamp(x, 0.0, length_));
      }
      around.erase(std::unique(around.begin(), around.end()), around.end());
      u = mesh_.wrapped(
          closest_on_curve([&](double x, int order) { return curve_.evaluate(x, order); }, around,
                           p)
              .u);
    }
    foot_parameters_[i] = u;
    const double s = arc(u) / arc.total();
    double moved = std::abs(s - u_[i] / length_);
    if (sequence_.closed) moved = std::min(moved, 1 - moved);
    change = std::max(change, moved);
    u_[i] = s;
  }
  if (!(arc.total() > 1e-6 * sequence_.size))
    throw NoSolutionError("line '" + name_ + "' shrinks to a point when faired");
  // Under a stated balance a closed curve that shrinks would shrink faster and faster if the
  // parameter shrank with it: it keeps the length of the points, or, where that is mostly noise, of
  // the first curve.
  if (options_.smoothing == FairOptions::Smoothing::CrossValidation ||
      (first && is_zigzag(sequence_.points)))
    length_ = arc.total();
  for (double& u : u_) u *= length_;
  for (size_t k = 0; k < at_.size(); ++k) {
    const CurveCondition& c = options_.conditions[k];
    if (c.type != Type::Point && c.type != Type::Tangent) continue;
    const double s = arc(curve_.closest_point(c.at).u) / arc.total() * length_;
    at_[k] = s;
  }
  return change;
}

// The same curve and feet, u scaled to the length.
void SmoothingSplineSolver::reparametrize_by_arc_length() {
  const double scale = HermiteArcLength(curve_).total() / length_;
  for (double& x : foot_parameters_) x *= scale;
  curve_ = curve_.with_scaled_parameter(scale);
}

// The curve of one round. Where digits are too few for so long a wave, of one that they suffice for.
void SmoothingSplineSolver::solve_at_wavelength(PenalisedLeastSquares& smoothing,
                                                double& wavelength) {
  constexpr double shorter = 0.8;
  const bool as_stated =
      sequence_.closed && options_.smoothing == FairOptions::Smoothing::Wavelength;
  for (;; wavelength *= shorter) {
    const double smoothed = std::max(wavelength, negligible_wavelength());
    try {
      curve_ = HermiteCurve(mesh_, solve(smoothing, smoothed));
      iterate_tangent_conditions(smoothing, smoothed);
      if (!is_unconstrained()) smoothing.solve(smoothed);
      return;
    } catch (const NoSolutionError&) {
      if (as_stated || shorter * wavelength < negligible_wavelength()) throw;
    }
  }
}

}  // namespace batten
