// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/bicubic_patch.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

// Samples of a surface by cells of a bicubic spline, and the least-squares spline.

// Samples by cell, with index i · v.intervals() + j.
class CellSamples {
 public:
  struct Sample {
    double s, t;  // in its cell
    Vec3 x;
    double weight = 1;
  };
  struct Tangent {
    double s, t;    // in its cell
    Vec3 x_s, x_t;  // derivatives with respect to s and t
  };

  // Takes n×n samples per cell at the given `points` in [0, 1], and points and tangents on the
  // boundary with spacing below `step`. The unit of `step` is the shortest side of all cells, or a
  // third of the point's own cell if that is longer.
  CellSamples(const PatchTarget& target, const SplineAxis& u, const SplineAxis& v,
              const std::vector<double>& points, double step);
  const std::vector<Sample>& of(size_t cell) const { return cells_[cell]; }
  const std::vector<Tangent>& tangents(size_t cell) const { return tangents_[cell]; }
  // Whether all samples of the cell are inside. They are then stored first, ordered by s, then by
  // t.
  bool full(size_t cell) const { return full_[cell] != 0; }

  // Mean square of the second derivatives in cell units, by finite differences of samples at four
  // equidistant points a quarter apart.
  double bending() const;

 private:
  std::vector<std::vector<Sample>> cells_;
  std::vector<std::vector<Tangent>> tangents_;
  std::vector<char> full_;  // all samples of the cell are inside
};

// Fits with the strongest bending term that costs at most a hundredth of the goal. Throws
// NoSolutionError if numbers are not finite.
BicubicPatch fit_to_samples(const SplineAxis& u, const SplineAxis& v, const CellSamples& samples,
                            const PatchGoal& goal);

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

// Normal of the patch at a point of a cell, not normalised.
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

// Changes the poles as little as possible such that the patch interpolates its fixed points.
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
  // Curves with common ends produce the same point twice, so the matrix may be singular.
  const Eigen::MatrixXd square = (N * N.transpose()).eval().toDense();
  patch.poles += N.transpose() * least_squares(square, residual);
}

// Errors of each cell.
struct CellErrors {
  std::vector<double> distance;   // |S - x|
  std::vector<double> angle_deg;  // between normals, at prescribed tangent planes

  double most(const std::vector<double>& of) const {
    return *std::max_element(of.begin(), of.end());
  }
};

// Raises the errors to the largest ones at the given samples.
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

// h⁴ times the fourth derivative in each cell, in u (`along` 0) or v (1), from the jumps of the
// third derivative at its sides.
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

// New knots; `factor`: number of new intervals that each old interval should contain.
SplineAxis redistributed(const SplineAxis& axis, std::vector<double> factor, double growth,
                         int most) {
  const int n = axis.intervals();
  for (int k = 0; k < n; ++k) factor[k] /= axis.length(k);
  // Graded spacing: an interval is at most about twice as long as its neighbours.
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

// Adaptive iteration: each fit uses knots derived from the errors of the previous one.
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
  // Among the fits that reach the deviation but not the angle, the one with the fewest poles whose
  // angle is within half of the range to the smallest angle; more poles would gain little.
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
    constexpr double step = 0.25;  // along the boundary
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
    // If finer knots do not reduce the angle, it is due to kinks of the target surface itself.
    const double patience = deviation_ <= goal_.deviation ? 2.5 : 12;
    return static_cast<double>(patch_.poles.rows()) > patience * static_cast<double>(progress_);
  }

  // Computes where, and in which direction, new knots are needed.
  void compute_knot_density(int iteration) {
    constexpr double aim = 0.6;  // fraction of the goal
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

  // Returns false if the limits permit no better knots.
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
  std::vector<PatchFit> within_deviation_;  // fits that reach the deviation
  double lowest_goal_ratio_ = 0;
  long progress_ = 1;  // poles when the error last decreased
  int reductions_ = 0;
  // State of the current iteration.
  BicubicPatch patch_;
  CellErrors errors_;
  double deviation_ = 0, angle_deg_ = 0;
  double goal_ratio_ = 0;  // the larger of the two errors, relative to its goal
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

namespace {

using Mat4 = Eigen::Matrix4d;

// ∫₀¹ of products of the derivatives on one interval.
Mat4 gram(const SplineAxis& axis, int interval, int derivative) {
  Mat4 G = Mat4::Zero();
  constexpr double node[4] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                              0.93056815579702629};
  constexpr double weight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                0.17392742256872693};
  for (int g = 0; g < 4; ++g) {
    const Vec4 b = axis.basis(interval, node[g], derivative);
    G += weight[g] * b * b.transpose();
  }
  return G;
}

