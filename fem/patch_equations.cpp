#include "batten/fem/patch_equations.h"

#include <algorithm>
#include <array>
#include <numbers>
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

/// The normal equations of samples and bending.
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
    // Far from the samples it only has to be stiff beside what is near them.
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

  /// None when the matrix is singular to rounding.
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

  /// The first 16 samples of a cell that is full: products of four places each way.
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
  // The symmetric matrix by functions' distance: (i, j) with (i + di, j + dj), di, dj in -3 … 3.
  std::vector<std::array<double, 49>> entries_;
  Points poles_;  // the right-hand side, then the solution
  // Of one cell.
  Eigen::Matrix<double, 16, 16> A_;
  Eigen::Matrix<double, 16, 3> b_;
};

/// The cells in which places of the rim lie.
class BoundaryCells {
 public:
  struct CellPoint {
    size_t cell;
    double s, t;  // in it
    Vec2 size;    // of it
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
  /// A share of the shortest side of all cells: faces meet along their rims, so these count for more than
  /// what is inside where cells are coarse. No less than that share of a third of the place's own cell:
  /// where knots crowd elsewhere, most of the work would be the rim's.
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
  // What is moved to its fixed points afterwards turns: here the fit passes through them by itself.
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
  throw NoSolutionError("a B-spline surface cannot be fitted: numbers that are not finite?");
}

}  // namespace batten
