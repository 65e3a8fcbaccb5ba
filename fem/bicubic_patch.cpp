#include "batten/fem/bicubic_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/sparse_cholesky.h"

namespace batten {
namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

/// ∫₀¹ of products of the derivatives on one interval.
Mat4 gram(const SplineAxis& axis, int interval, int derivative) {
  Mat4 G = Mat4::Zero();
  constexpr double place[4] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                               0.93056815579702629};
  constexpr double weight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                0.17392742256872693};
  for (int g = 0; g < 4; ++g) {
    const Vec4 b = axis.basis(interval, place[g], derivative);
    G += weight[g] * b * b.transpose();
  }
  return G;
}

struct Sample {
  double s, t;  // in its cell
  Vec3 x;
};

/// Samples by cell: cell i · v.intervals() + j.
class CellSamples {
 public:
  /// n×n in each cell, at the given places of [0, 1], and points of the rim.
  CellSamples(const PatchTarget& target, const SplineAxis& u, const SplineAxis& v,
              const std::vector<double>& places, const std::vector<Vec2>& rim)
      : cells_(static_cast<size_t>(u.intervals()) * v.intervals()), full_(cells_.size()) {
    parallel_parts(u.intervals(), [&](int i) {
      for (int j = 0; j < v.intervals(); ++j) {
        const size_t cell = static_cast<size_t>(i) * v.intervals() + j;
        for (const double s : places)
          for (const double t : places) {
            const Vec2 uv(u.knots()[i] + s * u.length(i), v.knots()[j] + t * v.length(j));
            if (target.inside(uv)) cells_[cell].push_back({s, t, target.position(uv)});
          }
        full_[cell] = cells_[cell].size() == places.size() * places.size();
      }
    });
    std::vector<Vec3> x(rim.size());
    const int parts = static_cast<int>(std::min<size_t>(rim.size(), 64));
    parallel_parts(parts, [&](int part) {
      const size_t from = rim.size() * part / parts, to = rim.size() * (part + 1) / parts;
      for (size_t k = from; k < to; ++k) x[k] = target.position(rim[k]);
    });
    for (size_t k = 0; k < rim.size(); ++k) {
      const double a = u.wrapped(rim[k].x()), b = v.wrapped(rim[k].y());
      const int i = u.interval(a), j = v.interval(b);
      cells_[static_cast<size_t>(i) * v.intervals() + j].push_back(
          {(a - u.knots()[i]) / u.length(i), (b - v.knots()[j]) / v.length(j), x[k]});
    }
  }
  const std::vector<Sample>& of(size_t cell) const { return cells_[cell]; }