// Flags the cells within three cells of one that has samples: only these share basis functions with
// it.
std::vector<char> near_samples(const CellSamples& samples, const SplineAxis& u,
                               const SplineAxis& v) {
  const int m = u.intervals(), n = v.intervals();
  std::vector<char> along(static_cast<size_t>(m) * n), near(along.size());
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j)
      if (!samples.of(static_cast<size_t>(i) * n + j).empty())
        for (int d = -3; d <= 3; ++d)
          if (j + d >= 0 && j + d < n) along[static_cast<size_t>(i) * n + j + d] = 1;
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j)
      if (along[static_cast<size_t>(i) * n + j])
        for (int d = -3; d <= 3; ++d) {
          const int k = u.periodic() ? (i + d + m) % m : i + d;
          if (k >= 0 && k < m) near[static_cast<size_t>(k) * n + j] = 1;
        }
  return near;
}

// Normal equations of samples and bending.
class PatchEquations {
 public:
  PatchEquations(const SplineAxis& u, const SplineAxis& v, const CellSamples& samples,
                 double bending, const PatchGoal& goal)
      : u_(u),
        v_(v),
        samples_(samples),
        goal_(goal),
        columns_(v.functions()),
        unknowns_(u.functions() * columns_),
        entries_(static_cast<size_t>(unknowns_)),
        poles_(Points::Zero(unknowns_, 3)) {
    // Far from the samples, the spline only has to be stiff compared with the part near them.
    const double bending_outside = 1e4 * bending;
    const auto near = near_samples(samples, u, v);
    std::vector<Grams> gram_v;
    for (int j = 0; j < v.intervals(); ++j) gram_v.push_back(grams(v, j));
    for (auto& e : entries_) e.fill(0);
    for (int i = 0; i < u.intervals(); ++i) {
      const Grams gram_u = grams(u, i);
      for (int j = 0; j < v.intervals(); ++j) {
        const size_t cell = static_cast<size_t>(i) * v.intervals() + j;
        set_to_bending(near[cell] ? bending : bending_outside, gram_u, gram_v[j]);
        add_samples(cell, i, j);
        add_tangents(cell, i, j);
        add_cell(i, j);
      }
    }
  }

  // Returns nothing if the matrix is singular to rounding.
  std::optional<BicubicPatch> solve() && {
    const SparseMatrix K = matrix();
    SparseCholesky cholesky;
    cholesky.analyze(K);
    if (!cholesky.factorize(K)) return std::nullopt;
    cholesky.solve_in_place(poles_);
    return BicubicPatch{u_, v_, std::move(poles_)};
  }

 private:
  using Grams = std::array<Mat4, 3>;  // by derivative

  static Grams grams(const SplineAxis& axis, int interval) {
    return {gram(axis, interval, 0), gram(axis, interval, 1), gram(axis, interval, 2)};
  }

