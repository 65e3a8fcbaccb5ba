#include "batten/fem/bicubic_patch.h"

#include <Eigen/QR>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/parallel.h"
#include "batten/fem/patch_equations.h"

namespace batten {
namespace {

using Vec4 = Eigen::Vector4d;

Vec3 position_in(const BicubicPatch& patch, int i, int j, double s, double t) {
  const Vec4 Nu = patch.u.basis(i, s), Nv = patch.v.basis(j, t);
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < 4; ++a) {
    const long row = static_cast<long>(patch.u.function(i, a)) * patch.v.functions() + j;
    x += Nu[a] * (patch.poles.middleRows<4>(row).transpose() * Nv);
  }
  return x;
}

/// Normal of the patch at a place of a cell, of any length.
Vec3 normal_in(const BicubicPatch& patch, int i, int j, double s, double t) {
  const Vec4 Nu = patch.u.basis(i, s), Nv = patch.v.basis(j, t), Nu_s = patch.u.basis(i, s, 1),
             Nv_t = patch.v.basis(j, t, 1);
  Vec3 x_s = Vec3::Zero(), x_t = Vec3::Zero();
  for (int a = 0; a < 4; ++a) {
    const long row = static_cast<long>(patch.u.function(i, a)) * patch.v.functions() + j;
    x_s += Nu_s[a] * (patch.poles.middleRows<4>(row).transpose() * Nv);
    x_t += Nu[a] * (patch.poles.middleRows<4>(row).transpose() * Nv_t);
  }
  return x_s.cross(x_t);
}

/// Changes the poles as little as possible so that the patch passes through its fixed points.
void pass_through_fixed(BicubicPatch& patch, const PatchTarget& target) {
  const long n = static_cast<long>(target.fixed.size());
  if (n == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  Points residual(n, 3);
  for (long k = 0; k < n; ++k) {
    const Vec2& uv = target.fixed[static_cast<size_t>(k)];
    residual.row(k) = target.position(uv) - patch.position(uv);
    const double u = patch.u.wrapped(uv.x()), v = patch.v.wrapped(uv.y());
    const int i = patch.u.interval(u), j = patch.v.interval(v);
    const Vec4 Nu = patch.u.basis(i, (u - patch.u.knots()[i]) / patch.u.length(i)),
               Nv = patch.v.basis(j, (v - patch.v.knots()[j]) / patch.v.length(j));
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        entries.emplace_back(k, patch.u.function(i, a) * patch.v.functions() + j + b,
                             Nu[a] * Nv[b]);
  }
  Eigen::SparseMatrix<double> N(n, patch.poles.rows());
  N.setFromTriplets(entries.begin(), entries.end());
  // Lines that begin where others end give a point twice.
  const Eigen::MatrixXd square = (N * N.transpose()).eval().toDense();
  patch.poles += N.transpose() *
                 Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(square).solve(residual);
}

/// Errors of each cell.
struct CellErrors {
  std::vector<double> distance;   // |S - x|
  std::vector<double> angle_deg;  // between normals, where tangent planes count

  double most(const std::vector<double>& of) const {
    return *std::max_element(of.begin(), of.end());
  }
};

/// Raises what is there to the largest errors at the samples.
void accumulate_max_errors(const BicubicPatch& patch, const CellSamples& samples,
                           CellErrors& errors) {
  const int n = patch.v.intervals();
  parallel_for(patch.u.intervals(), [&](int i) {
    for (int j = 0; j < n; ++j) {
      const size_t cell = static_cast<size_t>(i) * n + j;
      for (const CellSamples::Sample& sample : samples.of(cell))
        errors.distance[cell] =
            std::max(errors.distance[cell],
                     (position_in(patch, i, j, sample.s, sample.t) - sample.x).norm());
      for (const CellSamples::Tangent& tangent : samples.tangents(cell)) {
        const Vec3 normal = normal_in(patch, i, j, tangent.s, tangent.t);
        const Vec3 wanted = tangent.x_s.cross(tangent.x_t);
        errors.angle_deg[cell] = std::max(
            errors.angle_deg[cell],
            std::atan2(normal.cross(wanted).norm(), normal.dot(wanted)) * 180 / std::numbers::pi);
      }
    }
  });
}

/// h⁴ times the fourth derivative in each cell, in u (`along` 0) or v (1), from the jumps of the
/// third at its sides.
std::vector<double> fourth_differences(const BicubicPatch& patch, int along) {
  const SplineAxis& axis = along == 0 ? patch.u : patch.v;
  const SplineAxis& across = along == 0 ? patch.v : patch.u;
  const int count = axis.intervals(), n = patch.v.intervals();
  std::vector<double> result(static_cast<size_t>(patch.u.intervals()) * n);
  for (int c = 0; c < across.intervals(); ++c) {
    std::vector<Vec3> third;
    const Vec4 middle = across.basis(c, 0.5);
    for (int k = 0; k < count; ++k) {
      const Vec4 d = axis.basis(k, 0, 3);
      Vec3 sum = Vec3::Zero();
      for (int a = 0; a < 4; ++a)
        for (int m = 0; m < 4; ++m) {
          const int f = axis.function(k, a), g = across.function(c, m);
          sum += d[a] * middle[m] *
                 patch.poles.row((along == 0 ? f : g) * patch.v.functions() + (along == 0 ? g : f))
                     .transpose();
        }
      third.push_back(sum / std::pow(axis.length(k), 3));
    }
    for (int k = 0; k < count; ++k) {
      double jump = 0;
      for (const int other : {k - 1, k + 1}) {
        const int o = axis.periodic() ? (other + count) % count : other;
        if (o < 0 || o >= count) continue;
        jump = std::max(jump, (third[o] - third[k]).norm() * 2 / (axis.length(o) + axis.length(k)));
      }
      result[static_cast<size_t>(along == 0 ? k : c) * n + (along == 0 ? c : k)] =
          jump * std::pow(axis.length(k), 4);
    }
  }
  return result;
}

/// New knots: `factor` of an old interval is how many new ones it should hold.
SplineAxis redistributed(const SplineAxis& axis, std::vector<double> factor, double growth,
                         int most) {
  const int n = axis.intervals();
  for (int k = 0; k < n; ++k) factor[k] /= axis.length(k);
  // Neighbours of the uniform kind: an interval is at most about twice the one beside it.
  for (int sweep = 0; sweep < (axis.periodic() ? 2 : 1); ++sweep) {
    for (int k = axis.periodic() ? 0 : 1; k < n; ++k)
      factor[k] = std::max(factor[k], factor[(k + n - 1) % n] / 2);
    for (int k = n - (axis.periodic() ? 1 : 2); k >= 0; --k)
      factor[k] = std::max(factor[k], factor[(k + 1) % n] / 2);
  }
  std::vector<double> sum(1, 0.0);
  for (int k = 0; k < n; ++k) sum.push_back(sum.back() + factor[k] * axis.length(k));
  const int count =
      std::clamp(static_cast<int>(std::ceil(growth * sum.back())), axis.periodic() ? 4 : 2, most);
  std::vector<double> knots;
  int k = 0;
  for (int i = 0; i < count; ++i) {
    const double at = sum.back() * i / count;
    while (k + 1 < n && sum[k + 1] <= at) ++k;
    knots.push_back(axis.knots()[k] + (at - sum[k]) / factor[k]);
  }
  knots.push_back(axis.knots().back());
  return SplineAxis(std::move(knots), axis.periodic());
}

SplineAxis uniform(double low, double high, int intervals, bool periodic) {
  std::vector<double> knots;
  for (int i = 0; i < intervals; ++i) knots.push_back(low + (high - low) * i / intervals);
  knots.push_back(high);
  return SplineAxis(std::move(knots), periodic);
}

/// Fits round by round, each on the knots that the errors of the one before ask for.
class PatchSearch {
 public:
  PatchSearch(const PatchTarget& target, const PatchGoal& goal, const PatchLimits& limits,
              const BicubicPatch* start)
      : target_(target), goal_(goal), limits_(limits), given_start_(start) {
    const Vec2 extent = target.high - target.low;
    const auto first = [&](double length) {
      const double share = limits.initial_intervals * length / extent.maxCoeff();
      return std::max(std::min(4, limits.initial_intervals), static_cast<int>(std::lround(share)));
    };
    const int in_u = target.periodic ? std::max(4, first(extent.x())) : first(extent.x());
    u_ = uniform(target.low.x(), target.high.x(), in_u, target.periodic);
    v_ = uniform(target.low.y(), target.high.y(), first(extent.y()), false);
    if (start) {
      u_ = start->u;
      v_ = start->v;
    }
    best_.deviation = best_goal_ratio_ = lowest_goal_ratio_ =
        std::numeric_limits<double>::infinity();
  }

  PatchFit run() {
    constexpr int kMaxIterations = 16;
    for (int iteration = 1; iteration <= kMaxIterations; ++iteration) {
      fit();
      update_best();
      if (should_stop()) break;
      compute_knot_density(iteration);
      if (!redistribute_knots()) break;
    }
    return best_.reached ? best_ : fewest_poles_fit();
  }

 private:
  /// Of the fits that reach the deviation and not the angle, the one with the fewest poles that comes
  /// within half of the way to the smallest angle: more poles would buy little.
  PatchFit fewest_poles_fit() const {
    if (within_deviation_.empty()) return best_;
    const auto less = [](const PatchFit& a, const PatchFit& b) {
      return a.angle_deg < b.angle_deg;
    };
    PatchFit found = *std::min_element(within_deviation_.begin(), within_deviation_.end(), less);
    const double least = found.angle_deg;
    if (least < 2 * goal_.angle_deg) return found;
    for (const PatchFit& fit : within_deviation_)
      if (fit.angle_deg <= 1.5 * least && fit.patch.poles.rows() < found.patch.poles.rows())
        found = fit;
    return found;
  }

  void fit() {
    constexpr double step = 0.25;  // along the rim
    const CellSamples fitted(target_, u_, v_, {0.125, 0.375, 0.625, 0.875}, step);
    const CellSamples others(target_, u_, v_, {0, 0.5}, 0.7 * step);
    patch_ = fit_to_samples(u_, v_, fitted, goal_);
    pass_through_fixed(patch_, target_);

    const size_t cells = static_cast<size_t>(u_.intervals()) * v_.intervals();
    errors_ = {std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
    accumulate_max_errors(patch_, others, errors_);
    deviation_ = errors_.most(errors_.distance);
    angle_deg_ = errors_.most(errors_.angle_deg);
    accumulate_max_errors(patch_, fitted, errors_);
    goal_ratio_ = std::max(deviation_ / goal_.deviation, angle_deg_ / goal_.angle_deg);
    reached_ = goal_ratio_ <= 1;
  }

  void update_best() {
    const bool fewer = patch_.poles.rows() < best_.patch.poles.rows();
    progressed_ = goal_ratio_ <= 0.8 * lowest_goal_ratio_;
    if (progressed_) {
      lowest_goal_ratio_ = goal_ratio_;
      progress_ = patch_.poles.rows();
    }
    if (deviation_ <= goal_.deviation)
      within_deviation_.push_back({patch_, deviation_, angle_deg_, false});
    if (best_.reached ? reached_ && fewer : reached_ || goal_ratio_ < best_goal_ratio_) {
      best_ = {patch_, deviation_, angle_deg_, reached_};
      best_goal_ratio_ = goal_ratio_;
    }
  }

  bool should_stop() {
    if (best_.reached) return !reached_ || goal_ratio_ > 0.3 || ++reductions_ > 2;
    // Angles that finer knots do not lower are those of the surface's own kinks.
    const double patience = deviation_ <= goal_.deviation ? 2.5 : 12;
    return static_cast<double>(patch_.poles.rows()) > patience * static_cast<double>(progress_);
  }

  // Where, and in which direction, the next knots go.
  void compute_knot_density(int iteration) {
    constexpr double aim = 0.6;  // of the goal
    const auto in_u = fourth_differences(patch_, 0), in_v = fourth_differences(patch_, 1);
    const double least = reached_ || (iteration <= 4 && !given_start_) ? 0.6 : 1.0;
    factor_u_.assign(static_cast<size_t>(u_.intervals()), least);
    factor_v_.assign(static_cast<size_t>(v_.intervals()), least);
    for (int i = 0; i < u_.intervals(); ++i)
      for (int j = 0; j < v_.intervals(); ++j) {
        const size_t cell = static_cast<size_t>(i) * v_.intervals() + j;
        const double both = std::max(in_u[cell], in_v[cell]);
        const double deviation_ratio = errors_.distance[cell] / goal_.deviation / aim,
                     angle_ratio = errors_.angle_deg[cell] / goal_.angle_deg / aim;
        if (!(both > 0) || std::max(deviation_ratio, angle_ratio) == 0) continue;
        const auto wanted = [&](double part) {
          return std::min(2.0, std::max(std::pow(deviation_ratio * part / both, 0.25),
                                        std::cbrt(angle_ratio * part / both)));
        };
        factor_u_[i] = std::max(factor_u_[i], wanted(in_u[cell]));
        factor_v_[j] = std::max(factor_v_[j], wanted(in_v[cell]));
      }
  }

  // False when the limits leave no better knots.
  bool redistribute_knots() {
    const auto finer = [&](double growth) {
      return std::pair{redistributed(u_, factor_u_, growth, limits_.max_poles_per_direction - 3),
                       redistributed(v_, factor_v_, growth, limits_.max_poles_per_direction - 3)};
    };
    const double before = static_cast<double>(patch_.poles.rows());
    const auto poles = [](const auto& axes) {
      return static_cast<double>(axes.first.functions()) * axes.second.functions();
    };
    double growth = 1;
    auto next = finer(growth);
    while (!reached_ && poles(next) < (progressed_ ? 1.15 : 1.6) * before && growth < 2)
      next = finer(growth *= 1.08);
    while (poles(next) > limits_.max_poles) next = finer(growth *= 0.97);
    if (!reached_ && poles(next) <= 1.02 * before) return false;  // at the limits
    if (reached_ && poles(next) >= before) return false;
    u_ = next.first;
    v_ = next.second;
    return true;
  }

  const PatchTarget& target_;
  const PatchGoal& goal_;
  const PatchLimits& limits_;
  bool given_start_;
  SplineAxis u_, v_;
  PatchFit best_;
  double best_goal_ratio_ = 0;
  std::vector<PatchFit> within_deviation_;  // those that reach the deviation
  double lowest_goal_ratio_ = 0;
  long progress_ = 1;  // poles when the miss last fell
  int reductions_ = 0;
  // Of the round.
  BicubicPatch patch_;
  CellErrors errors_;
  double deviation_ = 0, angle_deg_ = 0;
  double goal_ratio_ = 0;  // the larger of the two over its goal
  bool reached_ = false, progressed_ = false;
  std::vector<double> factor_u_, factor_v_;
};

}  // namespace

Vec3 BicubicPatch::position(const Vec2& uv) const {
  const double a = u.wrapped(uv.x()), b = v.wrapped(uv.y());
  const int i = u.interval(a), j = v.interval(b);
  return position_in(*this, i, j, (a - u.knots()[i]) / u.length(i),
                     (b - v.knots()[j]) / v.length(j));
}

Vec3 BicubicPatch::normal(const Vec2& uv) const {
  const double a = u.wrapped(uv.x()), b = v.wrapped(uv.y());
  const int i = u.interval(a), j = v.interval(b);
  return normal_in(*this, i, j, (a - u.knots()[i]) / u.length(i), (b - v.knots()[j]) / v.length(j));
}

PatchFit fit_bicubic_patch(const PatchTarget& target, const PatchGoal& goal,
                           const PatchLimits& limits, const BicubicPatch* start) {
  return PatchSearch(target, goal, limits, start).run();
}

}  // namespace batten
