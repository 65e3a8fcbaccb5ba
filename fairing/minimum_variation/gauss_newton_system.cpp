// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/gauss_newton_system.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <type_traits>

#include "batten/core/containers.h"
#include "batten/core/simd.h"

namespace batten {
namespace {

typedef double Lanes __attribute__((vector_size(64), aligned(8), may_alias));
constexpr int kLanes = 8;

// Computes y += factor x for `parts` groups of eight numbers.
BATTEN_INLINE void add_multiple(double factor, const Lanes* x, Lanes* y, int parts) {
  for (int p = 0; p < parts; ++p) y[p] += factor * x[p];
}

// Inner products of `across` columns with `along` others.
template <int across, int along>
BATTEN_INLINE void block(const Lanes* const* a, const Lanes* const* b, int parts, int n,
                         double* K) {
  Lanes sum[across][along] = {};
  for (int p = 0; p < parts; ++p)
    for (int i = 0; i < across; ++i)
      for (int j = 0; j < along; ++j) sum[i][j] += a[i][p] * b[j][p];
  for (int i = 0; i < across; ++i)
    for (int j = 0; j < along; ++j) {
      const Lanes& s = sum[i][j];
      K[i * n + j] = ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
    }
}

// Computes K = JᵀJ of n columns, each with `parts` groups of eight numbers; K is n×n, n a multiple
// of four.
BATTEN_CLONES void square(const Lanes* columns, int stride, int parts, int n, double* K) {
  for (int i = 0; i < n; i += 2)
    for (int j = 0; j <= i; j += 4) {
      const Lanes *a[2], *b[4];
      for (int k = 0; k < 2; ++k) a[k] = columns + (i + k) * stride;
      for (int k = 0; k < 4; ++k) b[k] = columns + (j + k) * stride;
      block<2, 4>(a, b, parts, n, K + i * n + j);
    }
}

struct Multiple {
  int from, to;
  double factor;
};
// Adds multiples of columns of `from` to columns of `to`.
BATTEN_CLONES void combine(const Multiple* multiples, size_t count, const Lanes* from, Lanes* to,
                           int stride, int parts) {
  for (size_t k = 0; k < count; ++k)
    add_multiple(multiples[k].factor, from + multiples[k].from * stride,
                 to + multiples[k].to * stride, parts);
}

// Fills with zeros up to the next multiple of eight rows.
template <class Rows>
void pad(Rows& rows) {
  const int end = (rows.count + kLanes - 1) / kLanes * kLanes;
  for (auto& column : rows.J) std::fill(column + rows.count, column + end, 0.0);
}

// Computes K = JᵀJ of n columns with two rows each; both triangles of K are set.
BATTEN_CLONES void square_two_rows(const double* columns, int stride, int n, double* first,
                                   double* second, double* K) {
  for (int i = 0; i < n; ++i) {
    first[i] = columns[i * stride];
    second[i] = columns[i * stride + 1];
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) K[i * n + j] = first[i] * first[j] + second[i] * second[j];
}

// Computes K = Tᵀ A T for a symmetric A of m columns; scratch `half`: m×n numbers.
BATTEN_CLONES void reduce_square(const Multiple* multiples, size_t count, const double* A, int m,
                                 int stride, int n, double* half, double* K) {
  std::fill_n(half, m * n, 0.0);
  for (size_t k = 0; k < count; ++k)
    for (int i = 0; i < m; ++i)
      half[i * n + multiples[k].to] += multiples[k].factor * A[multiples[k].from * stride + i];
  std::fill_n(K, n * n, 0.0);
  for (size_t k = 0; k < count; ++k)
    for (int j = 0; j < n; ++j)
      K[multiples[k].to * n + j] += multiples[k].factor * half[multiples[k].from * n + j];
}

struct Scratch {
  std::vector<double> columns, square, half;
  std::vector<Multiple> multiples;
};

// Copies the lower triangle of the square and mirrors it.
void copy_square(const double* square, int stride, int n, double* K) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) K[i * n + j] = K[j * n + i] = square[i * stride + j];
}

}  // namespace