  void set_to_bending(double e, const Grams& gram_u, const Grams& gram_v) {
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c)
        A_.block<4, 4>(4 * a, 4 * c) =
            e * (gram_u[2](a, c) * gram_v[0] + 2 * gram_u[1](a, c) * gram_v[1] +
                 gram_u[0](a, c) * gram_v[2]);
    b_.setZero();
  }

  static constexpr double sample_weight = 1.0 / 16;

  // Adds the first 16 samples of a full cell: a tensor product of four points per direction.
  void add_full_cell(const CellSamples::Sample* samples, int i, int j) {
    Mat4 U = Mat4::Zero(), V = Mat4::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vec4 Nu = u_.basis(i, samples[4 * k].s);
      U += sample_weight * Nu * Nu.transpose();
      Eigen::Matrix<double, 4, 3> along = Eigen::Matrix<double, 4, 3>::Zero();
      for (int l = 0; l < 4; ++l) {
        const Vec4 Nv = v_.basis(j, samples[l].t);
        if (k == 0) V += Nv * Nv.transpose();
        along += Nv * samples[4 * k + l].x.transpose();
      }
      for (int a = 0; a < 4; ++a) b_.middleRows<4>(4 * a) += sample_weight * Nu[a] * along;
    }
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c) A_.block<4, 4>(4 * a, 4 * c) += U(a, c) * V;
  }

  void add_samples(size_t cell, int i, int j) {
    Eigen::Matrix<double, 16, 1> N;
    const auto& all = samples_.of(cell);
    if (samples_.full(cell)) add_full_cell(all.data(), i, j);
    for (size_t k = samples_.full(cell) ? 16 : 0; k < all.size(); ++k) {
      const CellSamples::Sample& sample = all[k];
      const Vec4 Nu = u_.basis(i, sample.s), Nv = v_.basis(j, sample.t);
      for (int a = 0; a < 4; ++a) N.segment<4>(4 * a) = Nu[a] * Nv;
      const double weight = sample_weight * sample.weight;
      A_.noalias() += weight * N * N.transpose();
      b_.noalias() += weight * N * sample.x.transpose();
    }
  }

  void add_tangents(size_t cell, int i, int j) {
    const double askew = goal_.angle_deg * std::numbers::pi / 180;
    Eigen::Matrix<double, 16, 1> N_s, N_t;
    for (const CellSamples::Tangent& tangent : samples_.tangents(cell)) {
      const Vec4 Nu = u_.basis(i, tangent.s), Nv = v_.basis(j, tangent.t),
                 Nu_s = u_.basis(i, tangent.s, 1), Nv_t = v_.basis(j, tangent.t, 1);
      for (int a = 0; a < 4; ++a) {
        N_s.segment<4>(4 * a) = Nu_s[a] * Nv;
        N_t.segment<4>(4 * a) = Nu[a] * Nv_t;
      }
      const double length = (tangent.x_s.norm() + tangent.x_t.norm()) / 2;
      const double ratio = goal_.deviation / (askew * length);
      const double weight = std::clamp(ratio * ratio, 4.0, 1000.0) / 16;
      A_.noalias() += weight * (N_s * N_s.transpose() + N_t * N_t.transpose());
      b_.noalias() += weight * (N_s * tangent.x_s.transpose() + N_t * tangent.x_t.transpose());
    }
  }

  void add_cell(int i, int j) {
    for (int a = 0; a < 16; ++a) {
      const size_t row = static_cast<size_t>(u_.function(i, a / 4)) * columns_ + j + a % 4;
      poles_.row(static_cast<long>(row)) += b_.row(a);
      for (int c = 0; c < 16; ++c)
        entries_[row][7 * (c / 4 - a / 4 + 3) + c % 4 - a % 4 + 3] += A_(a, c);
    }
  }

  SparseMatrix matrix() const {
    const int rows = u_.functions();
    std::vector<Triplet> triplets;
    triplets.reserve(static_cast<size_t>(unknowns_) * 25);
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns_; ++j)
        for (int k = 0; k < 49; ++k) {
          const double value = entries_[static_cast<size_t>(i) * columns_ + j][k];
          int other = i + k / 7 - 3;
          if (u_.periodic()) other = (other + rows) % rows;
          const int row = i * columns_ + j, column = other * columns_ + j + k % 7 - 3;
          if (value != 0 && row >= column) triplets.emplace_back(row, column, value);
        }
    SparseMatrix K(unknowns_, unknowns_);
    K.setFromTriplets(triplets.begin(), triplets.end());
    return K;
  }

  const SplineAxis &u_, &v_;
  const CellSamples& samples_;
  const PatchGoal& goal_;
  int columns_, unknowns_;
  // Symmetric matrix by distance of the functions: entries of (i, j) with (i + di, j + dj), di, dj
  // in -3 … 3.
  std::vector<std::array<double, 49>> entries_;
  Points poles_;  // the right-hand side, then the solution
  // Contribution of one cell.
  Eigen::Matrix<double, 16, 16> A_;
  Eigen::Matrix<double, 16, 3> b_;
};

// Cells that contain boundary points.
class BoundaryCells {
 public:
  struct CellPoint {
    size_t cell;
    double s, t;  // coordinates in the cell
    Vec2 size;    // size of the cell
  };
  BoundaryCells(const SplineAxis& u, const SplineAxis& v)
      : u_(u), v_(v), shortest_(std::min(shortest_interval(u), shortest_interval(v))) {}

