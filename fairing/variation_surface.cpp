#include "batten/fairing/variation_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/elimination_order.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/fairing/fairable.h"
#include "batten/fairing/variation_terms.h"
#include "batten/fem/element_pattern.h"

namespace batten {
namespace {

// [x; y; z] = D y + d0 as rows, whether the constraints are coupled or not.
class StackedReduction {
 public:
  explicit StackedReduction(const ConstraintSet& constraints)
      : reduction_(constraints),
        one_(reduction_.D()),
        n_(static_cast<int>(one_.rows()) / (reduction_.coupled() ? 3 : 1)),
        free_(reduction_.free_count()) {}

  bool coupled() const { return reduction_.coupled(); }
  int free_count() const { return coupled() ? free_ : 3 * free_; }
  /// Calls take(free unknown, coefficient) for the row of one dof of one coordinate.
  template <class Take>
  void row(int coordinate, int dof, const Take& take) const {
    const int r = coupled() ? coordinate * n_ + dof : dof;
    for (Rows::InnerIterator it(one_, r); it; ++it)
      take(coupled() ? static_cast<int>(it.col()) : coordinate * free_ + static_cast<int>(it.col()),
           it.value());
  }
  VecX free_part(const Points& x) const {
    VecX y(free_count());
    for (int f = 0; f < free_count(); ++f)
      y[f] = coupled() ? x(reduction_.free_dofs()[f] % n_, reduction_.free_dofs()[f] / n_)
                       : x(reduction_.free_dofs()[f % free_], f / free_);
    return y;
  }
  Points expand(const VecX& y) const {
    return reduction_.expand(coupled() ? MatX(y) : MatX(y.reshaped(free_, 3)));
  }
  /// An order for the factor of A, over the free unknowns.
  std::vector<int> order(const SparseMatrix& A) const {
    if (coupled()) return elimination_order(A, Expected::many_factors);
    const SparseMatrix one = A.topLeftCorner(free_, free_);
    std::vector<int> all;
    for (const int f : elimination_order(one, Expected::many_factors))
      for (int c = 0; c < 3; ++c) all.push_back(c * free_ + f);
    return all;
  }

 private:
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  AffineReduction reduction_;
  Rows one_;
  int n_, free_;
};

// What an element's unknowns are in terms of its free ones: x = T y + …, entry by entry.
struct ReducedElement {
  struct Entry {
    int unknown, free;
    double factor;
  };
  std::vector<Entry> entries;
  int free_count = 0;
};

// K = Tᵀ A T. Most rows of T have one entry.
template <int n>
void reduce(const ReducedElement& element, const Eigen::Matrix<double, n, n>& A, double* K) {
  Eigen::Matrix<double, n, Eigen::Dynamic> AT(n, element.free_count);
  AT.setZero();
  for (const auto& [unknown, free, factor] : element.entries)
    AT.col(free) += factor * A.col(unknown);
  Eigen::Map<MatX> all(K, element.free_count, element.free_count);
  all.setZero();
  for (const auto& [unknown, free, factor] : element.entries)
    all.row(free) += factor * AT.row(unknown);
}

// The largest move of a vertex along the normal.
double normal_move(const Surface& from, const Surface& to) {
  double most = 0;
  for (int v = 0; v < from.mesh().vertex_count(); ++v) {
    const int d = from.dof_map().vertex(v);
    const Vec3 u = from.dofs().row(d + 1), w = from.dofs().row(d + 2);
    const Vec3 way = to.dofs().row(d) - from.dofs().row(d);
    most = std::max(most, std::abs(u.cross(w).normalized().dot(way)));
  }
  return most;
}

class Descent {
 public:
  Descent(const Surface& start, const ConstraintSet& constraints, const VariationOptions& options)
      : surface_(start),
        reduction_(constraints),
        terms_(start, options.gauss, options.jumps),
        y_(reduction_.free_part(start.dofs())),
        gradient_(VecX::Zero(y_.size())) {
    surface_ = at(y_);
    for (const auto& side : options.sides) terms_.add_side(surface_, side);
    make_pattern();
  }

  const Surface& surface() const { return surface_; }
  double value() const { return terms_.value(surface_); }

  // Steps until the shape stands.
  void run(const VariationOptions& options, const Progress& progress, VariationSurface& result) {
    const double length = terms_.length();
    constexpr double little = 0.01;  // of the functional: not worth a step
    for (int calm = 0; result.iterations < options.most_iterations && !result.converged;) {
      progress.at("fairing", static_cast<double>(result.iterations) / options.most_iterations);
      terms_.set_frames(surface_);
      const double before = linearise();
      if (!std::isfinite(before))
        throw InputError("the surface to be faired has no normal somewhere");
      const Step step = descend(before, result);
      if (!step.taken) {
        result.converged = step.promised < little * before;  // otherwise it is stuck
        return;
      }
      ++result.iterations;
      calm = step.move < 5e-4 * length ? calm + 1 : 0;
      result.converged = calm == 2 || (step.gain < little * before && step.move < 2e-3 * length);
    }
  }

 private:
  struct Step {
    bool taken = false;
    double promised = 0, gain = 0, move = 0;  ///< promised: by the first try
  };

