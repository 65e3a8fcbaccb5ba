// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/surface_curvature.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/AutoDiff>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fairing/minimum_variation/block_reduction.h"
#include "batten/fem/element_pattern.h"

namespace batten {
namespace {

constexpr int kResiduals = 9, kLocal = 15, kElement = 36;
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, kLocal, 1>>;
template <class T>
using Vector = Eigen::Matrix<T, 3, 1>;

using LocalJet = Eigen::Matrix<double, 3, 5>;  // columns X_u, X_v, X_uu, X_uv, X_vv

// Residuals √J (S11, √2 S12, S22), then `parametrization_weight` (its square root) times the
// tangential parts of the change of the second derivatives from those of the anchor. d: X_u … X_vv.
// The frame is e1 along X_u, e2 = n × e1: X_u = a e1, X_v = b e1 + c e2.
template <class T>
void residuals_at(const Vector<T> d[5], const LocalJet& anchor, double parametrization_weight,
                  T r[kResiduals]) {
  using std::sqrt;
  const Vector<T> m = d[0].cross(d[1]);
  const T J = sqrt(m.dot(m)), a = sqrt(d[0].dot(d[0]));
  const Vector<T> n = m / J, e1 = d[0] / a, e2 = n.cross(e1);
  const T b = d[1].dot(e1), c = J / a, root = sqrt(J);
  const T L = n.dot(d[2]), M = n.dot(d[3]), N = n.dot(d[4]);
  const T S11 = L / (a * a), S12 = (M / a - b * S11) / c;
  const T S22 = (N - b * b * S11 - T(2.0) * b * c * S12) / (c * c);
  const double root2 = std::sqrt(2.0);
  r[0] = root * S11;
  r[1] = root * S12 * root2;
  r[2] = root * S22;
  for (int k = 0; k < 3; ++k) {
    const double weight = parametrization_weight * (k == 1 ? root2 : 1);
    const Vector<T> change = d[2 + k] - anchor.col(2 + k);
    r[3 + 2 * k] = e1.dot(change) * weight;
    r[4 + 2 * k] = e2.dot(change) * weight;
  }
}

using ElementMatrix = Eigen::Matrix<double, kElement, kElement>;

struct Element {
  double functional = 0, total = 0;             // functional without and with the parametrisation
                                                // term
  Eigen::Matrix<double, kElement, 1> gradient;  // half of the gradient of `total`, in the order [x;
                                                // y; z]
  ElementMatrix normal;                         // Gauss-Newton matrix JᵀJ
};

// Integrates over one triangle. `derivatives`: also gradient and normal matrix.
Element integrate(const Surface& surface, const Surface& anchor, int triangle,
                  double parametrization_weight, bool derivatives) {
  Element sum;
  sum.gradient.setZero();
  sum.normal.setZero();
  const TriangleShape shape = surface.mesh().shape(triangle);
  const C1Triangle element(surface.kind(), shape);
  const TriangleRule& rule = C1Triangle::default_quadrature(surface.kind());
  const auto q = surface.triangle_dofs(triangle), q_anchor = anchor.triangle_dofs(triangle);
  for (long p = 0; p < rule.weights.size(); ++p) {
    const Eigen::Matrix<double, 12, 5> N =
        element.evaluate(rule.L.row(p).transpose()).rightCols<5>();
    const LocalJet jet = q.transpose() * N, anchor_jet = q_anchor.transpose() * N;
    const double weight = rule.weights[p] * shape.area;
    if (!(jet.col(0).cross(jet.col(1)).squaredNorm() > 0)) {
      sum.functional = sum.total = std::numeric_limits<double>::infinity();
      return sum;
    }
    Eigen::Matrix<double, kResiduals, 1> r;
    if (!derivatives) {
      Vec3 d[5];
      for (int k = 0; k < 5; ++k) d[k] = jet.col(k);
      residuals_at(d, anchor_jet, parametrization_weight, r.data());
    } else {
      Vector<Dual> d[5];
      for (int k = 0; k < 5; ++k)
        for (int c = 0; c < 3; ++c) d[k][c] = Dual(jet(c, k), kLocal, 5 * c + k);
      Dual with_slopes[kResiduals];
      residuals_at(d, anchor_jet, parametrization_weight, with_slopes);
      Eigen::Matrix<double, kResiduals, kElement> slopes;
      for (int i = 0; i < kResiduals; ++i) {
        r[i] = with_slopes[i].value();
        for (int c = 0; c < 3; ++c)
          slopes.row(i).segment<12>(12 * c) =
              (N * with_slopes[i].derivatives().segment<5>(5 * c)).transpose();
      }
      sum.gradient.noalias() += weight * slopes.transpose() * r;
      sum.normal.noalias() += weight * slopes.transpose() * slopes;
    }
    sum.functional += weight * r.head<3>().squaredNorm();
    sum.total += weight * r.squaredNorm();
  }
  return sum;
}

std::vector<Element> integrate(const Surface& surface, const Surface& anchor,
                               double parametrization_weight, bool derivatives) {
  std::vector<Element> all(surface.mesh().triangle_count());
  parallel_for_each<16>(isize(all), [&](int t) {
    all[t] = integrate(surface, anchor, t, parametrization_weight, derivatives);
  });
  return all;
}

double total(const std::vector<Element>& elements) {
  double sum = 0;
  for (const Element& e : elements) sum += e.total;
  return sum;
}

// Dofs of [x; y; z] of each triangle.
std::vector<int> stacked_dofs(const Surface& surface) {
  std::vector<int> all;
  const int n = surface.dof_map().count();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (int c = 0; c < 3; ++c)
      for (const int dof : surface.dof_map().triangle(surface.mesh(), t))
        all.push_back(c * n + dof);
  return all;
}

VecX gathered_gradient(const Surface& surface, const std::vector<Element>& elements) {
  const std::vector<int> dofs = stacked_dofs(surface);
  VecX g = VecX::Zero(3L * surface.dof_map().count());
  for (size_t t = 0; t < elements.size(); ++t)
    for (int a = 0; a < kElement; ++a) g[dofs[kElement * t + a]] += elements[t].gradient[a];
  return g;
}

// Lower triangle of Dᵀ A D, from the lower triangle of A.
SparseMatrix reduced(const SparseMatrix& A, const SparseMatrix& D) {
  const SparseMatrix full = A.selfadjointView<Eigen::Lower>();
  const SparseMatrix AD = full * D;
  return SparseMatrix(SparseMatrix(D.transpose()) * AD).triangularView<Eigen::Lower>();
}

double parameter_area(const ParametricMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) sum += mesh.shape(t).area;
  return sum;
}

// Levenberg-Marquardt over the free unknowns y, [x; y; z] = D y + d0.
class LevenbergMarquardt {
 public:
  LevenbergMarquardt(const Surface& start, const ConstraintSet& constraints,
                     double parametrization_weight)
      : surface_(start),
        reduction_(constraints),
        pattern_(3 * start.dof_map().count(), kElement, stacked_dofs(start)),
        stacked_(pattern_.zero()) {
    D_ = reduction_.D();
    y_ = reduction_.free_part(start.dofs());
    surface_ = at(y_);

    const double per_area = parameter_area(start.mesh()) / start.area();
    root_ = std::sqrt(parametrization_weight * per_area);
    pattern_.assemble(
        [&](int t, double* K) {
          Eigen::Map<ElementMatrix> all(K);
          all.setZero();
          const Mat12 one = C1Triangle(start.kind(), start.mesh().shape(t)).stiffness({});
          for (int c = 0; c < 3; ++c) all.block<12, 12>(12 * c, 12 * c) = per_area * one;
        },
        stacked_);
    bending_ = reduced(stacked_, D_);
    cholesky_.analyze(bending_, FactorReuse::many);
    if (!cholesky_.factorize(bending_)) throw NoSolutionError(cholesky_.message());
    if (!std::isfinite(total(integrate(surface_, surface_, root_, false))))
      throw InputError("the surface to be faired is singular: it has no normal at some point");
  }