GaussNewtonSystem::GaussNewtonSystem(const CurvatureVariationTerms& terms, const Surface& surface,
                                     const RowMatrix& T, RowMatrix constraints)
    : constraints_(std::move(constraints)),
      first_entry_(1, 0),
      starts_(1, 0),
      pattern_([&] {
        const ParametricMesh& mesh = surface.mesh();
        for (int t = 0; t < mesh.triangle_count(); ++t)
          add_element(T, surface.dof_map().triangle(mesh, t));
        for (const int e : terms.edges())
          add_element(T, CurvatureVariationTerms::edge_dofs(surface, e));
        for (int j = 0; j < terms.join_count(); ++j) add_element(T, terms.join_dofs(surface, j));
        for (int r = 0; r < constraints_.rows(); ++r) {
          for (RowMatrix::InnerIterator it(constraints_, r); it; ++it)
            unknowns_.push_back(static_cast<int>(it.col()));
          starts_.push_back(isize(unknowns_));
        }
        return ElementPattern(static_cast<int>(T.cols()), starts_, unknowns_);
      }()),
      matrix_(pattern_.zero()),
      gradient_(VecX::Zero(T.cols())),
      values_(starts_.size() - 1),
      slopes_(unknowns_.size()) {}

template <class Dofs>
void GaussNewtonSystem::add_element(const RowMatrix& T, const Dofs& dofs) {
  const int n = static_cast<int>(T.rows()) / 3;
  std::vector<int> own;
  const size_t begin = entries_.size();
  int row = 0;
  for (int c = 0; c < 3; ++c)
    for (const int dof : dofs) {
      for (int k = T.outerIndexPtr()[c * n + dof]; k < T.outerIndexPtr()[c * n + dof + 1]; ++k) {
        own.push_back(T.innerIndexPtr()[k]);
        entries_.push_back({k, row, own.back()});
      }
      ++row;
    }
  std::sort(own.begin(), own.end());
  own.erase(std::unique(own.begin(), own.end()), own.end());
  for (size_t k = begin; k < entries_.size(); ++k)
    entries_[k].column = static_cast<int>(
        std::lower_bound(own.begin(), own.end(), entries_[k].column) - own.begin());
  unknowns_.insert(unknowns_.end(), own.begin(), own.end());
  starts_.push_back(isize(unknowns_));
  first_entry_.push_back(entries_.size());
}

template <class Rows>
void GaussNewtonSystem::reduce(const Rows& rows, int element, const RowMatrix& T, bool first,
                               double* K) {
  constexpr int stride = Rows::most / kLanes;
  const int n = starts_[element + 1] - starts_[element], padded = (n + 3) / 4 * 4;
  const int parts = (rows.count + kLanes - 1) / kLanes;
  thread_local Scratch scratch;
  scratch.columns.assign(static_cast<size_t>(padded) * Rows::most, 0.0);
  scratch.multiples.clear();
  for (size_t k = first_entry_[element]; k < first_entry_[element + 1]; ++k)
    if (const double factor = T.valuePtr()[entries_[k].value]; factor != 0)
      scratch.multiples.push_back({entries_[k].row, entries_[k].column, factor});
  Lanes* columns = reinterpret_cast<Lanes*>(scratch.columns.data());
  combine(scratch.multiples.data(), scratch.multiples.size(),
          reinterpret_cast<const Lanes*>(rows.J), columns, stride, parts);
  constexpr int own = static_cast<int>(std::extent_v<decltype(rows.J)>);
  if constexpr (Rows::most == kLanes) {
    scratch.half.resize(2 * static_cast<size_t>(n));
    square_two_rows(scratch.columns.data(), Rows::most, n, scratch.half.data(),
                    scratch.half.data() + n, K);
  } else if (n <= own) {
    scratch.square.resize(static_cast<size_t>(padded) * padded);
    square(columns, stride, parts, padded, scratch.square.data());
    copy_square(scratch.square.data(), padded, n, K);
  } else {  // a constraint connects many unknowns to the element
    static_assert(own % 4 == 0);
    scratch.square.resize(2 * own * own);
    double* mirrored = scratch.square.data() + own * own;
    square(reinterpret_cast<const Lanes*>(rows.J), stride, parts, own, scratch.square.data());
    copy_square(scratch.square.data(), own, own, mirrored);
    scratch.half.resize(static_cast<size_t>(own) * n);
    reduce_square(scratch.multiples.data(), scratch.multiples.size(), mirrored, own, own, n,
                  scratch.half.data(), K);
  }
  if (!first) return;
  const auto dot = [&](const double* column) {
    double sum = 0;
    for (int r = 0; r < rows.count; ++r) sum += column[r] * rows.r[r];
    return sum;
  };
  for (int i = 0; i < n; ++i)
    slopes_[starts_[element] + i] =
        dot(scratch.columns.data() + static_cast<size_t>(i) * Rows::most);
  values_[element] = dot(rows.r);
}