  Surface at(const VecX& y) const {
    return {surface_.shared_mesh(), surface_.kind(), reduction_.expand(y), surface_.trim()};
  }
  int triangle_count() const { return surface_.mesh().triangle_count(); }

  // Triangles, then interior edges.
  void make_pattern() {
    std::vector<int> starts(1, 0), unknowns;
    const auto add = [&](const auto& dofs) {
      elements_.push_back(reduced_element(dofs, unknowns));
      starts.push_back(count_of(unknowns));
    };
    for (int t = 0; t < triangle_count(); ++t) add(surface_.dof_map().triangle(surface_.mesh(), t));
    for (const int e : terms_.edges()) add(VariationTerms::edge_dofs(surface_, e));
    starts_ = starts;
    unknowns_ = unknowns;
    pattern_.emplace(reduction_.free_count(), std::move(starts), std::move(unknowns));
    matrix_ = pattern_->zero();
  }

  // Appends the free unknowns of an element with these dofs of one coordinate.
  template <class Dofs>
  ReducedElement reduced_element(const Dofs& dofs, std::vector<int>& unknowns) const {
    ReducedElement element;
    for (int c = 0, local = 0; c < 3; ++c)
      for (const int dof : dofs) {
        reduction_.row(c, dof, [&](int free, double factor) {
          element.entries.push_back({local, free, factor});
        });
        ++local;
      }
    std::vector<int> own;
    for (const auto& entry : element.entries) own.push_back(entry.free);
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    for (auto& entry : element.entries)
      entry.free =
          static_cast<int>(std::lower_bound(own.begin(), own.end(), entry.free) - own.begin());
    element.free_count = count_of(own);
    unknowns.insert(unknowns.end(), own.begin(), own.end());
    return element;
  }

  // The matrix JᵀJ + e T + λ B, the gradient, and the value.
  double linearise() {
    const int count = count_of(elements_);
    std::vector<std::atomic<char>> taken(count);
    std::vector<double> values(count);
    std::vector<VecX> slopes(count);
    pattern_->assemble(
        [&](int e, double* K) {
          const bool first = taken[e].exchange(1) == 0;  // elements that threads share come twice
          const auto keep = [&](const auto& terms) {
            if (!first) return;
            values[e] = terms.value;
            slopes[e] = terms.gradient;
          };
          if (e < triangle_count()) {
            const TriangleTerms terms = terms_.triangle(surface_, e, {evenness_, damping_});
            reduce(elements_[e], terms.normal, K);
            keep(terms);
          } else {
            const EdgeTerms terms = terms_.edge(surface_, terms_.edges()[e - triangle_count()]);
            reduce(elements_[e], terms.normal, K);
            keep(terms);
          }
        },
        matrix_);
    gradient_.setZero();
    double sum = 0;
    for (int e = 0; e < count; ++e) {
      sum += values[e];
      for (const auto& [unknown, free, factor] : elements_[e].entries)
        gradient_[unknowns_[starts_[e] + free]] += factor * slopes[e][unknown];
    }
    return sum;
  }

  Step descend(double before, VariationSurface& result) {
    constexpr int most_tries = 12;
    Step step;
    for (int k = 0; k < most_tries; ++k) {
      if (result.factorizations++ == 0) cholesky_.analyze(matrix_, reduction_.order(matrix_));
      if (!cholesky_.factorize(matrix_)) throw NoSolutionError(cholesky_.message());
      const VecX way = -cholesky_.solve(gradient_);
      const double promised = -gradient_.dot(way);
      if (k == 0) step.promised = promised;
      const Surface next = at(y_ + way);
      const double gain = before - terms_.value(next);
      if (gain > 0) {
        step.taken = true;
        step.gain = gain;
        step.move = normal_move(surface_, next);
        y_ += way;
        surface_ = next;
        const bool good = gain > 0.5 * promised;
        if (good) evenness_ = std::max(0.3, 0.3 * evenness_);
        damping_ *= good ? 0.1 : 0.5;
        return step;
      }
      if (promised < 1e-9 * before) break;
      damping_ = std::max(8 * damping_, 1e-2);
      evenness_ = std::min(4 * evenness_, 100.0);
      linearise();
    }
    return step;
  }

  Surface surface_;
  StackedReduction reduction_;
  VariationTerms terms_;
  VecX y_, gradient_;
  std::vector<ReducedElement> elements_;
  std::vector<int> starts_, unknowns_;
  std::optional<ElementPattern> pattern_;
  SparseMatrix matrix_;
  SparseCholesky cholesky_;
  double evenness_ = 10, damping_ = 1e-2;
};

}  // namespace

VariationSurface fair_variation(const Surface& start, const ConstraintSet& constraints,
                                const VariationOptions& options, const Progress& progress) {
  if (start.kind() != TriangleElement::HCT)
    throw InputError("found Z12 triangles, expected HCT: their third derivatives are needed");
  require_fairable(start, constraints);
  Descent descent(start, constraints, options);
  VariationSurface result;
  result.start_functional = descent.value();
  descent.run(options, progress, result);
  result.functional = descent.value();
  result.dofs = descent.surface().dofs();
  result.max_move = normal_move(start, descent.surface());
  result.max_residual = constraints.max_residual(result.dofs);
  return result;
}

}  // namespace batten