  const Surface& surface() const { return surface_; }
  int iterations() const { return iterations_; }

  // Minimises with the current surface as anchor. Returns false if the iterations do not suffice.
  bool minimize(int max_iterations) {
    const Surface anchor = surface_;
    while (iterations_ < max_iterations) {
      const std::vector<Element> elements = integrate(surface_, anchor, root_, true);
      const double now = total(elements);
      const VecX g = D_.transpose() * gathered_gradient(surface_, elements);
      pattern_.assemble(
          [&](int t, double* K) { Eigen::Map<ElementMatrix>{K} = elements[t].normal; }, stacked_);
      const SparseMatrix normal = reduced(stacked_, D_);
      for (bool better = false; !better;) {
        if (++iterations_ > max_iterations) return false;
        if (!cholesky_.factorize(normal + damping_ * bending_))
          throw NoSolutionError(cholesky_.message());
        const VecX step = -cholesky_.solve(g);
        constexpr double small = 1e-11;  // fraction of the functional, far below the gain of a
                                         // round
        if (-g.dot(step) <= small * now) return true;
        const Surface next = at(y_ + step);
        better = total(integrate(next, anchor, root_, false)) < now;
        if (better) {
          y_ += step;
          surface_ = next;
        }
        constexpr double least = 1e-9;
        damping_ = better ? std::max(0.2 * damping_, least) : 8 * damping_;
      }
    }
    return false;
  }