void GaussNewtonSystem::update_penalty_weights() {
  constexpr double times = 1e4;
  penalty_weights_ = penalty_weights(constraints_, matrix_.diagonal(), times);
}

VecX GaussNewtonSystem::step(const SparseCholesky& cholesky) const {
  return solve_augmented_lagrangian(cholesky, gradient_, constraints_, penalty_weights_);
}

double GaussNewtonSystem::assemble(const CurvatureVariationTerms& terms, const Surface& surface,
                                   const DampingWeights& weights, const RowMatrix& T) {
  const int triangles = surface.mesh().triangle_count();
  const int edges = triangles + isize(terms.edges());
  const int joins = edges + terms.join_count();
  std::vector<std::atomic<char>> taken(values_.size());
  pattern_.assemble(
      [&](int e, double* K) {
        if (e >= joins) {
          const int n = starts_[e + 1] - starts_[e];
          const double* b = constraints_.valuePtr() + constraints_.outerIndexPtr()[e - joins];
          const double w = penalty_weights_.size() > 0 ? penalty_weights_[e - joins] : 0;
          for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) K[i * n + j] = w * b[i] * b[j];
          return;
        }
        const bool first = taken[e].exchange(1) == 0;  // elements shared by two threads are visited
                                                       // twice
        const auto add = [&](auto& rows) {
          pad(rows);
          reduce(rows, e, T, first, K);
        };
        if (e < triangles) {
          TriangleResiduals rows;
          terms.triangle(surface, e, weights, rows);
          add(rows);
        } else if (e < edges) {
          EdgeResiduals rows;
          terms.edge(surface, terms.edges()[e - triangles], rows);
          add(rows);
        } else {
          JoinResiduals rows;
          terms.join(surface, e - edges, rows);
          add(rows);
        }
      },
      matrix_);
  if (penalty_weights_.size() < constraints_.rows()) {
    update_penalty_weights();
    return assemble(terms, surface, weights, T);
  }
  gradient_.setZero();
  for (size_t k = 0; k < unknowns_.size(); ++k) gradient_[unknowns_[k]] += slopes_[k];
  double sum = 0;
  for (const double value : values_) sum += value;
  return sum;
}

namespace {

// Normals N and their derivatives: along u and v at vertices, across the edge at its midpoint.
// Second derivatives differ between adjacent triangles; the slopes are averaged.
struct NormalField {
  std::vector<Vec3> vertex, by_u, by_v, edge, across;

  explicit NormalField(const Surface& surface)
      : vertex(surface.mesh().vertex_count(), Vec3::Zero()),
        by_u(vertex),
        by_v(vertex),
        edge(surface.mesh().edge_count(), Vec3::Zero()),
        across(edge) {
    const ParametricMesh& mesh = surface.mesh();
    std::vector<int> at_vertex(vertex.size()), at_edge(edge.size());
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        const int v = mesh.triangles()[t][i], e = mesh.edges_of(t)[i];
        Vec3 L = Vec3::Unit(i);
        Slopes slopes;
        vertex[v] += normal_at(surface.jet({t, L}), slopes);
        by_u[v] += slopes.col(0);
        by_v[v] += slopes.col(1);
        ++at_vertex[v];
        L = (Vec3::Ones() - Vec3::Unit(i)) / 2;
        edge[e] += normal_at(surface.jet({t, L}), slopes);
        across[e] += slopes * mesh.edge_normal(e);
        ++at_edge[e];
      }
    for (size_t v = 0; v < vertex.size(); ++v) {
      vertex[v].normalize();
      by_u[v] /= at_vertex[v];
      by_v[v] /= at_vertex[v];
    }
    for (size_t e = 0; e < edge.size(); ++e) {
      edge[e].normalize();
      across[e] /= at_edge[e];
    }
  }

  // Normal at the vertex or edge of a dof.
  const Vec3& normal(int dof) const {
    const int edges = 3 * isize(vertex);
    return dof < edges ? vertex[dof / 3] : edge[dof - edges];
  }