  /// Mean square of the second derivatives in units of the cells, by differences; of samples at
  /// four even places a quarter apart.
  double bending() const {
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

 private:
  std::vector<std::vector<Sample>> cells_;
  std::vector<char> full_;  // all places of the cell are inside
};

/// Cells within three of one that has samples: only these have functions in common with it.
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

/// None when the matrix is singular to rounding.
std::optional<BicubicPatch> solved(const SplineAxis& u, const SplineAxis& v,
                                   const CellSamples& samples, double bending) {
  // Far from the samples it only has to be stiff beside what is near them.
  constexpr double sample_weight = 1.0 / 16;
  const double bending_outside = 1e4 * bending;
  const int rows = u.functions(), columns = v.functions();
  const int unknowns = rows * columns;
  const auto near = near_samples(samples, u, v);
  std::vector<std::array<Mat4, 3>> gram_v;
  for (int j = 0; j < v.intervals(); ++j)
    gram_v.push_back({gram(v, j, 0), gram(v, j, 1), gram(v, j, 2)});

  // The symmetric matrix by functions' distance: (i, j) with (i + di, j + dj), di, dj in -3 … 3.
  std::vector<std::array<double, 49>> entries(static_cast<size_t>(unknowns));
  for (auto& e : entries) e.fill(0);
  BicubicPatch patch{u, v, Points::Zero(unknowns, 3)};
  Eigen::Matrix<double, 16, 16> A;
  Eigen::Matrix<double, 16, 3> b;
  Eigen::Matrix<double, 16, 1> N;
  for (int i = 0; i < u.intervals(); ++i) {
    const std::array<Mat4, 3> gram_u{gram(u, i, 0), gram(u, i, 1), gram(u, i, 2)};
    for (int j = 0; j < v.intervals(); ++j) {
      const size_t cell = static_cast<size_t>(i) * v.intervals() + j;
      const double e = near[cell] ? bending : bending_outside;
      for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 4; ++c)
          A.block<4, 4>(4 * a, 4 * c) =
              e * (gram_u[2](a, c) * gram_v[j][0] + 2 * gram_u[1](a, c) * gram_v[j][1] +
                   gram_u[0](a, c) * gram_v[j][2]);
      b.setZero();
      for (const Sample& sample : samples.of(cell)) {
        const Vec4 Nu = u.basis(i, sample.s), Nv = v.basis(j, sample.t);
        for (int a = 0; a < 4; ++a) N.segment<4>(4 * a) = Nu[a] * Nv;
        A.noalias() += sample_weight * N * N.transpose();
        b.noalias() += sample_weight * N * sample.x.transpose();
      }
      for (int a = 0; a < 16; ++a) {
        const size_t row = static_cast<size_t>(u.function(i, a / 4)) * columns + j + a % 4;
        patch.poles.row(static_cast<long>(row)) += b.row(a);
        for (int c = 0; c < 16; ++c)
          entries[row][7 * (c / 4 - a / 4 + 3) + c % 4 - a % 4 + 3] += A(a, c);
      }
    }
  }
  std::vector<Triplet> triplets;
  triplets.reserve(static_cast<size_t>(unknowns) * 25);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      for (int k = 0; k < 49; ++k) {
        const double value = entries[static_cast<size_t>(i) * columns + j][k];
        int other = i + k / 7 - 3;
        if (u.periodic()) other = (other + rows) % rows;
        const int row = i * columns + j, column = other * columns + j + k % 7 - 3;
        if (value != 0 && row >= column) triplets.emplace_back(row, column, value);
      }
  SparseMatrix K(unknowns, unknowns);
  K.setFromTriplets(triplets.begin(), triplets.end());
  SparseCholesky cholesky;
  cholesky.analyze(K);
  if (!cholesky.factorize(K)) return std::nullopt;
  cholesky.solve_in_place(patch.poles);
  return patch;
}

/// With the strongest bending that costs no more than a hundredth of the goal.
BicubicPatch least_squares(const SplineAxis& u, const SplineAxis& v, const CellSamples& samples,
                           double goal) {
  const double unit = samples.bending(), misfit = 0.01 * goal;
  const double calm = unit > 0 ? misfit * misfit / unit : 1;
  for (double bending = std::clamp(calm, 1e-10, 1e-6); bending < 1; bending *= 100)
    if (auto patch = solved(u, v, samples, bending)) return *patch;
  throw NoSolutionError("a B-spline surface cannot be fitted: numbers that are not finite?");
}

Vec3 position_in(const BicubicPatch& patch, int i, int j, double s, double t) {
  const Vec4 Nu = patch.u.basis(i, s), Nv = patch.v.basis(j, t);
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < 4; ++a) {
    const long row = static_cast<long>(patch.u.function(i, a)) * patch.v.functions() + j;
    x += Nu[a] * (patch.poles.middleRows<4>(row).transpose() * Nv);
  }
  return x;
}