  CellPoint at(const Vec2& uv) const {
    const double a = u_.wrapped(uv.x()), b = v_.wrapped(uv.y());
    const int i = u_.interval(a), j = v_.interval(b);
    return {static_cast<size_t>(i) * v_.intervals() + j,
            (a - u_.knots()[i]) / u_.length(i),
            (b - v_.knots()[j]) / v_.length(j),
            {u_.length(i), v_.length(j)}};
  }
  // `fraction` of the shortest side of all cells. Faces meet along their boundaries, so accuracy
  // there counts more than inside if cells are coarse. The step is at least that fraction of a
  // third of the point's own cell; otherwise, if knots are dense elsewhere, most of the work would
  // be spent on the boundary.
  Vec2 longest_step(const Vec2& uv, double fraction) const {
    constexpr double most_crowded = 3;
    return fraction * (at(uv).size / most_crowded).cwiseMax(shortest_);
  }

 private:
  static double shortest_interval(const SplineAxis& axis) {
    double length = axis.length(0);
    for (int k = 1; k < axis.intervals(); ++k) length = std::min(length, axis.length(k));
    return length;
  }
  const SplineAxis &u_, &v_;
  double shortest_;
};

}  // namespace

CellSamples::CellSamples(const PatchTarget& target, const SplineAxis& u, const SplineAxis& v,
                         const std::vector<double>& points, double step)
    : cells_(static_cast<size_t>(u.intervals()) * v.intervals()),
      tangents_(cells_.size()),
      full_(cells_.size()) {
  parallel_for(u.intervals(), [&](int i) {
    for (int j = 0; j < v.intervals(); ++j) {
      const size_t cell = static_cast<size_t>(i) * v.intervals() + j;
      for (const double s : points)
        for (const double t : points) {
          const Vec2 uv(u.knots()[i] + s * u.length(i), v.knots()[j] + t * v.length(j));
          if (target.inside(uv)) cells_[cell].push_back({s, t, target.position(uv)});
        }
      full_[cell] = cells_[cell].size() == points.size() * points.size();
    }
  });
  const BoundaryCells cells(u, v);
  const BoundaryStep longest = [&](const Vec2& uv) { return cells.longest_step(uv, step); };
  const std::vector<Vec2> boundary = target.boundary(longest);
  std::vector<Vec3> x(boundary.size());
  const int parts = static_cast<int>(std::min<size_t>(boundary.size(), 64));
  parallel_for(parts, [&](int part) {
    const size_t from = boundary.size() * part / parts, to = boundary.size() * (part + 1) / parts;
    for (size_t k = from; k < to; ++k) x[k] = target.position(boundary[k]);
  });
  for (size_t k = 0; k < boundary.size(); ++k) {
    const BoundaryCells::CellPoint at = cells.at(boundary[k]);
    cells_[at.cell].push_back({at.s, at.t, x[k]});
  }
  if (!target.tangents) return;
  // Interpolating the fixed points afterwards would change the tangent planes. With a large weight,
  // the fit itself almost passes through them.
  constexpr double fixed_weight = 1e4;
  for (const Vec2& uv : target.fixed) {
    const BoundaryCells::CellPoint at = cells.at(uv);
    cells_[at.cell].push_back({at.s, at.t, target.position(uv), fixed_weight});
  }
  for (const PatchTangent& tangent : target.tangents(longest)) {
    const BoundaryCells::CellPoint at = cells.at(tangent.uv);
    tangents_[at.cell].push_back(
        {at.s, at.t, at.size.x() * tangent.x_u, at.size.y() * tangent.x_v});
  }
}

double CellSamples::bending() const {
  double sum = 0, count = 0;
  for (size_t cell = 0; cell < cells_.size(); ++cell) {
    if (!full_[cell]) continue;
    const auto& x = cells_[cell];
    for (size_t k = 0; k < 4; ++k) {
      const size_t s = k, t = 4 * k;
      sum += 64 * (x[s].x - x[s + 4].x - x[s + 8].x + x[s + 12].x).squaredNorm() +
             64 * (x[t].x - x[t + 1].x - x[t + 2].x + x[t + 3].x).squaredNorm();
    }
    count += 4;
  }
  return count > 0 ? sum / count : 0;
}

BicubicPatch fit_to_samples(const SplineAxis& u, const SplineAxis& v, const CellSamples& samples,
                            const PatchGoal& goal) {
  const double unit = samples.bending(), misfit = 0.01 * goal.deviation;
  const double bending_weight = unit > 0 ? misfit * misfit / unit : 1;
  for (double bending = std::clamp(bending_weight, 1e-10, 1e-6); bending < 1; bending *= 100)
    if (auto patch = PatchEquations(u, v, samples, bending, goal).solve()) return *patch;
  throw NoSolutionError("no B-spline surface can be fitted: check that all samples are finite");
}

}  // namespace batten
