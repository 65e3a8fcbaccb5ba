#include "batten/fem/bicubic_patch.h"

#include <Eigen/QR>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

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

/// Changes the poles as little as possible so that the patch passes through its fixed points.
void pass_through_fixed(BicubicPatch& patch, const PatchTarget& target) {
  const long n = static_cast<long>(target.fixed.size());
  if (n == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  Points missing(n, 3);
  for (long k = 0; k < n; ++k) {
    const Vec2& uv = target.fixed[static_cast<size_t>(k)];
    missing.row(k) = target.position(uv) - patch.position(uv);
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
                 Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(square).solve(missing);
}

/// Largest |S - x| in each cell; raises what is there.
void raise_errors(const BicubicPatch& patch, const CellSamples& samples,
                  std::vector<double>& errors) {
  const int n = patch.v.intervals();
  parallel_parts(patch.u.intervals(), [&](int i) {
    for (int j = 0; j < n; ++j) {
      const size_t cell = static_cast<size_t>(i) * n + j;
      for (const CellSamples::Sample& sample : samples.of(cell))
        errors[cell] = std::max(errors[cell],
                                (position_in(patch, i, j, sample.s, sample.t) - sample.x).norm());
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

double shortest_interval(const SplineAxis& axis) {
  double length = axis.length(0);
  for (int k = 1; k < axis.intervals(); ++k) length = std::min(length, axis.length(k));
  return length;
}

/// Fits round by round, each on the knots that the errors of the one before ask for.
class PatchSearch {
 public:
  PatchSearch(const PatchTarget& target, double goal, const PatchLimits& limits,
              const BicubicPatch* start)
      : target_(target), goal_(goal), limits_(limits), given_start_(start) {
    const Vec2 extent = target.high - target.low;
    const auto first = [&](double length) {
      const double share = limits.first * length / extent.maxCoeff();
      return std::max(std::min(4, limits.first), static_cast<int>(std::lround(share)));
    };
    const int in_u = target.periodic ? std::max(4, first(extent.x())) : first(extent.x());
    u_ = uniform(target.low.x(), target.high.x(), in_u, target.periodic);
    v_ = uniform(target.low.y(), target.high.y(), first(extent.y()), false);
    if (start) {
      u_ = start->u;
      v_ = start->v;
    }
    best_.deviation = std::numeric_limits<double>::infinity();
    lowest_ = best_.deviation;
  }

  PatchFit run() {
    constexpr int most_rounds = 16;
    for (int round = 1; round <= most_rounds; ++round) {
      fit();
      keep_if_best();
      if (no_better_to_come()) break;
      find_wanted_knots(round);
      if (!move_knots()) break;
    }
    return best_;
  }

 private:
  void fit() {
    const double spacing = std::min(shortest_interval(u_), shortest_interval(v_)) / 4;
    const CellSamples fitted(target_, u_, v_, {0.125, 0.375, 0.625, 0.875}, target_.rim(spacing));
    const CellSamples others(target_, u_, v_, {0, 0.5}, target_.rim(0.7 * spacing));
    patch_ = fit_to_samples(u_, v_, fitted, goal_);
    pass_through_fixed(patch_, target_);

    errors_.assign(static_cast<size_t>(u_.intervals()) * v_.intervals(), 0.0);
    raise_errors(patch_, others, errors_);
    deviation_ = *std::max_element(errors_.begin(), errors_.end());
    raise_errors(patch_, fitted, errors_);
    reached_ = deviation_ <= goal_;
  }

  void keep_if_best() {
    const bool fewer = patch_.poles.rows() < best_.patch.poles.rows();
    progressed_ = deviation_ <= 0.8 * lowest_;
    if (progressed_) {
      lowest_ = deviation_;
      progress_ = patch_.poles.rows();
    }
    if (best_.reached ? reached_ && fewer : reached_ || deviation_ < best_.deviation)
      best_ = {patch_, deviation_, reached_};
  }

  bool no_better_to_come() {
    if (best_.reached) return !reached_ || deviation_ > 0.3 * goal_ || ++sparer_ > 2;
    return patch_.poles.rows() > 12 * progress_;
  }

  // Where, and in which direction, the next knots go.
  void find_wanted_knots(int round) {
    const double aim = 0.6 * goal_;
    const auto in_u = fourth_differences(patch_, 0), in_v = fourth_differences(patch_, 1);
    const double least = reached_ || (round <= 4 && !given_start_) ? 0.6 : 1.0;
    factor_u_.assign(static_cast<size_t>(u_.intervals()), least);
    factor_v_.assign(static_cast<size_t>(v_.intervals()), least);
    for (int i = 0; i < u_.intervals(); ++i)
      for (int j = 0; j < v_.intervals(); ++j) {
        const size_t cell = static_cast<size_t>(i) * v_.intervals() + j;
        const double both = std::max(in_u[cell], in_v[cell]);
        if (!(both > 0) || errors_[cell] == 0) continue;
        const auto wanted = [&](double part) {
          return std::min(2.0, std::pow(errors_[cell] * part / both / aim, 0.25));
        };
        factor_u_[i] = std::max(factor_u_[i], wanted(in_u[cell]));
        factor_v_[j] = std::max(factor_v_[j], wanted(in_v[cell]));
      }
  }

  // False when the limits leave no better knots.
  bool move_knots() {
    const auto finer = [&](double growth) {
      return std::pair{redistributed(u_, factor_u_, growth, limits_.a_direction - 3),
                       redistributed(v_, factor_v_, growth, limits_.a_direction - 3)};
    };
    const double before = static_cast<double>(patch_.poles.rows());
    const auto poles = [](const auto& axes) {
      return static_cast<double>(axes.first.functions()) * axes.second.functions();
    };
    double growth = 1;
    auto next = finer(growth);
    while (!reached_ && poles(next) < (progressed_ ? 1.15 : 1.6) * before && growth < 2)
      next = finer(growth *= 1.08);
    while (poles(next) > limits_.in_all) next = finer(growth *= 0.97);
    if (!reached_ && poles(next) <= 1.02 * before) return false;  // at the limits
    if (reached_ && poles(next) >= before) return false;
    u_ = next.first;
    v_ = next.second;
    return true;
  }

  const PatchTarget& target_;
  double goal_;
  const PatchLimits& limits_;
  bool given_start_;
  SplineAxis u_, v_;
  PatchFit best_;
  double lowest_ = 0;
  long progress_ = 1;  // poles when the deviation last fell
  int sparer_ = 0;
  // Of the round.
  BicubicPatch patch_;
  std::vector<double> errors_;  // of each cell
  double deviation_ = 0;
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

PatchFit fit_bicubic_patch(const PatchTarget& target, double goal, const PatchLimits& limits,
                           const BicubicPatch* start) {
  return PatchSearch(target, goal, limits, start).run();
}

}  // namespace batten