/// Largest |S - x| in each cell; raises what is there.
void raise_errors(const BicubicPatch& patch, const CellSamples& samples,
                  std::vector<double>& errors) {
  const int n = patch.v.intervals();
  parallel_parts(patch.u.intervals(), [&](int i) {
    for (int j = 0; j < n; ++j) {
      const size_t cell = static_cast<size_t>(i) * n + j;
      for (const Sample& sample : samples.of(cell))
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

}  // namespace

Vec3 BicubicPatch::position(const Vec2& uv) const {
  const double a = u.wrapped(uv.x()), b = v.wrapped(uv.y());
  const int i = u.interval(a), j = v.interval(b);
  return position_in(*this, i, j, (a - u.knots()[i]) / u.length(i),
                     (b - v.knots()[j]) / v.length(j));
}

PatchFit fit_bicubic_patch(const PatchTarget& target, double goal, const PatchLimits& limits,
                           const BicubicPatch* start) {
  constexpr int most_rounds = 16;
  const Vec2 extent = target.high - target.low;
  const auto first = [&](double length) {
    return std::max(4, static_cast<int>(std::lround(8 * length / extent.maxCoeff())));
  };
  SplineAxis u = uniform(target.low.x(), target.high.x(), first(extent.x()), target.periodic);
  SplineAxis v = uniform(target.low.y(), target.high.y(), first(extent.y()), false);
  if (start) {
    u = start->u;
    v = start->v;
  }
  PatchFit best;
  best.deviation = std::numeric_limits<double>::infinity();
  long progress = 1;  // poles when the deviation last fell
  double lowest = best.deviation;
  int sparer = 0;
  for (int round = 1; round <= most_rounds; ++round) {
    const auto shortest = [](const SplineAxis& axis) {
      double length = axis.length(0);
      for (int k = 1; k < axis.intervals(); ++k) length = std::min(length, axis.length(k));
      return length;
    };
    const double spacing = std::min(shortest(u), shortest(v)) / 4;
    const CellSamples fitted(target, u, v, {0.125, 0.375, 0.625, 0.875}, target.rim(spacing));
    const CellSamples others(target, u, v, {0, 0.5}, target.rim(0.7 * spacing));
    const BicubicPatch patch = least_squares(u, v, fitted, goal);

    std::vector<double> errors(static_cast<size_t>(u.intervals()) * v.intervals(), 0.0);
    raise_errors(patch, others, errors);
    const double deviation = *std::max_element(errors.begin(), errors.end());
    raise_errors(patch, fitted, errors);
    const bool reached = deviation <= goal;
    const bool fewer = patch.poles.rows() < best.patch.poles.rows();
    const bool progressed = deviation <= 0.8 * lowest;
    if (progressed) {
      lowest = deviation;
      progress = patch.poles.rows();
    }
    if (best.reached ? reached && fewer : reached || deviation < best.deviation)
      best = {patch, deviation, reached};
    if (best.reached && (!reached || deviation > 0.3 * goal || ++sparer > 2)) break;
    if (!best.reached && patch.poles.rows() > 12 * progress) break;

    // Where, and in which direction, the next knots go.
    const double aim = 0.6 * goal;
    const auto in_u = fourth_differences(patch, 0), in_v = fourth_differences(patch, 1);
    const double least = reached || (round <= 4 && !start) ? 0.6 : 1.0;
    std::vector<double> factor_u(static_cast<size_t>(u.intervals()), least),
        factor_v(static_cast<size_t>(v.intervals()), least);
    for (int i = 0; i < u.intervals(); ++i)
      for (int j = 0; j < v.intervals(); ++j) {
        const size_t cell = static_cast<size_t>(i) * v.intervals() + j;
        const double both = std::max(in_u[cell], in_v[cell]);
        if (!(both > 0) || errors[cell] == 0) continue;
        const auto wanted = [&](double part) {
          return std::min(2.0, std::pow(errors[cell] * part / both / aim, 0.25));
        };
        factor_u[i] = std::max(factor_u[i], wanted(in_u[cell]));
        factor_v[j] = std::max(factor_v[j], wanted(in_v[cell]));
      }
    const auto finer = [&](double growth) {
      return std::pair{redistributed(u, factor_u, growth, limits.a_direction - 3),
                       redistributed(v, factor_v, growth, limits.a_direction - 3)};
    };
    const double before = static_cast<double>(patch.poles.rows());
    const auto poles = [](const auto& axes) {
      return static_cast<double>(axes.first.functions()) * axes.second.functions();
    };
    double growth = 1;
    auto next = finer(growth);
    while (!reached && poles(next) < (progressed ? 1.15 : 1.6) * before && growth < 2)
      next = finer(growth *= 1.08);
    while (poles(next) > limits.in_all) next = finer(growth *= 0.97);
    if (!reached && poles(next) <= 1.02 * before) break;  // at the limits
    if (reached && poles(next) >= before) break;
    u = next.first;
    v = next.second;
  }
  return best;
}

}  // namespace batten