 private:
  using Slopes = Eigen::Matrix<double, 3, 2>;

  // Derivatives of the normal by the Weingarten equations: n_a = -Σ_b (g⁻¹ II)_ba X_b.
  static Vec3 normal_at(const SurfaceJet& jet, Slopes& slopes) {
    const Vec3 n = jet.normal();
    Slopes X;
    X << jet.x_u, jet.x_v;
    const double uv = n.dot(jet.x_uv);
    Mat2 II;
    II << n.dot(jet.x_uu), uv, uv, n.dot(jet.x_vv);
    slopes = -X * ((X.transpose() * X).inverse() * II);
    return n;
  }
};

}  // namespace

NormalVariation::NormalVariation(const BlockReduction& reduction, const Surface& start)
    : reduction_(reduction), unknown_of_(reduction.dof_count(), -1) {
  const int n = reduction.dof_count();
  const NormalField field(start);
  std::vector<Vec3> free_displacement(
      n, Vec3::Zero());  // displacement of each dof by a unit step along its
                         // free coordinates
  for (int f = 0; f < reduction.free_count(); ++f) {
    const int row = reduction.free_rows()[f], dof = row % n;
    const double step = field.normal(dof)[row / n];
    for (int c = 0; c < 3; ++c)
      free_displacement[dof][c] += reduction.D().coeff(c * n + dof, f) * step;
  }
  for (int dof = 0; dof < n; ++dof)
    if (const double length = free_displacement[dof].norm();
        length > 0.1 && field.normal(dof).dot(free_displacement[dof]) > 0.5 * length)
      unknown_of_[dof] = count_++;
}

template <class Put>
void NormalVariation::scalar_row(int dof, const Put& put) const {
  if (unknown_of_[dof] >= 0 || reduction_.coupled()) {
    if (unknown_of_[dof] >= 0) put(unknown_of_[dof], 1.0);
    return;
  }
  for (RowMatrix::InnerIterator it(reduction_.D(), dof); it; ++it)
    if (const int unknown = unknown_of_[reduction_.free_rows()[it.col()]]; unknown >= 0)
      put(unknown, it.value());
}

RowMatrix NormalVariation::reduced_rows(const RowMatrix& rows) const {
  std::vector<Triplet> entries;
  for (int r = 0; r < rows.rows(); ++r)
    for (RowMatrix::InnerIterator it(rows, r); it; ++it)
      scalar_row(static_cast<int>(it.col()), [&](int unknown, double fraction) {
        entries.emplace_back(r, unknown, it.value() * fraction);
      });
  RowMatrix own(rows.rows(), count_);
  own.setFromTriplets(entries.begin(), entries.end());
  return own;
}

RowMatrix NormalVariation::at(const Surface& surface) const {
  const int n = reduction_.dof_count(), edges = surface.dof_map().edge(0);
  const ParametricMesh& mesh = surface.mesh();
  const NormalField field(surface);
  std::vector<Triplet> entries;
  for (int f = 0; f < reduction_.free_count(); ++f) {
    const int row = reduction_.free_rows()[f], dof = row % n, c = row / n;
    const auto add = [&](int of, double factor) {
      scalar_row(of, [&](int unknown, double fraction) {
        entries.emplace_back(f, unknown, factor * fraction);
      });
    };
    if (unknown_of_[dof] >= 0) add(dof, field.normal(dof)[c]);
    if (dof < edges) {
      const int v = dof / 3, slope = dof % 3;
      if (slope > 0) add(3 * v, (slope == 1 ? field.by_u : field.by_v)[v][c]);
    } else {
      const int e = dof - edges;
      // φ at the midpoint, by the cubic Hermite interpolant along the edge.
      const Vec2 edge_step = mesh.edge_length(e) / 8 * mesh.edge_tangent(e);
      const double across = field.across[e][c];
      for (const auto& [v, sign] :
           {std::pair{mesh.edges()[e].low, 1}, std::pair{mesh.edges()[e].high, -1}}) {
        add(3 * v, across / 2);
        add(3 * v + 1, sign * across * edge_step.x());
        add(3 * v + 2, sign * across * edge_step.y());
      }
    }
  }
  RowMatrix steps(reduction_.free_count(), count_);
  steps.setFromTriplets(entries.begin(), entries.end());
  return reduction_.D() * steps;
}

}  // namespace batten