 private:
  Surface at(const VecX& y) const {
    return {surface_.shared_mesh(), surface_.kind(), reduction_.expand(y)};
  }

  Surface surface_;
  BlockReduction reduction_;
  ElementPattern pattern_;
  SparseMatrix stacked_, D_, bending_;
  VecX y_;
  SparseCholesky cholesky_;
  double root_ = 0, damping_ = 1e-2;
  int iterations_ = 0;
};

}  // namespace

double curvature_functional(const Surface& surface, Points* gradient) {
  const std::vector<Element> elements = integrate(surface, surface, 0, gradient != nullptr);
  double sum = 0;
  for (const Element& e : elements) sum += e.functional;
  if (gradient)
    *gradient = 2 * Eigen::Map<const Points>(gathered_gradient(surface, elements).eval().data(),
                                             surface.dof_map().count(), 3);
  return sum;
}

SurfaceCurvatureResult fair_curvature(const Surface& start, const ConstraintSet& constraints,
                                      const SurfaceCurvatureOptions& options) {
  if (!(options.parametrization_weight > 0) || !(options.tolerance > 0) || options.max_rounds < 1 ||
      options.max_iterations < 1)
    throw InputError(
        "parametrization_weight, tolerance, max_rounds and max_iterations must be above 0");
  check_fairing_input(start, constraints);

  // Relative to a point of the surface, so that coordinates keep their digits.
  VecX ones = VecX::Zero(start.dof_map().count());
  for (int v = 0; v < start.mesh().vertex_count(); ++v) ones[start.dof_map().vertex(v)] = 1;
  const Vec3 origin = start.dofs().row(start.dof_map().vertex(0));
  LevenbergMarquardt descent(
      Surface(start.shared_mesh(), start.kind(), start.dofs() - ones * origin.transpose()),
      constraints.translated(ones, origin), options.parametrization_weight);

  SurfaceCurvatureResult result;
  result.start_functional = result.functional = curvature_functional(descent.surface());
  for (bool converged = true;
       converged && !result.converged && result.rounds < options.max_rounds;) {
    converged = descent.minimize(options.max_iterations);
    ++result.rounds;
    const double before = result.functional;
    result.functional = curvature_functional(descent.surface());
    result.converged = converged && before - result.functional <= options.tolerance * before;
  }
  result.iterations = descent.iterations();
  result.dofs = descent.surface().dofs() + ones * origin.transpose();
  result.max_residual = constraints.max_residual(result.dofs);
  return result;
}

}  // namespace batten
